#pragma once

#include <filesystem>

namespace floatstage {

/// A wide photograph and a closer one of a part of it, and the graph that says so, in a folder.
inline constexpr const char *kWidePhoto = "wide.jpg", *kClosePhoto = "close.tif", *kZoomGraph = "graph.json";
void write_zoom_folder(const std::filesystem::path& folder);

/// The graph anew, of the photographs' bytes as they are now: who sends others sends their graph, too.
void write_zoom_graph(const std::filesystem::path& folder);

}  // namespace floatstage
