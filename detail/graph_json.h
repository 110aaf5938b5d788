#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/result.h"
#include "detail/photo_graph.h"

namespace floatstage::detail {

/// The graph as JSON (docs/detail.md), with the folder of its photographs as it is to be found from the
/// document's own; and back. BadData, naming it, for what is no such document: an unknown or missing key, a
/// parent that is not there, a circle, a homography that folds.
std::string graph_to_json(const PhotoGraph& graph, const std::filesystem::path& folder_of_document);
Result<PhotoGraph> graph_from_json(std::string_view json, std::string_view name_for_errors,
                                   const std::filesystem::path& folder_of_document);

/// load: NotFound, Io, and what graph_from_json() says. save: Io.
Result<PhotoGraph> load_graph(const std::filesystem::path& file);
Result<void> save_graph(const PhotoGraph& graph, const std::filesystem::path& file);

/// The graph in Graphviz's language: photographs that have a parent or a child, edges with zoom and inliers,
/// and, dotted, photographs that were related and refused, with the reason.
std::string graph_to_dot(const PhotoGraph& graph);

}  // namespace floatstage::detail
