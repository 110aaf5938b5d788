#pragma once

#include <string>
#include <string_view>

#include "tests/support/places.h"

namespace floatstage {

/// A shell's words that run `command` under a virtual display of 1280×1024 of its own, and end as it does.
/// The GL driver of a window unloads itself before leaks are looked for, so what it keeps cannot be told from
/// ours.
inline std::string under_display(std::string_view command) {
  return "ASAN_OPTIONS=detect_leaks=0 " + (source_folder() / "tests/support/under_display.sh").string() +
         " " + std::string(command);
}

}  // namespace floatstage
