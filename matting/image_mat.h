#pragma once

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include "core/image.h"

// Private to the stage: pictures in the eyes of OpenCV.
namespace floatstage::matting {

/// Before main(), because OpenCV takes its threads apart while others work in them (docs/adr/0339): it works
/// on its caller's thread alone. DIS would cut its search into one stripe a thread, and its result depend on
/// the machine; we run over pictures in parallel.
inline const bool kOpenCvOnOneThread = (cv::setNumThreads(1), true);

/// The picture's own bytes, which it must outlive.
inline cv::Mat as_mat(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels),
                 const_cast<std::uint8_t*>(image.pixels.data()));
}

/// A copy of a part that lies in the picture.
Image part_of(const Image& image, const cv::Rect& box);

/// One channel: the largest value within a square of `radius` px to each side.
Image grown(const Image& mask, int radius);

}  // namespace floatstage::matting
