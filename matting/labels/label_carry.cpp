// Method:  labels carried to a neighbouring frame
// Paper:   T. Kroeger and others, "Fast optical flow using dense inverse search", 2016; X. Bai, J. Wang,
//          D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using Localized Classifiers",
//          SIGGRAPH 2009, section 2.2: flow averaged over the object's side of the contour
// Differs: a mean over the label's inside around every pixel instead of a contour's windows
// ADR:     0274

#include "matting/labels/label_carry.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace floatstage::matting {
namespace {

constexpr float kLoop = 1.5f;  // px by which there and back may miss
constexpr int kColor = 120;    // 8-bit steps, summed over channels, by which a followed pixel may change
constexpr int kInside = 4;     // px from the edge on which flow is the label's own

// How the inside of a label moves around each pixel, and how much of it there is.
struct InsideFlow {
  cv::Mat uv, weight;
};

InsideFlow inside_flow(const FrameFlow& flow, const Image& labels, int label, int reach) {
  cv::Mat mask(labels.height, labels.width, CV_8U), inside;
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x) mask.at<std::uint8_t>(y, x) = *labels.at(x, y) == label ? 255 : 0;
  cv::erode(mask, inside, cv::Mat::ones(2 * kInside + 1, 2 * kInside + 1, CV_8U), {-1, -1}, 1,
            cv::BORDER_REPLICATE);
  InsideFlow out{cv::Mat(mask.size(), CV_32FC2), cv::Mat(mask.size(), CV_32F)};
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x) {
      const float w = inside.at<std::uint8_t>(y, x) ? 1.0f : 0.0f;
      const std::size_t p = 2 * labels.offset(x, y);
      out.uv.at<cv::Vec2f>(y, x) = {w * flow.uv[p], w * flow.uv[p + 1]};
      out.weight.at<float>(y, x) = w;
    }
  for (int pass = 0; pass < 2; ++pass) {  // nearly a bell
    cv::blur(out.uv, out.uv, {reach + 1, reach + 1});
    cv::blur(out.weight, out.weight, {reach + 1, reach + 1});
  }
  return out;
}

// Where label's pixels come from: the mask of the old frame, looked up along the flow of its inside; along
// dense flow where no inside is near.
Image carried_mask(const Image& labels, int label, const InsideFlow& inside, const FrameFlow& back) {
  cv::Mat mask(labels.height, labels.width, CV_8U), place(mask.size(), CV_32FC2);
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x) {
      mask.at<std::uint8_t>(y, x) = *labels.at(x, y) == label ? 255 : 0;
      const float w = inside.weight.at<float>(y, x);
      const std::size_t p = 2 * labels.offset(x, y);
      const cv::Vec2f from = w > 1e-4f ? cv::Vec2f(inside.uv.at<cv::Vec2f>(y, x) * (-1 / w))
                                       : cv::Vec2f(back.uv[p], back.uv[p + 1]);
      place.at<cv::Vec2f>(y, x) = {static_cast<float>(x) + from[0], static_cast<float>(y) + from[1]};
    }
  Image out(labels.width, labels.height, 1);
  cv::Mat view(out.height, out.width, CV_8U, out.pixels.data());
  cv::remap(mask, view, place, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return out;
}

void mark_lost(const Image& colors, const Image& to, const FrameFlow& back, const FrameFlow& there,
               CarriedLabels& out) {
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const std::size_t p = out.doubtful.offset(x, y);
      const float u = back.uv[2 * p], v = back.uv[2 * p + 1];
      const int fx = std::clamp(static_cast<int>(std::lround(static_cast<float>(x) + u)), 0, to.width - 1),
                fy = std::clamp(static_cast<int>(std::lround(static_cast<float>(y) + v)), 0, to.height - 1);
      const std::size_t q = out.doubtful.offset(fx, fy);
      const float miss = std::hypot(u + there.uv[2 * q], v + there.uv[2 * q + 1]);
      int change = 0;
      for (std::size_t c = 0; c < 3; ++c)
        change += std::abs(int{colors.pixels[3 * p + c]} - int{to.pixels[3 * p + c]});
      if (miss > kLoop || change > kColor) out.doubtful.pixels[p] = 255;
    }
  }
}

// Of each label, the share of its pixels that are marked.
std::vector<double> shares(const Image& labels, const Image& marked, int count) {
  std::vector<double> out(static_cast<std::size_t>(count)), all(out.size());
  for (std::size_t p = 0; p < labels.pixels.size(); ++p) {
    all[labels.pixels[p]] += 1;
    out[labels.pixels[p]] += marked.pixels[p] ? 1 : 0;
  }
  for (std::size_t l = 0; l < out.size(); ++l) out[l] = all[l] > 0 ? out[l] / all[l] : 0;
  return out;
}

}  // namespace

CarriedLabels carry_labels(const Image& from, const Image& labels, int count, int reach, const Image& to) {
  FLOATSTAGE_CHECK(from.width == to.width && from.height == to.height && labels.width == to.width &&
                       labels.height == to.height && labels.channels == 1,
                   "frames and labels of one size");
  FrameFlow back = flow_between(from, to);
  const FrameFlow there = flow_between(to, from);
  CarriedLabels out;
  out.labels = out.dense = out.doubtful = Image(to.width, to.height, 1);
  std::vector<std::uint8_t> best(out.labels.pixels.size(), 127);
  for (int l = 1; l < count; ++l) {
    const Image share = carried_mask(labels, l, inside_flow(there, labels, l, reach), back);
    Image mask(labels.width, labels.height, 1);
    for (std::size_t p = 0; p < best.size(); ++p) mask.pixels[p] = labels.pixels[p] == l ? 255 : 0;
    const Image along = carried(mask, back);
    for (std::size_t p = 0; p < best.size(); ++p) {
      if (along.pixels[p] > 127) out.dense.pixels[p] = static_cast<std::uint8_t>(l);
      if (share.pixels[p] > best[p]) {
        best[p] = share.pixels[p];
        out.labels.pixels[p] = static_cast<std::uint8_t>(l);
      }
    }
  }
  mark_lost(carried(from, back), to, back, there, out);
  out.unfound = shares(out.dense, out.doubtful, count);
  for (std::size_t p = 0; p < best.size(); ++p)
    if (out.dense.pixels[p] != out.labels.pixels[p]) out.doubtful.pixels[p] = 255;
  out.back = std::move(back);
  return out;
}

}  // namespace floatstage::matting
