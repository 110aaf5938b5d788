#include <limits>

#include <opencv2/imgproc.hpp>

#include "pipeline/metrics/metrics.h"
#include "pipeline/metrics/picture_pair.h"

namespace floatstage::pipeline {
namespace {

constexpr double kC1 = (0.01 * 255) * (0.01 * 255), kC2 = (0.03 * 255) * (0.03 * 255);

// Sums under an 11x11 Gaussian window of sigma 1.5 that sees zeros beyond the picture.
cv::Mat windowed(const cv::Mat& m) {
  cv::Mat out;
  cv::GaussianBlur(m, out, {11, 11}, 1.5, 1.5, cv::BORDER_CONSTANT);
  return out;
}

}  // namespace

double ssim(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  const cv::Rect box = box_of(mask);
  if (box.empty()) return std::numeric_limits<double>::quiet_NaN();
  const cv::Mat a = luma_of(rendered, box), b = luma_of(truth, box), w = weights_of(mask, box);

  // Normalised convolution: the window's weights times the mask's, which sum to `total` at each pixel.
  const cv::Mat wa = w.mul(a), wb = w.mul(b), total = windowed(w);
  const cv::Mat sa = windowed(wa), sb = windowed(wb), saa = windowed(wa.mul(a)), sbb = windowed(wb.mul(b)),
                sab = windowed(wa.mul(b));
  double sum = 0, count = 0;
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      if (w.at<double>(y, x) == 0) continue;
      const double n = total.at<double>(y, x);
      const double mean_a = sa.at<double>(y, x) / n, mean_b = sb.at<double>(y, x) / n;
      const double var_a = saa.at<double>(y, x) / n - mean_a * mean_a,
                   var_b = sbb.at<double>(y, x) / n - mean_b * mean_b;
      const double covar = sab.at<double>(y, x) / n - mean_a * mean_b;
      sum += (2 * mean_a * mean_b + kC1) * (2 * covar + kC2) /
             ((mean_a * mean_a + mean_b * mean_b + kC1) * (var_a + var_b + kC2));
      count += 1;
    }
  }
  return sum / count;
}

}  // namespace floatstage::pipeline
