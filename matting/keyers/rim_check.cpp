#include "matting/keyers/rim_check.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "matting/keyers/backing_field.h"

namespace floatstage::matting {
namespace {

constexpr double kMostSubject = 0.5;  // of the rim: more contradicts what the keyer believes of it

}  // namespace

int rim_width(int width, int height) {
  return static_cast<int>(FieldOptions().rim * std::max(width, height));
}

Result<void> check_rim(const Image& alpha, const FrameInfo& info, std::string_view sought) {
  const int rim = rim_width(alpha.width, alpha.height);
  if (rim == 0) return {};
  long seen = 0, subject = 0;
  const auto count = [&](int y, int x0, int x1) {
    const std::uint8_t* row = alpha.at(0, y);
    int in_row = 0;
    for (int x = x0; x < x1; ++x) in_row += row[x] >> 7;
    subject += in_row, seen += x1 - x0;
  };
  for (int y = 0; y < alpha.height; ++y) {
    if (y < rim || y >= alpha.height - rim || 2 * rim >= alpha.width) {
      count(y, 0, alpha.width);
    } else {
      count(y, 0, rim);
      count(y, alpha.width - rim, alpha.width);
    }
  }
  return check_rim(static_cast<double>(subject) / static_cast<double>(seen), info, sought);
}

Result<void> check_rim(double share, const FrameInfo& info, std::string_view sought) {
  if (share <= kMostSubject) return {};
  return fail(
      ErrorCode::Unsupported,
      text("camera ", info.camera, " shows no ", sought, " along ", std::lround(100 * share),
           " % of its picture's rim, so its matte would be wrong; try the method 'consistent' or a plate, "
           "or give mattes"));
}

}  // namespace floatstage::matting
