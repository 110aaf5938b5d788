// Method:  labels from two key frames, each heard by how well it is known to hold
// ADR:     0274

#include "matting/labels/label_join.h"

#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "matting/labels/label_step.h"

namespace floatstage::matting {
namespace {

// By label, how much the labels from after are heard.
std::vector<float> shares_of(const LabelsFromKey& before, const LabelsFromKey& after) {
  std::vector<float> shares;
  for (std::size_t l = 0; l < before.lost.size(); ++l) {
    const double b = before.lost[l] * before.way, a = after.lost[l] * after.way;
    shares.push_back(static_cast<float>(a + b > 0 ? b / (a + b) : before.way));
  }
  return shares;
}

// The label, not the background, that either says of a pixel, or of the nearest one of which any is said.
Image nearest_labels(const Image& before, const Image& after) {
  Image said(before.width, before.height, 1);
  cv::Mat none(before.height, before.width, CV_8U);
  for (int y = 0; y < said.height; ++y)
    for (int x = 0; x < said.width; ++x) {
      *said.at(x, y) = *before.at(x, y) ? *before.at(x, y) : *after.at(x, y);
      none.at<std::uint8_t>(y, x) = *said.at(x, y) ? 0 : 255;
    }
  cv::Mat distance, nearest;
  cv::distanceTransform(none, distance, nearest, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<std::uint8_t> label_of(1, 0);
  for (int y = 0; y < said.height; ++y)
    for (int x = 0; x < said.width; ++x)
      if (*said.at(x, y)) {
        const auto i = static_cast<std::size_t>(nearest.at<int>(y, x));
        if (i >= label_of.size()) label_of.resize(i + 1, 0);
        label_of[i] = *said.at(x, y);
      }
  for (int y = 0; y < said.height; ++y)
    for (int x = 0; x < said.width; ++x) {
      const auto i = static_cast<std::size_t>(nearest.at<int>(y, x));
      if (i < label_of.size()) *said.at(x, y) = label_of[i];
    }
  return said;
}

}  // namespace

Image join_labels(const Image& picture, const LabelsFromKey& before, const LabelsFromKey& after, int count,
                  const LabelClipOptions& options) {
  Image agreed = before.labels;
  for (std::size_t p = 0; p < agreed.pixels.size(); ++p)
    if (before.labels.pixels[p] != after.labels.pixels[p]) agreed.pixels[p] = 255;
  const Image sure(picture.width, picture.height, 1);  // both directions have spoken: nothing is new
  const std::vector<float> shares = shares_of(before, after);
  const Image nearest = nearest_labels(before.labels, after.labels);
  std::vector<float> from_before, from_after;
  for (const std::uint8_t label : nearest.pixels) {
    from_after.push_back(shares[label]);
    from_before.push_back(1 - shares[label]);
  }
  return label_frame(
      picture, {{before.labels, sure, std::move(from_before)}, {after.labels, sure, std::move(from_after)}},
      {picture, agreed}, count, options);
}

}  // namespace floatstage::matting
