#include "calib/grey.h"

#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace floatstage::calib {

cv::Mat grey_of(const Image& image) {
  FLOATSTAGE_CHECK(image.channels == 1 || image.channels == 3 || image.channels == 4,
                   "an image of an unknown kind");
  // OpenCV takes no const pixels; nothing here writes to them.
  const cv::Mat pixels(image.height, image.width, CV_8UC(image.channels),
                       const_cast<std::uint8_t*>(image.pixels.data()));
  if (image.channels == 1) return pixels;
  cv::Mat grey;
  cv::cvtColor(pixels, grey, image.channels == 3 ? cv::COLOR_RGB2GRAY : cv::COLOR_RGBA2GRAY);
  return grey;
}

}  // namespace floatstage::calib
