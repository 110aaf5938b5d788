#include "matting/picture_scale.h"

#include <opencv2/imgproc.hpp>

namespace floatstage {

Image scaled(const Image& picture, int width, int height) {
  if (picture.width == width && picture.height == height) return picture;
  Image out(width, height, picture.channels);
  const cv::Mat from(picture.height, picture.width, CV_8UC(picture.channels),
                     const_cast<std::uint8_t*>(picture.pixels.data()));
  cv::Mat to(height, width, CV_8UC(picture.channels), out.pixels.data());
  const bool shrinks = width <= picture.width && height <= picture.height;
  cv::resize(from, to, to.size(), 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_CUBIC);
  return out;
}

}  // namespace floatstage
