#include "matting/image_mat.h"

#include <opencv2/imgproc.hpp>

namespace floatstage::matting {

Image part_of(const Image& image, const cv::Rect& box) {
  Image out(box.width, box.height, image.channels);
  as_mat(image)(box).copyTo(as_mat(out));
  return out;
}

Image grown(const Image& mask, int radius) {
  Image out(mask.width, mask.height, 1);
  cv::Mat to = as_mat(out);
  cv::dilate(as_mat(mask), to, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  return out;
}

}  // namespace floatstage::matting
