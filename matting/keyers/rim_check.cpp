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
  for (int y = 0; y < alpha.height; ++y) {
    const bool all = y < rim || y >= alpha.height - rim;
    for (int x = 0; x < alpha.width; ++x) {
      if (!all && x >= rim && x < alpha.width - rim) continue;
      ++seen;
      subject += *alpha.at(x, y) >= 128;
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
