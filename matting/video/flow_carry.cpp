#include "matting/video/flow_carry.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/check.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr float kLoop = 1.5f;  // px by which there and back may miss
constexpr float kColour =
    40;  // 8-bit steps, summed over channels' mean, by which a followed pixel may change

cv::Mat grey(const Image& rgb) {
  cv::Mat out;
  cv::cvtColor(as_mat(rgb), out, cv::COLOR_RGB2GRAY);
  return out;
}

cv::Mat flow(const cv::Mat& a, const cv::Mat& b) {
  const cv::Ptr<cv::DISOpticalFlow> dis = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
  cv::Mat out;
  dis->calc(a, b, out);
  return out;
}

}  // namespace

Carried carry_matte(const Image& from, const Image& matte, const Image& to) {
  FLOATSTAGE_CHECK(from.width == to.width && from.height == to.height && matte.width == to.width &&
                       matte.height == to.height,
                   "frames of one size");
  const cv::Mat a = grey(from), b = grey(to), back = flow(b, a), there = flow(a, b);
  cv::Mat place(back.size(), CV_32FC2);
  for (int y = 0; y < back.rows; ++y)
    for (int x = 0; x < back.cols; ++x)
      place.at<cv::Vec2f>(y, x) =
          back.at<cv::Vec2f>(y, x) + cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
  cv::Mat warped, returned, colour;
  cv::remap(as_mat(matte), warped, place, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::remap(there, returned, place, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::remap(as_mat(from), colour, place, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  Carried out{Image(to.width, to.height, 1), Image(to.width, to.height, 1)};
  for (int y = 0; y < back.rows; ++y) {
    for (int x = 0; x < back.cols; ++x) {
      *out.matte.at(x, y) = warped.at<std::uint8_t>(y, x);
      const cv::Vec2f miss = back.at<cv::Vec2f>(y, x) + returned.at<cv::Vec2f>(y, x);
      const cv::Vec3b was = colour.at<cv::Vec3b>(y, x);
      float change = 0;
      for (int c = 0; c < 3; ++c) change += std::abs(static_cast<float>(was[c]) - to.at(x, y)[c]);
      if (cv::norm(miss) > kLoop || change > 3 * kColour) *out.doubt.at(x, y) = 255;
    }
  }
  return out;
}

}  // namespace floatstage::matting
