// Method:  the matte that composes its picture best and is calm wins
// Paper:   none: the residual of compositing, with colours extended from where all mattes agree
// Differs: residual times flicker decides, with an advantage for
//          the method that is usually best
// ADR:     0099

#include "matting/method_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "matting/video/video_matting.h"

namespace floatstage::matting {
namespace {

constexpr int kSurelySubject = 250, kSurelyBackground = 5;
constexpr double kMostError = 48;       // 8-bit steps: beyond, wrong is wrong
constexpr double kLeastFlicker = 1e-5;  // below, all are calm
constexpr double kTells = 0.1;   // of a score: on clips with exact truth smaller differences err both ways
constexpr int kConfident = 128;  // of Plate::confidence
constexpr double kSigmas[] = {2, 6, 18, 54};  // px: how far colours are extended, first as near as possible

// Where pixels are that an 8-bit mask marks, and as far around them as a Gaussian of `sigma` reaches in
// OpenCV's kernel.
cv::Rect felt_around(const cv::Mat& marked, double sigma) {
  const int reach = cvRound(sigma * 4) + 1;
  cv::Rect box = cv::boundingRect(marked);
  box = {box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach};
  return box & cv::Rect({}, marked.size());
}

// Colours of the chosen pixels extended over those that are asked for, and as many others as come with them:
// normalised convolution with ever wider Gaussians, the narrowest that finds anything.
cv::Mat extended(const cv::Mat& picture, const cv::Mat& chosen, const cv::Mat& asked) {
  cv::Mat weight, out = cv::Mat::zeros(picture.size(), CV_32FC3);
  chosen.convertTo(weight, CV_32F, 1 / 255.0);
  cv::Mat weighted = picture.clone();
  weighted.setTo(cv::Scalar::all(0), ~chosen);
  cv::Mat done = cv::Mat::zeros(picture.size(), CV_8U);
  for (const double sigma : kSigmas) {
    const cv::Mat missing = asked & ~done;
    if (cv::countNonZero(missing) == 0) break;
    const cv::Rect box = felt_around(missing, sigma);
    cv::Mat sum, total;
    cv::GaussianBlur(weighted(box), sum, {}, sigma, sigma, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
    cv::GaussianBlur(weight(box), total, {}, sigma, sigma, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x) {
        const float t = total.at<float>(y, x);
        if (!missing.at<std::uint8_t>(y + box.y, x + box.x) || t < 0.02f) continue;
        out.at<cv::Vec3f>(y + box.y, x + box.x) = sum.at<cv::Vec3f>(y, x) / t;
        done.at<std::uint8_t>(y + box.y, x + box.x) = 255;
      }
  }
  return out;
}

bool has_subject(const Image& matte) {
  return std::any_of(matte.pixels.begin(), matte.pixels.end(), [](int a) { return a >= 128; });
}

}  // namespace

std::vector<double> composite_residuals(const Image& picture, const std::vector<Image>& candidates,
                                        const Plate* plate) {
  constexpr double kRefused = std::numeric_limits<double>::infinity();
  std::vector<double> residuals(candidates.size(), kRefused);
  const bool somebody = std::any_of(candidates.begin(), candidates.end(), has_subject);
  std::vector<std::size_t> fit;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Image& c = candidates[i];
    if (c.channels == 1 && c.width == picture.width && c.height == picture.height &&
        (has_subject(c) || !somebody))
      fit.push_back(i);
  }
  if (fit.empty()) return residuals;
  cv::Mat subject(picture.height, picture.width, CV_8U, cv::Scalar(255)), background = subject.clone();
  for (const std::size_t i : fit) {
    const cv::Mat alpha(picture.height, picture.width, CV_8U,
                        const_cast<std::uint8_t*>(candidates[i].pixels.data()));
    subject &= alpha >= kSurelySubject;
    background &= alpha <= kSurelyBackground;
  }
  cv::Mat colors;
  cv::Mat(picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.pixels.data()))
      .convertTo(colors, CV_32F);
  const cv::Mat mixed = ~(subject | background);
  const cv::Mat f = extended(colors, subject, mixed);
  cv::Mat b = extended(colors, background, mixed);
  if (plate && plate->color.width == picture.width && plate->color.height == picture.height)
    for (int y = 0; y < b.rows; ++y)
      for (int x = 0; x < b.cols; ++x)
        if (*plate->confidence.at(x, y) >= kConfident)
          for (int c = 0; c < 3; ++c) b.at<cv::Vec3f>(y, x)[c] = plate->color.at(x, y)[c];
  for (const std::size_t i : fit) {
    double sum = 0;
    long count = 0;
    for (int y = 0; y < b.rows; ++y) {
      for (int x = 0; x < b.cols; ++x) {
        if (mixed.at<std::uint8_t>(y, x) == 0) continue;
        const float a = static_cast<float>(*candidates[i].at(x, y)) / 255;
        const cv::Vec3f error =
            colors.at<cv::Vec3f>(y, x) - a * f.at<cv::Vec3f>(y, x) - (1 - a) * b.at<cv::Vec3f>(y, x);
        sum += std::min(kMostError, cv::norm(error) / std::sqrt(3.0));
        ++count;
      }
    }
    residuals[i] = count ? sum / static_cast<double>(count) : 0;
  }
  return residuals;
}

void MethodComparison::add(const Image& picture, const std::vector<Image>& mattes, const Plate* plate) {
  const std::vector<double> residuals = composite_residuals(picture, mattes, plate);
  for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] += residuals.at(i);
  ++frames_;
}

void MethodComparison::add_pair(const Image& before, const std::vector<Image>& mattes_before,
                                const Image& picture, const std::vector<Image>& mattes) {
  std::vector<double> flicker;
  for (std::size_t i = 0; i < flicker_.size(); ++i) {
    const Result<double> one = matte_flicker(before, mattes_before.at(i), picture, mattes.at(i));
    if (!one) return;
    flicker.push_back(*one);
  }
  for (std::size_t i = 0; i < flicker.size(); ++i) flicker_[i] += flicker[i];
  ++pairs_;
}

std::vector<double> MethodComparison::scores() const {
  std::vector<double> scores(residual_.size());
  for (std::size_t i = 0; i < scores.size() && frames_ > 0; ++i) {
    scores[i] = residual_[i] / frames_;
    if (pairs_ > 0 && std::isfinite(scores[i])) scores[i] *= std::max(kLeastFlicker, flicker_[i] / pairs_);
  }
  return scores;
}

std::size_t MethodComparison::best(std::optional<std::size_t> usual) const {
  const std::vector<double> all = scores();
  const auto least = std::min_element(all.begin(), all.end());
  if (usual && all.at(*usual) * (1 - kTells) <= *least) return *usual;
  return static_cast<std::size_t>(least - all.begin());
}

}  // namespace floatstage::matting
