// Method:  what moved between two frames: dense inverse search
// Paper:   T. Kroeger and others, "Fast optical flow using dense inverse search", 2016; thesis, eq. 7.3
// Differs: dense flow where the thesis matches blocks; on one
//          thread, so that no machine differs
// ADR:     none; docs/algorithms/spectral-matting.md

#include "matting/video/frame_flow.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr int kSmallestForDis = 32;  // px: DIS needs a few of its 8 px patches
constexpr double kAgreement = 12;    // 8-bit steps of colour within which a carried pixel explains another
constexpr double kLeastConfidence = 0.1;

cv::Mat grey(const Image& image) {
  if (image.channels == 1) return as_mat(image);
  cv::Mat out;
  cv::cvtColor(as_mat(image), out, cv::COLOR_RGB2GRAY);
  return out;
}

cv::Mat lookup(const FrameFlow& flow) {
  cv::Mat map(flow.height, flow.width, CV_32FC2);
  for (int y = 0; y < flow.height; ++y) {
    const float* uv = &flow.uv[2 * static_cast<std::size_t>(y) * flow.width];
    auto* row = map.ptr<cv::Vec2f>(y);
    for (int x = 0; x < flow.width; ++x)
      row[x] = {static_cast<float>(x) + uv[2 * x], static_cast<float>(y) + uv[2 * x + 1]};
  }
  return map;
}

}  // namespace

FrameFlow flow_between(const Image& from, const Image& to) {
  FrameFlow flow{to.width, to.height, std::vector<float>(2 * static_cast<std::size_t>(to.width) * to.height)};
  if (std::min(to.width, to.height) < kSmallestForDis) return flow;
  const cv::Mat a = grey(to), b = grey(from);
  const auto dis = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_FAST);
  dis->setFinestScale(1);
  cv::Mat uv;
  dis->calc(a, b, uv);
  for (int y = 0; y < flow.height; ++y)
    std::copy_n(uv.ptr<float>(y), 2 * flow.width, &flow.uv[2 * static_cast<std::size_t>(y) * flow.width]);
  for (float& value : flow.uv) value = std::isfinite(value) ? value : 0;
  return flow;
}

Image carried(const Image& from, const FrameFlow& flow) {
  Image out(flow.width, flow.height, from.channels);
  cv::Mat to = as_mat(out);
  cv::remap(as_mat(from), to, lookup(flow), {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return out;
}

Eigen::MatrixXf carried(const Eigen::MatrixXf& from, const FrameFlow& flow) {
  Eigen::MatrixXf out(from.rows(), from.cols());
  const cv::Mat map = lookup(flow);
  for (Eigen::Index c = 0; c < from.cols(); ++c) {
    const cv::Mat in(flow.height, flow.width, CV_32F, const_cast<float*>(from.col(c).data()));
    cv::Mat to(flow.height, flow.width, CV_32F, out.col(c).data());
    cv::remap(in, to, map, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  }
  return out;
}

Image confidence_of(const Image& from, const Image& to, const FrameFlow& flow) {
  const Image there = carried(from, flow);
  Image out(to.width, to.height, 1);
  const double slope = -0.5 / (kAgreement * kAgreement * to.channels);
  for (std::size_t p = 0; p < out.pixels.size(); ++p) {
    double square = 0;
    for (int c = 0; c < to.channels; ++c) {
      const double d =
          static_cast<double>(to.pixels[p * to.channels + c]) - there.pixels[p * to.channels + c];
      square += d * d;
    }
    out.pixels[p] = static_cast<std::uint8_t>(
        std::lround(255 * (kLeastConfidence + (1 - kLeastConfidence) * std::exp(slope * square))));
  }
  return out;
}

}  // namespace floatstage::matting
