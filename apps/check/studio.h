#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "apps/check/machine.h"
#include "core/result.h"

namespace floatstage::apps {

/// What a studio's config needs of this machine: each camera is started once, its page's port tried, and the
/// disk of its takes measured against what the cameras deliver. Errors: those of load_capture_config();
/// Cancelled once `stop`, which is asked while cameras start, from several threads, says yes.
Result<std::vector<Finding>> look_at_studio(const std::filesystem::path& config,
                                            const std::function<bool()>& stop = {});

}  // namespace floatstage::apps
