#pragma once

#include <functional>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"

namespace floatstage::calib {

/// Fails with a sentence that holds every one of `parts`.
template <class T>
void expect_error(const Result<T>& result, ErrorCode code, const std::vector<std::string>& parts) {
  ASSERT_FALSE(result.has_value());
  EXPECT_STREQ(name_of(result.error().code), name_of(code)) << result.error().message;
  for (const std::string& part : parts) EXPECT_THAT(result.error().message, testing::HasSubstr(part));
}

inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the test's sample has no '" << from << "'";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Calls `parse` on every prefix of `whole` that lacks at least two of its characters (less than that is a
/// shorter last number): each must come back as an error or as a rig with fewer cameras, and must never
/// crash.
inline void expect_truncations_refused(std::string_view whole, std::size_t cameras,
                                       const std::function<Result<ForeignRig>(std::string_view)>& parse) {
  const std::size_t last = whole.find_last_not_of(" \r\n") + 1;
  for (std::size_t length = 0; length + 1 < last; ++length) {
    const Result<ForeignRig> rig = parse(whole.substr(0, length));
    EXPECT_TRUE(!rig.has_value() || rig->rig.cameras.size() < cameras) << "cut after " << length << " bytes";
  }
}

/// Three cameras around a stage, every one different; 2×2 pixels big with the principal point at the exact
/// centre when `tiny`, else 640×480 and off centre.
Rig sample_rig(const Lens& lens, bool tiny = false);

/// Same serials, and everything else within `tolerance`; sizes only where `b` states them.
void expect_same(const Rig& a, const Rig& b, double tolerance = 1e-12);

}  // namespace floatstage::calib
