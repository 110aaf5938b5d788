#include "calib/color.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Parameters = Eigen::Matrix<double, 12, 1>;  // logarithms of three exponents, then the matrix by rows

constexpr double kEncode = 2.2;

ColorTransform transform_of(const Parameters& p) {
  ColorTransform t;
  t.encode = kEncode;
  for (int i = 0; i < 3; ++i) t.decode[i] = std::exp(p[i]);
  for (int i = 0; i < 9; ++i) t.matrix(i / 3, i % 3) = p[3 + i];
  return t;
}

// Differences in CIELAB; like apply() without its upper clamp, so that slopes lead back from where it would
// cut off.
Eigen::VectorXd residuals(const Parameters& p, const std::vector<ColorPair>& pairs,
                          const std::vector<Eigen::Vector3d>& wanted) {
  const ColorTransform t = transform_of(p);
  Eigen::VectorXd r(static_cast<Eigen::Index>(3 * pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Eigen::Vector3d light;
    for (int c = 0; c < 3; ++c) light[c] = std::pow(pairs[i].seen[c], t.decode[c]);
    light = (t.matrix * light).cwiseMax(1e-6);
    for (int c = 0; c < 3; ++c) light[c] = std::pow(light[c], 1 / t.encode);
    r.segment<3>(static_cast<Eigen::Index>(3 * i)) = lab_from_srgb(light) - wanted[i];
  }
  return r;
}

// Cauchy weights: a pair that is off by 8 counts half, one that is off by 30 hardly.
Eigen::VectorXd weights(const Eigen::VectorXd& r) {
  Eigen::VectorXd w(r.size());
  for (Eigen::Index i = 0; i < r.size(); i += 3)
    w.segment<3>(i).setConstant(1 / (1 + r.segment<3>(i).squaredNorm() / 64));
  return w;
}

double cost(const Eigen::VectorXd& r) {
  double sum = 0;
  for (Eigen::Index i = 0; i < r.size(); i += 3) sum += std::log1p(r.segment<3>(i).squaredNorm() / 64);
  return sum;
}

Parameters descend(Parameters p, const std::vector<ColorPair>& pairs,
                   const std::vector<Eigen::Vector3d>& wanted) {
  double damping = 1e-3;
  Eigen::VectorXd r = residuals(p, pairs, wanted);
  for (int step = 0; step < 200 && damping < 1e8; ++step) {
    Eigen::MatrixXd j(r.size(), 12);
    for (int k = 0; k < 12; ++k) {
      Parameters moved = p;
      moved[k] += 1e-6;
      j.col(k) = (residuals(moved, pairs, wanted) - r) / 1e-6;
    }
    const Eigen::VectorXd w = weights(r);
    Eigen::Matrix<double, 12, 12> h = j.transpose() * w.asDiagonal() * j;
    const Parameters g = j.transpose() * w.asDiagonal() * r;
    h.diagonal().array() *= 1 + damping;
    h.diagonal().array() += 1e-9;
    const Parameters next = p - h.ldlt().solve(g);
    const Eigen::VectorXd after = residuals(next, pairs, wanted);
    const bool better = next.allFinite() && next.head<3>().cwiseAbs().maxCoeff() < 2 && cost(after) < cost(r);
    damping = better ? damping / 5 : damping * 4;
    if (!better) continue;
    const double moved = (next - p).norm();
    p = next, r = after;
    if (moved < 1e-8) break;
  }
  return p;
}

}  // namespace

Result<ColorFit> fit_color(std::span<const ColorPair> pairs) {
  constexpr std::size_t kLeast = 10;
  std::vector<ColorPair> used;
  std::vector<Eigen::Vector3d> wanted;
  for (const ColorPair& pair : pairs) {
    if (!(pair.seen.minCoeff() >= 0.01 && pair.seen.maxCoeff() <= 0.99) ||
        !(pair.wanted.minCoeff() >= 0 && pair.wanted.maxCoeff() <= 1))
      continue;
    used.push_back(pair);
    wanted.push_back(lab_from_srgb(pair.wanted));
  }
  if (used.size() < kLeast)
    return fail(ErrorCode::BadData, text("only ", used.size(), " of ", pairs.size(),
                                         " colours are neither under- nor overexposed; ", kLeast,
                                         " are needed: change the exposure"));
  Eigen::MatrixXd spread(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t i = 0; i < used.size(); ++i) spread.row(static_cast<Eigen::Index>(i)) = used[i].seen;
  const Eigen::Vector3d widths = (spread.rowwise() - spread.colwise().mean()).jacobiSvd().singularValues() /
                                 std::sqrt(static_cast<double>(used.size()));
  if (widths[2] < 0.01)
    return fail(ErrorCode::BadData,
                "the colours are too much alike to tell a camera's channels apart; show the chart, or "
                "something colourful");

  // The start: curves of 2.2 and gains from the means.
  Parameters start = Parameters::Zero();
  start.head<3>().setConstant(std::log(kEncode));
  for (int c = 0; c < 3; ++c) {
    double seen = 0, sum = 0;
    for (const ColorPair& pair : used)
      seen += std::pow(pair.seen[c], kEncode), sum += std::pow(pair.wanted[c], kEncode);
    start[3 + 4 * c] = sum / seen;
  }
  ColorFit fit;
  fit.transform = transform_of(descend(start, used, wanted));
  fit.used = static_cast<int>(used.size());
  std::vector<double> off;
  for (std::size_t i = 0; i < used.size(); ++i) {
    off.push_back(delta_e_2000(lab_from_srgb(apply(fit.transform, used[i].seen)), wanted[i]));
    fit.mean_before += delta_e_2000(lab_from_srgb(used[i].seen), wanted[i]) / fit.used;
    fit.mean_delta_e += off.back() / fit.used;
  }
  fit.p95_delta_e = percentile(std::move(off), 0.95);
  return fit;
}

const std::array<Eigen::Vector3d, 24>& chart_colors() {
  static const std::array<Eigen::Vector3d, 24> colors = [] {
    constexpr int kBytes[24][3] = {
        {115, 82, 68},   {194, 150, 130}, {98, 122, 157},  {87, 108, 67},   {133, 128, 177}, {103, 189, 170},
        {214, 126, 44},  {80, 91, 166},   {193, 90, 99},   {94, 60, 108},   {157, 188, 64},  {224, 163, 46},
        {56, 61, 150},   {70, 148, 73},   {175, 54, 60},   {231, 199, 31},  {187, 86, 149},  {8, 133, 161},
        {243, 243, 242}, {200, 200, 200}, {160, 160, 160}, {122, 122, 121}, {85, 85, 85},    {52, 52, 52}};
    std::array<Eigen::Vector3d, 24> all;
    for (std::size_t i = 0; i < 24; ++i)
      all[i] = Eigen::Vector3d(kBytes[i][0], kBytes[i][1], kBytes[i][2]) / 255;
    return all;
  }();
  return colors;
}

Result<std::array<Eigen::Vector3d, 24>> find_color_chart(const Image& rgb) {
  if (rgb.channels != 3)
    return fail(ErrorCode::InvalidArgument, "a colour chart is looked for in pictures of three channels");
  const cv::Mat pixels(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr, cv::COLOR_RGB2BGR);
  const cv::Ptr<cv::mcc::CCheckerDetector> detector = cv::mcc::CCheckerDetector::create();
  bool found = false;
  try {
    found = detector->process(bgr, cv::mcc::MCC24, 1);
  } catch (const cv::Exception&) {  // it indexes empty lists where it sees no squares
    found = false;
  }
  const auto chart = found ? detector->getBestColorChecker() : cv::Ptr<cv::mcc::CChecker>();
  if (!chart)
    return fail(
        ErrorCode::NotFound,
        "no 24-patch colour chart was found; show it whole, flat and at least a tenth of the picture wide");
  const std::vector<cv::Point2f> corners = chart->getBox();
  if (corners.size() != 4) return fail(ErrorCode::NotFound, "no 24-patch colour chart was found");
  // Means over the inner half of every patch: six columns and four rows of the chart's box.
  std::array<Eigen::Vector3d, 24> colors;
  const std::array<cv::Point2f, 4> flat = {cv::Point2f(0, 0), {240, 0}, {240, 160}, {0, 160}};
  cv::Mat straight;
  cv::warpPerspective(pixels, straight, cv::getPerspectiveTransform(corners.data(), flat.data()), {240, 160},
                      cv::INTER_AREA);
  for (int i = 0; i < 24; ++i) {
    const cv::Scalar mean = cv::mean(straight({i % 6 * 40 + 13, i / 6 * 40 + 13, 14, 14}));
    colors[static_cast<std::size_t>(i)] = Eigen::Vector3d(mean[0], mean[1], mean[2]) / 255;
  }
  return colors;
}

}  // namespace floatstage::calib
