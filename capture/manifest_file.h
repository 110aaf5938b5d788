#pragma once

// Private to capture/.

#include "core/take_layout.h"

namespace floatstage::capture {

/// The manifest of a take. NotFound says that the folder is none; BadData, Io.
Result<TakeManifest> load_manifest(const TakeLayout& layout);

}  // namespace floatstage::capture
