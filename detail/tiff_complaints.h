#pragma once

#include <string>

namespace floatstage::detail {

/// What every handle that we give libtiff begins with: its first complaint about that file. libtiff's
/// handlers are of the whole process; keep_complaints() sets them once, so that nothing goes to a terminal.
struct TiffHandle {
  std::string complaint;
};
void keep_complaints();

}  // namespace floatstage::detail
