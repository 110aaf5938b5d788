// Method:  opacity as an affine function of colour, fitted small and applied large
// Paper:   K. He, J. Sun, X. Tang, "Guided image filtering", 2013, eq. 16; K. He, J. Sun, "Fast guided
//          filter", 2015
// Differs: coefficients come from the small picture's windows only
// ADR:     0097

#include "matting/guided_filter.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "matting/image_mat.h"
#include "matting/picture_scale.h"

namespace floatstage::matting {
namespace {

constexpr int kWindow = 5;        // px a side of the colour models' windows, at the small size
constexpr double kSmooth = 1e-4;  // regularisation of the models, colours in 0..1

cv::Mat as_float(const Image& image) {
  cv::Mat out;
  as_mat(image).convertTo(out, CV_32F, 1 / 255.0);
  return out;
}

cv::Mat window_mean(const cv::Mat& m) {
  cv::Mat out;
  cv::boxFilter(m, out, -1, {kWindow, kWindow}, {-1, -1}, true, cv::BORDER_REFLECT_101);
  return out;
}

// Solves the symmetric 3x3 system (c + kSmooth I) a = b; c as xx xy xz yy yz zz.
cv::Vec3f solve3(const cv::Vec6f& c, const cv::Vec3f& b) {
  const double xx = c[0] + kSmooth, xy = c[1], xz = c[2], yy = c[3] + kSmooth, yz = c[4], zz = c[5] + kSmooth;
  // Cholesky: positive definite by kSmooth.
  const double l00 = std::sqrt(xx), l10 = xy / l00, l20 = xz / l00;
  const double l11 = std::sqrt(std::max(yy - l10 * l10, 1e-12)), l21 = (yz - l20 * l10) / l11;
  const double l22 = std::sqrt(std::max(zz - l20 * l20 - l21 * l21, 1e-12));
  const double u = b[0] / l00, v = (b[1] - l10 * u) / l11, w = (b[2] - l20 * u - l21 * v) / l22;
  const double z = w / l22, y = (v - l21 * z) / l11, x = (u - l10 * y - l20 * z) / l00;
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

}  // namespace

Image guided_filter(const Image& picture, const Image& matte) {
  const cv::Mat alpha = as_float(matte), small = as_float(scaled(picture, matte.width, matte.height)),
                large = as_float(picture);
  cv::Mat rgb = small;
  if (small.channels() != 3) cv::cvtColor(small, rgb, cv::COLOR_GRAY2RGB);
  cv::Mat i[3];
  cv::split(rgb, i);
  cv::Mat mean[3], with[3], covariance[6];
  const cv::Mat mean_alpha = window_mean(alpha);
  for (int c = 0; c < 3; ++c) {
    mean[c] = window_mean(i[c]);
    with[c] = window_mean(i[c].mul(alpha)) - mean[c].mul(mean_alpha);
  }
  for (int c = 0, k = 0; c < 3; ++c)
    for (int d = c; d < 3; ++d, ++k) covariance[k] = window_mean(i[c].mul(i[d])) - mean[c].mul(mean[d]);
  cv::Mat model(matte.height, matte.width, CV_32FC4);
  for (int y = 0; y < matte.height; ++y) {
    for (int x = 0; x < matte.width; ++x) {
      cv::Vec6f cov;
      for (int k = 0; k < 6; ++k) cov[k] = covariance[k].at<float>(y, x);
      const cv::Vec3f a =
          solve3(cov, {with[0].at<float>(y, x), with[1].at<float>(y, x), with[2].at<float>(y, x)});
      float offset = mean_alpha.at<float>(y, x);
      for (int c = 0; c < 3; ++c) offset -= a[c] * mean[c].at<float>(y, x);
      model.at<cv::Vec4f>(y, x) = {a[0], a[1], a[2], offset};
    }
  }
  model = window_mean(model);
  cv::resize(model, model, large.size(), 0, 0, cv::INTER_LINEAR);
  Image out(picture.width, picture.height, 1);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const cv::Vec4f& m = model.at<cv::Vec4f>(y, x);
      const float* p = large.ptr<float>(y) + static_cast<std::ptrdiff_t>(x) * picture.channels;
      const float a = m[0] * p[0] + m[1] * p[picture.channels == 3 ? 1 : 0] +
                      m[2] * p[picture.channels == 3 ? 2 : 0] + m[3];
      *out.at(x, y) = static_cast<std::uint8_t>(std::lround(255 * std::clamp(a, 0.0f, 1.0f)));
    }
  }
  return out;
}

}  // namespace floatstage::matting
