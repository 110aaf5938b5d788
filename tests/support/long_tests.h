#pragma once

#include <cstdlib>
#include <string_view>

#include <gtest/gtest.h>

namespace floatstage {

/// Whether the long form of every test is wanted: FLOATSTAGE_LONG=1 in the environment.
inline bool wants_long_tests() {
  const char* wanted = std::getenv("FLOATSTAGE_LONG");
  return wanted != nullptr && std::string_view(wanted) == "1";
}

}  // namespace floatstage

/// Leaves a test that repeats, with another seed, what a shorter run has shown already.
#define FLOATSTAGE_LONG_FORM(repetition)                                                       \
  do {                                                                                         \
    if ((repetition) && !::floatstage::wants_long_tests())                                     \
      GTEST_SKIP() << "one seed is tried in the short form; FLOATSTAGE_LONG=1 tries them all"; \
  } while (false)
