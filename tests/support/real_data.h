#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/places.h"

namespace floatstage {

/// A set of the recorded data beside the checkout (tests labelled `real`).
inline std::filesystem::path real_data(const std::string& set) { return data_folder() / set; }

inline bool on_ci() {
  const char* ci = std::getenv("CI");
  return ci != nullptr && std::string(ci) == "true";
}

}  // namespace floatstage

/// Leaves the test (or SetUp) when the data is not on this machine. It may be absent on a laptop, never in
/// the checks that guard the main branch: there it is a failure.
#define FLOATSTAGE_NEEDS_DATA(folder)                                 \
  do {                                                                \
    if (!std::filesystem::exists(folder)) {                           \
      if (::floatstage::on_ci()) FAIL() << (folder) << " is missing"; \
      GTEST_SKIP() << (folder) << " is not on this machine";          \
    }                                                                 \
  } while (false)
