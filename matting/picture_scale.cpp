#include "matting/picture_scale.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "matting/image_mat.h"

namespace floatstage::matting {

Image scaled(const Image& picture, int width, int height) {
  if (picture.width == width && picture.height == height) return picture;
  Image out(width, height, picture.channels);
  cv::Mat to = as_mat(out);
  const bool shrinks = width <= picture.width && height <= picture.height;
  cv::resize(as_mat(picture), to, to.size(), 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_CUBIC);
  return out;
}

MatteConstraint scaled(const MatteConstraint& opinion, int width, int height) {
  MatteConstraint out;
  if (opinion.empty()) return out;
  out.opacity = scaled(opinion.opacity, width, height);
  if (opinion.weight.empty()) return out;
  // A stroke thinner than a working pixel must not fade: its opacity is the mean over its own pixels only.
  const Image weight = scaled(opinion.weight, width, height);
  Image marked = opinion.opacity;
  for (std::size_t p = 0; p < marked.pixels.size(); ++p)
    marked.pixels[p] = static_cast<std::uint8_t>(marked.pixels[p] * opinion.weight.pixels[p] / 255);
  const Image weighted = scaled(marked, width, height);
  for (std::size_t p = 0; p < weight.pixels.size(); ++p)
    if (weight.pixels[p] > 0)
      out.opacity.pixels[p] = static_cast<std::uint8_t>(
          std::min(255L, std::lround(255.0 * weighted.pixels[p] / weight.pixels[p])));
  out.weight = weight;
  return out;
}

}  // namespace floatstage::matting
