#pragma once

#include <opencv2/core.hpp>

#include "core/image.h"

// Private to the metrics: pictures as OpenCV sees them.
namespace floatstage::pipeline {

/// Throws CheckFailure unless the three belong together as metrics.h demands.
void check_pair(const Image& rendered, const Image& truth, const Image& mask);

/// The smallest box that holds the mask; empty when the mask is.
cv::Rect box_of(const Image& mask);

/// BT.601 luma without rounding, CV_64F, of the pixels in `box`.
cv::Mat luma_of(const Image& image, const cv::Rect& box);

/// 1 in the mask and 0 outside, CV_64F, of the pixels in `box`.
cv::Mat weights_of(const Image& mask, const cv::Rect& box);

}  // namespace floatstage::pipeline
