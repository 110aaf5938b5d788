#pragma once

#include <filesystem>
#include <string>

#include "apps/terminal/verb.h"
#include "core/image.h"
#include "detail/photo_graph.h"

namespace floatstage::apps {

/// Whether this is the name of a .png or .jpg file, and the picture as one.
bool is_picture_file(const std::filesystem::path& file);
Result<void> save_picture(const Image& picture, const std::filesystem::path& file);
/// `--root`, when it is given.
Result<void> take_root(detail::PhotoGraph& graph, const std::string& name);

/// `detail`, and its sub-verbs that have files of their own.
void add_detail(CLI::App& app, Chosen& chosen);
void add_detail_compose(CLI::App& detail, Chosen& chosen);
void add_detail_synthesize(CLI::App& detail, Chosen& chosen);
void add_detail_view(CLI::App& detail, Chosen& chosen);

}  // namespace floatstage::apps
