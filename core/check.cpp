#include "core/check.h"

#include "core/text.h"

namespace floatstage {

void throw_check_failure(const char* condition, const char* file, int line, const std::string& context) {
  throw CheckFailure(text("check failed: ", condition, " (", file, ":", line, "): ", context));
}

}  // namespace floatstage
