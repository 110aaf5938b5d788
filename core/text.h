#pragma once

#include <sstream>
#include <string>

namespace floatstage {

/// Writes its arguments one after the other, as operator<< does: text("camera ", i, " has no matte").
template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return std::move(out).str();
}

}  // namespace floatstage
