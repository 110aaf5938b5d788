#pragma once

#include <string_view>

namespace floatstage::log {

enum class Level { Debug, Info, Warning, Error, Off };

/// Messages below this level are not written. All go to standard error, one line each, and never to standard
/// output (that belongs to results). Safe from any thread.
void set_level(Level level);

void debug(std::string_view message);
void info(std::string_view message);
void warning(std::string_view message);
void error(std::string_view message);

}  // namespace floatstage::log
