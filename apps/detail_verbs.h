#pragma once

#include <filesystem>
#include <string>

#include "apps/progress_bar.h"
#include "apps/verbs.h"
#include "core/image.h"
#include "detail/photo_graph.h"
#include "detail/watch.h"

namespace floatstage::apps {

/// The bar as the stage `detail` watches its work; the bar must outlive it.
inline detail::Watch watched_by(ProgressBar& bar) {
  return {[&bar](const char* what, std::size_t total) { bar.begin(what, total); }, [&bar] { bar.advance(1); },
          [&bar] { bar.end(); }, [&bar] { return bar.cancelled(); }};
}

/// Whether this is the name of a .png or .jpg file, and the picture as one.
bool is_picture_file(const std::filesystem::path& file);
Result<void> save_picture(const Image& picture, const std::filesystem::path& file);
/// `--root`, when it is given.
Result<void> take_root(detail::PhotoGraph& graph, const std::string& name);

void add_detail_compose(CLI::App& detail, Chosen& chosen);
void add_detail_synthesize(CLI::App& detail, Chosen& chosen);

}  // namespace floatstage::apps
