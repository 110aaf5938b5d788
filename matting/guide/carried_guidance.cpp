#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/guide/guided_matte.h"
#include "matting/image_mat.h"
#include "matting/picture_scale.h"
#include "matting/video/flow_carry.h"

namespace floatstage::matting {
namespace {

constexpr double kReach = 0.03;    // of the longer side: room around a change for its motion
constexpr double kWithin = 0.006;  // likewise, by how much a carried change may grow
constexpr int kWorkingPixels = 130'000;
constexpr int kSure = 192;  // of 255: a carried pixel is in the change

// Where a person turned pixels to `side`, but for what is thinner than an outline's doubt.
Image change_to(std::uint8_t side, const Image& base, const Image& matte) {
  Image raw(base.width, base.height, 1), out(base.width, base.height, 1);
  for (std::size_t p = 0; p < raw.pixels.size(); ++p)
    raw.pixels[p] =
        (base.pixels[p] >= 128) != (matte.pixels[p] >= 128) && (matte.pixels[p] >= 128) == (side == 255) ? 255
                                                                                                         : 0;
  cv::Mat to = as_mat(out);
  cv::morphologyEx(as_mat(raw), to, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return out;
}

// Writes `side` over what is 128 in `followed` where `change` has pixels of pieces that touch no pixel which
// is written already, grown by `reach`: these were not found again.
void stay_where_lost(const Image& change, std::uint8_t side, int reach, Image& followed) {
  cv::Mat pieces, near;
  const int count = cv::connectedComponents(as_mat(change), pieces, 8, CV_32S);
  cv::dilate(as_mat(followed) == side, near,
             cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}));
  std::vector<bool> found(static_cast<std::size_t>(count));
  for (int y = 0; y < change.height; ++y)
    for (int x = 0; x < change.width; ++x)
      if (near.at<std::uint8_t>(y, x)) found[static_cast<std::size_t>(pieces.at<int>(y, x))] = true;
  for (int y = 0; y < change.height; ++y)
    for (int x = 0; x < change.width; ++x) {
      const int piece = pieces.at<int>(y, x);
      if (piece > 0 && !found[static_cast<std::size_t>(piece)]) *followed.at(x, y) = side;
    }
}

}  // namespace

CarriedGuidance carried_guidance(const Image& neighbour, const Image& neighbours_base,
                                 const Image& neighbours_matte, const Image& picture, const Image& base) {
  for (const Image* image : {&neighbour, &neighbours_base, &neighbours_matte, &base})
    FLOATSTAGE_CHECK(image->width == picture.width && image->height == picture.height, "frames of one size");
  CarriedGuidance out;
  const int w = picture.width, h = picture.height, longer = std::max(w, h);
  for (const int side : {255, 0}) {
    const Image change = change_to(static_cast<std::uint8_t>(side), neighbours_base, neighbours_matte);
    cv::Rect box = cv::boundingRect(as_mat(change));
    if (box.empty()) continue;
    if (out.said.empty()) {
      out.said = out.followed = Image(w, h, 1, 128);
      out.within = Image(w, h, 1);
    }
    const int reach = std::max(16, static_cast<int>(std::lround(kReach * longer)));
    box = cv::Rect(box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach) &
          cv::Rect(0, 0, w, h);
    const double shrink = std::min(1.0, std::sqrt(kWorkingPixels / static_cast<double>(box.area())));
    const int sw = std::max(16, static_cast<int>(std::lround(box.width * shrink))),
              sh = std::max(16, static_cast<int>(std::lround(box.height * shrink)));
    const auto small = [&](const Image& image) { return scaled(part_of(image, box), sw, sh); };
    const Carried carried = carry_matte(small(neighbour), small(change), small(picture));
    Image sure(sw, sh, 1), near = carried.matte;
    const Image there = carried.matte;
    for (std::size_t p = 0; p < sure.pixels.size(); ++p)
      sure.pixels[p] = carried.matte.pixels[p] >= kSure && !carried.doubt.pixels[p] ? 255 : 0;
    cv::Mat core;
    cv::erode(as_mat(sure), core, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
    if (cv::countNonZero(core) > 0) core.copyTo(as_mat(sure));
    const int grow = std::max(1, static_cast<int>(std::lround(kWithin * longer * shrink)));
    cv::dilate(as_mat(near), as_mat(near),
               cv::getStructuringElement(cv::MORPH_RECT, {2 * grow + 1, 2 * grow + 1}));
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x) {
        const int u = std::min(sw - 1, static_cast<int>((x + 0.5) * sw / box.width)),
                  v = std::min(sh - 1, static_cast<int>((y + 0.5) * sh / box.height));
        const bool fault = (*base.at(box.x + x, box.y + y) >= 128) != (side == 255);
        if (*sure.at(u, v) && fault) *out.said.at(box.x + x, box.y + y) = static_cast<std::uint8_t>(side);
        if (*there.at(u, v) >= 128) *out.followed.at(box.x + x, box.y + y) = static_cast<std::uint8_t>(side);
        if (*near.at(u, v) >= 128) *out.within.at(box.x + x, box.y + y) = 255;
      }
    stay_where_lost(change, static_cast<std::uint8_t>(side), reach, out.followed);
  }
  return out;
}

}  // namespace floatstage::matting
