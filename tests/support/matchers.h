#pragma once

// The words our tests are written in: EXPECT_THAT(load_rig(file), FailsWith(ErrorCode::BadData, "camera
// 'left'")).

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include <gmock/gmock.h>

#include "core/image.h"
#include "core/result.h"
#include "core/text.h"

namespace floatstage {

inline void describe(const Error& error, testing::MatchResultListener* listener) {
  *listener << "which is the error " << name_of(error.code) << ": \"" << error.message << '"';
}

/// Shown by gtest instead of the bytes of a Result.
template <class T>
void PrintTo(const Result<T>& result, std::ostream* out) {
  if (result)
    *out << "a value";
  else
    *out << "error " << name_of(result.error().code) << ": \"" << result.error().message << '"';
}

MATCHER(IsOk, negation ? "is an error" : "is no error") {
  if (!arg) describe(arg.error(), result_listener);
  return arg.has_value();
}

/// The Result holds a value that `inner` matches: EXPECT_THAT(parse_ply(…), IsOkAnd(Field(&Mesh::positions,
/// SizeIs(3)))).
MATCHER_P(IsOkAnd, inner,
          "holds a value that " +
              testing::DescribeMatcher<typename std::decay_t<arg_type>::value_type>(inner, negation)) {
  if (!arg) {
    describe(arg.error(), result_listener);
    return false;
  }
  return testing::ExplainMatchResult(inner, *arg, result_listener);
}

/// The Result is an error of that code whose sentence contains `part`.
MATCHER_P2(FailsWith, code, part,
           text(negation ? "does not fail" : "fails", " with ", name_of(code), " saying \"", part, '"')) {
  if (arg) {
    *result_listener << "which succeeded";
    return false;
  }
  describe(arg.error(), result_listener);
  return arg.error().code == code && arg.error().message.find(part) != std::string::npos;
}

/// Peak signal-to-noise ratio in dB over all channels; infinite for equal images, -1 when sizes differ.
inline double psnr(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels || a.empty()) return -1;
  double squares = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = static_cast<double>(a.pixels[i]) - b.pixels[i];
    squares += d * d;
  }
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.pixels.size()) / squares);
}

/// The image has the size of `expected` and differs from it by at least `decibels` of PSNR (more is nearer).
MATCHER_P2(ImageNear, expected, decibels,
           text(negation ? "is not" : "is", " within ", decibels, " dB of the expected image")) {
  const double actual = psnr(arg, expected);
  *result_listener << "a " << arg.width << "x" << arg.height << "x" << arg.channels << " image of " << actual
                   << " dB";
  return actual >= decibels;
}

}  // namespace floatstage
