#include "pipeline/metrics/matte_metrics.h"

#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace floatstage::pipeline {
namespace {

constexpr int kSubject = 128;
constexpr double kSigma = 1.4;          // of the gradient's Gaussian, px
constexpr int kConnectivitySteps = 10;  // thresholds a tenth apart
constexpr double kForgivenStep = 0.15;  // of connectivity
constexpr double kPi = 3.14159265358979323846;

void check_mattes(const Image& a, const Image& b) {
  FLOATSTAGE_CHECK(a.channels == 1 && b.channels == 1, "a matte's score needs one channel");
  FLOATSTAGE_CHECK(a.width == b.width && a.height == b.height, "a matte and its truth differ in size");
}

cv::Mat opacity(const Image& matte) {
  cv::Mat out;
  cv::Mat(matte.height, matte.width, CV_8U, const_cast<std::uint8_t*>(matte.pixels.data()))
      .convertTo(out, CV_64F, 1 / 255.0);
  return out;
}

template <class F>
double sum_over(const Image& a, const Image& b, F&& of) {
  check_mattes(a, b);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += of((a.pixels[i] - b.pixels[i]) / 255.0);
  return sum;
}

double pixels_of(const Image& a) { return static_cast<double>(a.pixels.size()); }

// Magnitude of the gradient under a Gaussian's derivative. The kernel ends where the Gaussian falls under a
// hundredth, as in the benchmark's own code, so that figures compare.
cv::Mat gradient_magnitude(const Image& matte) {
  constexpr double kCut = 1e-2;
  const int half =
      static_cast<int>(std::ceil(kSigma * std::sqrt(-2 * std::log(std::sqrt(2 * kPi) * kSigma * kCut))));
  cv::Mat smooth(1, 2 * half + 1, CV_64F), slope(1, 2 * half + 1, CV_64F);
  for (int i = -half; i <= half; ++i) {
    smooth.at<double>(i + half) = std::exp(-i * i / (2 * kSigma * kSigma));
    slope.at<double>(i + half) = -i * smooth.at<double>(i + half);
  }
  smooth /= cv::norm(smooth);
  slope /= cv::norm(slope);
  const cv::Mat alpha = opacity(matte);
  cv::Mat x, y, magnitude;
  cv::sepFilter2D(alpha, x, CV_64F, slope, smooth, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sepFilter2D(alpha, y, CV_64F, smooth, slope, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::magnitude(x, y, magnitude);
  return magnitude;
}

// The largest 4-connected component of a mask; empty of it when the mask is.
cv::Mat largest_component(const cv::Mat& mask) {
  cv::Mat labels, stats, centers;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centers, 4, CV_32S, cv::CCL_SAUF);
  int best = 0, area = 0;
  for (int i = 1; i < count; ++i)
    if (stats.at<int>(i, cv::CC_STAT_AREA) > area) best = i, area = stats.at<int>(i, cv::CC_STAT_AREA);
  if (best == 0) return cv::Mat::zeros(mask.size(), CV_8U);
  return labels == best;
}

cv::Mat subject(const Image& matte) {
  return cv::Mat(matte.height, matte.width, CV_8U, const_cast<std::uint8_t*>(matte.pixels.data())) >=
         kSubject;
}

// Subject pixels with a neighbour in the picture that is none.
cv::Mat boundary(const cv::Mat& mask) {
  cv::Mat inside;
  cv::erode(mask, inside, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}), {-1, -1}, 1,
            cv::BORDER_CONSTANT, cv::Scalar(255));
  return mask & ~inside;
}

}  // namespace

double matte_sad(const Image& matte, const Image& truth) {
  return sum_over(matte, truth, [](double d) { return std::abs(d); });
}
double matte_mad(const Image& matte, const Image& truth) {
  return matte_sad(matte, truth) / pixels_of(truth);
}
double matte_mse(const Image& matte, const Image& truth) {
  return sum_over(matte, truth, [](double d) { return d * d; }) / pixels_of(truth);
}

double matte_gradient_error(const Image& matte, const Image& truth) {
  check_mattes(matte, truth);
  const double distance = cv::norm(gradient_magnitude(matte), gradient_magnitude(truth), cv::NORM_L2);
  return distance * distance;
}

double matte_connectivity_error(const Image& matte, const Image& truth) {
  check_mattes(matte, truth);
  const cv::Mat a = opacity(matte), b = opacity(truth);
  // The highest threshold at which a pixel still belongs to the common component.
  cv::Mat level(a.size(), CV_64F, cv::Scalar(-1));
  for (int step = 1; step <= kConnectivitySteps; ++step) {
    const double threshold = static_cast<double>(step) / kConnectivitySteps - 1e-9;
    const cv::Mat component = largest_component((a >= threshold) & (b >= threshold));
    const cv::Mat lost = (level < 0) & ~component;
    level.setTo(static_cast<double>(step - 1) / kConnectivitySteps, lost);
  }
  level.setTo(1, level < 0);
  double sum = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const auto connected = [&](double alpha) {
        const double d = alpha - level.at<double>(y, x);
        return d >= kForgivenStep ? 1 - d : 1.0;
      };
      sum += std::abs(connected(a.at<double>(y, x)) - connected(b.at<double>(y, x)));
    }
  }
  return sum;
}

double matte_iou(const Image& matte, const Image& truth) {
  check_mattes(matte, truth);
  const cv::Mat a = subject(matte), b = subject(truth);
  const int either = cv::countNonZero(a | b);
  return either == 0 ? 1.0 : static_cast<double>(cv::countNonZero(a & b)) / either;
}

double matte_boundary_f(const Image& matte, const Image& truth) {
  check_mattes(matte, truth);
  const cv::Mat a = boundary(subject(matte)), b = boundary(subject(truth));
  const int in_a = cv::countNonZero(a), in_b = cv::countNonZero(b);
  if (in_a == 0 || in_b == 0) return in_a == in_b ? 1.0 : 0.0;
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  cv::Mat near_a, near_b;
  cv::dilate(a, near_a, cross);
  cv::dilate(b, near_b, cross);
  const double precision = static_cast<double>(cv::countNonZero(a & near_b)) / in_a;
  const double recall = static_cast<double>(cv::countNonZero(b & near_a)) / in_b;
  return precision + recall == 0 ? 0.0 : 2 * precision * recall / (precision + recall);
}

double matte_dtssd(const Image& before, const Image& now, const Image& truth_before, const Image& truth_now) {
  check_mattes(before, now);
  check_mattes(now, truth_before);
  check_mattes(truth_before, truth_now);
  double sum = 0;
  for (std::size_t i = 0; i < now.pixels.size(); ++i) {
    const double d = (now.pixels[i] - before.pixels[i]) - (truth_now.pixels[i] - truth_before.pixels[i]);
    sum += d * d / (255.0 * 255.0);
  }
  return std::sqrt(sum / pixels_of(now));
}

MatteScores score_matte(const Image& matte, const Image& truth) {
  return {matte_sad(matte, truth),
          matte_mad(matte, truth),
          matte_mse(matte, truth),
          matte_gradient_error(matte, truth),
          matte_connectivity_error(matte, truth),
          matte_iou(matte, truth),
          matte_boundary_f(matte, truth)};
}

}  // namespace floatstage::pipeline
