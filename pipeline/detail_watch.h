#pragma once

#include "detail/watch.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// A job's progress as the stage `detail` watches its work; it must outlive that.
inline detail::Watch watched_by(Progress& job) {
  return {[&job](const char* what, std::size_t total) { job.begin(what, total); }, [&job] { job.advance(1); },
          [&job] { job.end(); }, [&job] { return job.cancelled(); }};
}

}  // namespace floatstage::pipeline
