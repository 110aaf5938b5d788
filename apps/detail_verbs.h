#pragma once

#include "apps/progress_bar.h"
#include "apps/verbs.h"
#include "detail/watch.h"

namespace floatstage::apps {

/// The bar as the stage `detail` watches its work; the bar must outlive it.
inline detail::Watch watched_by(ProgressBar& bar) {
  return {[&bar](const char* what, std::size_t total) { bar.begin(what, total); }, [&bar] { bar.advance(1); },
          [&bar] { bar.end(); }, [&bar] { return bar.cancelled(); }};
}

void add_detail_compose(CLI::App& detail, Chosen& chosen);

}  // namespace floatstage::apps
