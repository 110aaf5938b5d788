#pragma once

#include <stdexcept>
#include <string>

namespace floatstage {

/// Thrown by FLOATSTAGE_CHECK: a bug of ours, never bad input. Caught only in `main`, logged, exit code 70.
class CheckFailure : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void throw_check_failure(const char* condition, const char* file, int line,
                                      const std::string& context);

}  // namespace floatstage

/// States what our own code guarantees. A failure names the file without its folders: the program's bytes do
/// not depend on where it was built. `context` is any string expression and is evaluated only on failure.
#define FLOATSTAGE_CHECK(condition, context)                                                        \
  do {                                                                                              \
    if (!(condition)) [[unlikely]]                                                                  \
      ::floatstage::throw_check_failure(#condition, __FILE_NAME__, __LINE__, std::string(context)); \
  } while (false)
