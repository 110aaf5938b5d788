#include <cmath>
#include <limits>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "pipeline/metrics/metrics.h"
#include "pipeline/metrics/picture_pair.h"

// Complex wavelet SSIM, Sampat, Wang, Gupta, Bovik, Markey: "Complex wavelet structural similarity: a new
// image similarity index" (2009). Of the coefficients x_i and y_i of one subband in one window (eq. 7):
//
//   S(x, y) = (2 |sum x_i conj(y_i)| + K) / (sum |x_i|^2 + sum |y_i|^2 + K)
//
// The subbands are those of the complex steerable pyramid (Portilla and Simoncelli 2000, sec. 2.1), made in
// the frequency domain: at scale s and orientation k of O, with r the frequency in units of the full
// picture's Nyquist frequency,
//
//   L(r; c) = 1 below c/2, cos(pi/2 log2(2 r / c)) up to c, 0 above;     H(r; c) = sqrt(1 - L(r; c)^2)
//   B_s(r) = L(r; 2^-s) H(r; 2^-(s+1))
//   A_k(t) = alpha cos(t - pi k / O)^(O-1) where that cosine is positive, else 0;   alpha = 2^(O-1) (O-1)! /
//   sqrt(O (2 O - 2)!)
//
// B_s vanishes from 2^-s on, so its spectrum may be cut there: scale s is sampled every 2^s pixels without
// aliasing.
namespace floatstage::pipeline {
namespace {

constexpr int kScales = 4, kOrientations = 8, kWindow = 7;
constexpr int kMargin = 32;  // px around the mask, so that the two sides of the periodic picture do not meet
// The energy of rounding to 8 bits in one window: what is flat up to rounding is alike.
constexpr double kK = kWindow * kWindow / 12.0;

double low_pass(double r, double cut) {
  if (r <= cut / 2) return 1;
  if (r >= cut) return 0;
  return std::cos(std::numbers::pi / 2 * std::log2(2 * r / cut));
}

double band_pass(double r, int scale) {
  const double low = low_pass(r, std::ldexp(1.0, -scale)), inner = low_pass(r, std::ldexp(1.0, -scale - 1));
  return low * std::sqrt(std::max(0.0, 1 - inner * inner));
}

double angular(double angle, int orientation) {
  constexpr int n = kOrientations - 1;
  const double c = std::cos(angle - std::numbers::pi * orientation / kOrientations);
  if (c <= 0) return 0;
  const double log_alpha = n * std::log(2.0) + std::lgamma(n + 1.0) -
                           0.5 * (std::log(kOrientations * 1.0) + std::lgamma(2.0 * n + 1));
  return std::exp(log_alpha) * std::pow(c, n);
}

// The frequency, in cycles over the picture, of entry i of a spectrum with n entries.
int frequency(int i, int n) { return i < (n + 1) / 2 ? i : i - n; }

// The filter of one subband over the entries of its own (cut) spectrum, for pictures of `full` pixels.
cv::Mat filter_of(int scale, int orientation, cv::Size full) {
  const cv::Size cut(full.width >> scale, full.height >> scale);
  cv::Mat filter(cut, CV_64F);
  for (int v = 0; v < cut.height; ++v) {
    for (int u = 0; u < cut.width; ++u) {
      const double fx = 2.0 * frequency(u, cut.width) / full.width,
                   fy = 2.0 * frequency(v, cut.height) / full.height;
      const double r = std::hypot(fx, fy);
      filter.at<double>(v, u) = r == 0 ? 0 : band_pass(r, scale) * angular(std::atan2(fy, fx), orientation);
    }
  }
  return filter;
}

// One complex subband (CV_64FC2) of a picture, given the picture's spectrum.
cv::Mat subband(const cv::Mat& spectrum, const cv::Mat& filter) {
  cv::Mat cut(filter.size(), CV_64FC2);
  for (int v = 0; v < cut.rows; ++v) {
    const int fy = frequency(v, cut.rows), from_y = fy < 0 ? fy + spectrum.rows : fy;
    for (int u = 0; u < cut.cols; ++u) {
      const int fx = frequency(u, cut.cols), from_x = fx < 0 ? fx + spectrum.cols : fx;
      cut.at<cv::Vec2d>(v, u) = spectrum.at<cv::Vec2d>(from_y, from_x) * filter.at<double>(v, u);
    }
  }
  cv::Mat band;
  // The spectrum is of the full picture, so the mean over the full number of pixels keeps amplitudes at every
  // scale.
  cv::dft(cut, band, cv::DFT_INVERSE);
  return band / static_cast<double>(spectrum.total());
}

cv::Mat window_sum(const cv::Mat& m) {
  cv::Mat out;
  cv::boxFilter(m, out, CV_64F, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return out;
}

// The mean similarity of two subbands over the windows centred in the mask; NaN when the mask has no sample
// here.
double similarity(const cv::Mat& x, const cv::Mat& y, const cv::Mat& mask, int step) {
  cv::Mat product(x.size(), CV_64FC2), energy(x.size(), CV_64F);
  for (int i = 0; i < x.rows; ++i) {
    for (int j = 0; j < x.cols; ++j) {
      const cv::Vec2d p = x.at<cv::Vec2d>(i, j), q = y.at<cv::Vec2d>(i, j);
      product.at<cv::Vec2d>(i, j) = {p[0] * q[0] + p[1] * q[1], p[1] * q[0] - p[0] * q[1]};
      energy.at<double>(i, j) = p.dot(p) + q.dot(q);
    }
  }
  const cv::Mat correlation = window_sum(product), total = window_sum(energy);
  double sum = 0, count = 0;
  for (int i = 0; i < x.rows; ++i) {
    for (int j = 0; j < x.cols; ++j) {
      if (mask.at<double>(i * step, j * step) == 0) continue;
      const cv::Vec2d c = correlation.at<cv::Vec2d>(i, j);
      sum += (2 * std::hypot(c[0], c[1]) + kK) / (total.at<double>(i, j) + kK);
      count += 1;
    }
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

// The luma less `mean` in the mask and 0 outside, on a canvas with a margin.
cv::Mat canvas_of(const cv::Mat& luma, const cv::Mat& weights, double mean, cv::Size canvas) {
  cv::Mat picture = cv::Mat::zeros(canvas, CV_64F);
  cv::Mat inside = picture(cv::Rect(kMargin, kMargin, luma.cols, luma.rows));
  cv::Mat(weights.mul(luma - mean)).copyTo(inside);
  return picture;
}

cv::Mat spectrum_of(const cv::Mat& picture) {
  cv::Mat spectrum;
  cv::dft(picture, spectrum, cv::DFT_COMPLEX_OUTPUT);
  return spectrum;
}

// A length that OpenCV transforms quickly and that halves evenly once per scale.
int padded(int length) {
  constexpr int unit = 1 << (kScales - 1);
  return unit * cv::getOptimalDFTSize((length + 2 * kMargin + unit - 1) / unit);
}

}  // namespace

double cw_ssim(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  const cv::Rect box = box_of(mask);
  if (box.empty()) return std::numeric_limits<double>::quiet_NaN();
  const cv::Mat a = luma_of(rendered, box), b = luma_of(truth, box), w = weights_of(mask, box);
  const double mean = cv::sum(w.mul(b))[0] / cv::sum(w)[0];
  const cv::Size canvas(padded(box.width), padded(box.height));
  const cv::Mat of_a = spectrum_of(canvas_of(a, w, mean, canvas)),
                of_b = spectrum_of(canvas_of(b, w, mean, canvas));
  const cv::Mat placed = canvas_of(w, w, 0, canvas);

  double sum = 0, bands = 0;
  for (int scale = 0; scale < kScales; ++scale) {
    for (int orientation = 0; orientation < kOrientations; ++orientation) {
      const cv::Mat filter = filter_of(scale, orientation, canvas);
      const double s = similarity(subband(of_a, filter), subband(of_b, filter), placed, 1 << scale);
      if (std::isnan(s)) continue;  // a mask that falls between the samples of a coarse scale
      sum += s;
      bands += 1;
    }
  }
  return sum / bands;  // scale 0 samples every pixel, so there is always a band
}

}  // namespace floatstage::pipeline
