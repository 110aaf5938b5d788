// Method:  matter that came to light beside a label, by how far flow draws it out over many frames
// Paper:   none; flow as in T. Kroeger and others, "Fast optical flow using dense inverse search", 2016
// ADR:     0333

#include "matting/labels/label_descent.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr int kApart = 4;         // px to each side: half a patch of the flow, which resolves nothing smaller
constexpr float kOwn = 0.3f;      // of its area now is what matter had: less was mostly not seen then
constexpr int kThin = 7;          // px: thinner is an edge that flow blurs
constexpr double kOutside = 0.4;  // of the border of what is new: its label does not hold it
constexpr int kRenewed = 24;      // frames after which flow has gone astray by itself

// Of what is set in `mask`, the parts that lie at least `kOutside` of their border against other labels.
cv::Mat hanging(const cv::Mat& mask, const Image& labels, int label) {
  cv::Mat part;
  const int parts = cv::connectedComponents(mask, part, 4, CV_32S);
  std::vector<long> border(static_cast<std::size_t>(parts)), outside(border.size());
  for (int y = 0; y < part.rows; ++y)
    for (int x = 0; x < part.cols; ++x) {
      const int here = part.at<int>(y, x);
      if (here == 0) continue;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (x + dx < 0 || x + dx >= part.cols || y + dy < 0 || y + dy >= part.rows ||
            part.at<int>(y + dy, x + dx) == here)
          continue;
        ++border[static_cast<std::size_t>(here)];
        outside[static_cast<std::size_t>(here)] += *labels.at(x + dx, y + dy) != label;
      }
    }
  cv::Mat out(mask.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < part.rows; ++y)
    for (int x = 0; x < part.cols; ++x) {
      const auto here = static_cast<std::size_t>(part.at<int>(y, x));
      if (here != 0 && static_cast<double>(outside[here]) >= kOutside * static_cast<double>(border[here]))
        out.at<std::uint8_t>(y, x) = 255;
    }
  return out;
}

}  // namespace

LabelDescent::LabelDescent(int width, int height)
    : width_(width), height_(height), since_(here()), next_(since_), area_(areas()) {}

LabelDescent::Places LabelDescent::here() const {
  Places out;
  out.at.reserve(2 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      out.at.push_back(static_cast<float>(x));
      out.at.push_back(static_cast<float>(y));
    }
  return out;
}

void LabelDescent::follow(const FrameFlow& back) {
  follow(since_, back);
  follow(next_, back);
  if (next_.age >= kRenewed) {
    since_ = std::move(next_);
    next_ = here();
  }
  area_ = areas();
}

void LabelDescent::follow(Places& places, const FrameFlow& back) const {
  cv::Mat before(height_, width_, CV_32FC2, places.at.data()), from(before.size(), CV_32FC2),
      beyond(before.size(), CV_32FC2), now;
  const float* uv = back.uv.data();
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x, uv += 2) {
      const cv::Vec2f wanted(static_cast<float>(x) + uv[0], static_cast<float>(y) + uv[1]);
      const cv::Vec2f inside(std::clamp(wanted[0], 0.0f, static_cast<float>(width_ - 1)),
                             std::clamp(wanted[1], 0.0f, static_cast<float>(height_ - 1)));
      from.at<cv::Vec2f>(y, x) = inside;
      beyond.at<cv::Vec2f>(y, x) = wanted - inside;
    }
  cv::remap(before, now, from, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::add(now, beyond, before);
  ++places.age;
}

// Of each pixel, the area that it had.
std::vector<float> LabelDescent::areas() const {
  std::vector<float> at = since_.at;
  cv::Mat smooth(height_, width_, CV_32FC2, at.data());
  cv::blur(smooth, smooth, {kApart + 1, kApart + 1});
  std::vector<float> out;
  out.reserve(at.size() / 2);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const int left = std::max(0, x - kApart), right = std::min(width_ - 1, x + kApart),
                top = std::max(0, y - kApart), bottom = std::min(height_ - 1, y + kApart);
      const cv::Vec2f a =
          (smooth.at<cv::Vec2f>(y, right) - smooth.at<cv::Vec2f>(y, left)) / static_cast<float>(right - left);
      const cv::Vec2f b =
          (smooth.at<cv::Vec2f>(bottom, x) - smooth.at<cv::Vec2f>(top, x)) / static_cast<float>(bottom - top);
      out.push_back(a[0] * b[1] - a[1] * b[0]);
    }
  return out;
}

Image LabelDescent::fresh(const Image& labels, int count) const {
  Image out(width_, height_, 1);
  for (int l = 1; l < count; ++l) {
    std::vector<float> own;
    for (std::size_t p = 0; p < area_.size(); ++p)
      if (labels.pixels[p] == l) own.push_back(area_[p]);
    if (own.empty()) continue;
    // Who comes nearer is drawn out, too, but as a whole.
    const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
    std::nth_element(own.begin(), middle, own.end());
    Image drawn(width_, height_, 1);
    for (std::size_t p = 0; p < area_.size(); ++p)
      drawn.pixels[p] = labels.pixels[p] == l && area_[p] < kOwn * *middle ? 255 : 0;
    cv::Mat thick;
    cv::morphologyEx(as_mat(drawn), thick, cv::MORPH_OPEN,
                     cv::getStructuringElement(cv::MORPH_ELLIPSE, {kThin, kThin}));
    cv::Mat all = as_mat(out);
    cv::max(all, hanging(thick, labels, l), all);
  }
  return out;
}

}  // namespace floatstage::matting
