#pragma once

namespace floatstage {

/// Whether a sanitizer runs. It takes ten times as long, keeps what was freed, needs terabytes of addresses,
/// is loaded before anything else, and ends a crash in its own way.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace floatstage
