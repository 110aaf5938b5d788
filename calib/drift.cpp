#include "calib/drift.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "calib/grey.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr int kHalf = kDriftPatch / 2;
constexpr double kDegree = std::numbers::pi / 180;
constexpr int kFewestMatches = 8;

// A patch found again: the rays through it then and now, and the focal length there in px a radian.
struct Match {
  Eigen::Vector3d before, now;
  Eigen::Vector2d moved;  // px
};

// Where the patch is now, by normalised correlation, to a fraction of a pixel; absent where nothing looks
// like it.
std::optional<Eigen::Vector2d> find_again(const cv::Mat& grey, const DriftPatch& patch, int reach) {
  constexpr float kAlike = 0.8f;
  const int x = static_cast<int>(patch.at.x()), y = static_cast<int>(patch.at.y());  // the centre pixel
  const cv::Rect window(x - kHalf - reach, y - kHalf - reach, kDriftPatch + 2 * reach,
                        kDriftPatch + 2 * reach);
  const cv::Rect inside = window & cv::Rect(0, 0, grey.cols, grey.rows);
  if (inside.width < kDriftPatch + 2 || inside.height < kDriftPatch + 2) return std::nullopt;
  const cv::Mat wanted(kDriftPatch, kDriftPatch, CV_8U, const_cast<std::uint8_t*>(patch.grey.data()));
  cv::Mat score;
  cv::matchTemplate(grey(inside), wanted, score, cv::TM_CCOEFF_NORMED);
  cv::Point best;
  double height = 0;
  cv::minMaxLoc(score, nullptr, &height, nullptr, &best);
  if (!(height >= kAlike) || best.x < 1 || best.y < 1 || best.x + 1 >= score.cols || best.y + 1 >= score.rows)
    return std::nullopt;
  auto peak = [](float a, float b, float c) {
    return a + c - 2 * b < 0 ? 0.5 * (a - c) / (a + c - 2 * b) : 0.0;
  };
  const double dx =
      peak(score.at<float>(best.y, best.x - 1), score.at<float>(best), score.at<float>(best.y, best.x + 1));
  const double dy =
      peak(score.at<float>(best.y - 1, best.x), score.at<float>(best), score.at<float>(best.y + 1, best.x));
  return Eigen::Vector2d(inside.x + best.x + kHalf + 0.5 + dx, inside.y + best.y + kHalf + 0.5 + dy);
}

// The turn that takes the rays of before to those of now (Kabsch, for small angles: linear least squares,
// repeated).
Eigen::Vector3d fit_turn(const std::vector<Match>& matches, const std::vector<double>& weights,
                         Eigen::Matrix3d* information = nullptr) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (int step = 0; step < 3; ++step) {
    Eigen::Matrix3d h = 1e-12 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    const Eigen::Matrix3d r = turn.norm() > 0
                                  ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                                  : Eigen::Matrix3d::Identity();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const Eigen::Vector3d a = r * matches[i].before;
      Eigen::Matrix3d cross;  // d(turn × a)/d(turn) = -[a]×
      cross << 0, a.z(), -a.y(), -a.z(), 0, a.x(), a.y(), -a.x(), 0;
      h += weights[i] * cross.transpose() * cross;
      g += weights[i] * cross.transpose() * (matches[i].now - a);
    }
    turn += h.ldlt().solve(g);
    if (information) *information = h;
  }
  return turn;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& turn) {
  if (turn.norm() == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

// Parallax that `turn` leaves, and the direction that explains it: rays before and after lie in one plane
// with the move (Longuet-Higgins 1981, the turn being known; what it took of a sideways shift runs along the
// same lines). People are outliers: medians and falling weights.
void measure_parallax(const std::vector<Match>& matches, const Eigen::Vector3d& turn, double pixel,
                      CameraTurn& result) {
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> shifts;
  for (const Match& m : matches) {
    normals.emplace_back((rotation(turn) * m.before).cross(m.now));
    shifts.push_back(normals.back().norm() / pixel);
  }
  result.parallax_px = percentile(std::move(shifts), 0.75);
  // Those that shift far more than most are people from the start.
  std::vector<double> weights, across(matches.size());
  for (const Eigen::Vector3d& n : normals)
    weights.push_back(n.norm() < 2 * pixel * result.parallax_px ? 1 : 0);
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (int step = 0; step < 10; ++step) {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < normals.size(); ++i)
      moment += weights[i] * normals[i] * normals[i].transpose();
    direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moment).eigenvectors().col(0);
    for (std::size_t i = 0; i < normals.size(); ++i) across[i] = std::abs(normals[i].dot(direction));
    const double scale = std::max(0.2 * pixel, 2 * median(across));
    for (std::size_t i = 0; i < normals.size(); ++i) weights[i] = 1 / (1 + std::pow(across[i] / scale, 2));
  }
  result.epipolar_px = median(across) / pixel;
}

// How far off a turn leaves each match, in rad.
std::vector<double> errors_of(const std::vector<Match>& matches, const Eigen::Vector3d& turn) {
  const Eigen::Matrix3d r = rotation(turn);
  std::vector<double> e;
  for (const Match& m : matches) e.push_back((m.now - r * m.before).norm());
  return e;
}

// Each pair of matches proposes a turn; the one with the least median error leads (no chance is involved).
// Returns that error.
double lead_by_consensus(const std::vector<Match>& matches, Eigen::Vector3d& best) {
  best = Eigen::Vector3d::Zero();
  double least = median(errors_of(matches, best));
  const std::size_t stride = matches.size() / 2;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::vector<Match> pair = {matches[i], matches[(i + stride) % matches.size()]};
    const Eigen::Vector3d turn = fit_turn(pair, {1, 1});
    const double e = median(errors_of(matches, turn));
    if (e < least) least = e, best = turn;
  }
  return least;
}

double hundredths(double v) { return std::round(100 * v) / 100; }

}  // namespace

Result<DriftReference> make_drift_reference(const Rig& rig, const std::vector<Image>& images, int most) {
  if (images.size() != rig.cameras.size())
    return fail(ErrorCode::InvalidArgument,
                text(images.size(), " pictures for ", rig.cameras.size(), " cameras"));
  DriftReference reference;
  for (std::size_t c = 0; c < images.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    reference.serials.push_back(camera.serial);
    std::vector<DriftPatch>& patches = reference.patches.emplace_back();
    if (images[c].empty()) continue;
    if (images[c].width != camera.model.width || images[c].height != camera.model.height)
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", camera.serial, "': the picture is ", images[c].width, "x",
                       images[c].height, ", not ", camera.model.width, "x", camera.model.height));
    const cv::Mat grey = grey_of(images[c]);
    cv::Mat corner;
    cv::cornerMinEigenVal(grey, corner, 7, 3);
    // The best place of each cell, so that a turn is seen all over the picture.
    const int across = std::max(2, static_cast<int>(std::lround(std::sqrt(most * 4.0 / 3)))),
              down = std::max(2, most / across);
    const int rim = kHalf + 4;
    for (int row = 0; row < down; ++row) {
      for (int column = 0; column < across; ++column) {
        const int x0 = std::max(column * grey.cols / across, rim),
                  x1 = std::min((column + 1) * grey.cols / across, grey.cols - rim);
        const int y0 = std::max(row * grey.rows / down, rim),
                  y1 = std::min((row + 1) * grey.rows / down, grey.rows - rim);
        if (x1 <= x0 || y1 <= y0) continue;
        double strength = 0;
        cv::Point best;
        cv::minMaxLoc(corner({x0, y0, x1 - x0, y1 - y0}), nullptr, &strength, nullptr, &best);
        if (strength < 2e-4) continue;  // flat: nothing to hold on to
        const int x = x0 + best.x, y = y0 + best.y;
        DriftPatch patch{.at = {x + 0.5, y + 0.5}, .grey = {}};
        for (int v = y - kHalf; v <= y + kHalf; ++v)
          for (int u = x - kHalf; u <= x + kHalf; ++u) patch.grey.push_back(grey.at<std::uint8_t>(v, u));
        patches.push_back(std::move(patch));
      }
    }
  }
  return reference;
}

CameraTurn measure_turn(const CameraModel& model, const std::vector<DriftPatch>& reference,
                        const Image& image) {
  CameraTurn result;
  result.patches = static_cast<int>(reference.size());
  if (image.width != model.width || image.height != model.height) return result;
  const cv::Mat grey = grey_of(image);
  const int reach = std::max(8, model.width / 50);
  std::vector<Match> matches;
  std::vector<double> shifts;
  for (const DriftPatch& patch : reference) {
    const std::optional<Eigen::Vector2d> at = find_again(grey, patch, reach);
    const auto before = unproject(model, patch.at), now = at ? unproject(model, *at) : std::nullopt;
    if (!before || !now) continue;
    matches.push_back({before->normalized(), now->normalized(), *at - patch.at});
    shifts.push_back((*at - patch.at).norm());
  }
  result.matches = static_cast<int>(matches.size());
  if (result.matches < kFewestMatches) return result;
  result.moved_px = median(shifts);

  const double pixel = 1 / model.fx;
  Eigen::Vector3d best;
  const double least = lead_by_consensus(matches, best);
  // All that agree, to a pixel or three times their own spread.
  const double slack = std::max(pixel, 3 * least);
  Eigen::Matrix3d information;
  std::vector<double> weights;
  int agree = 0;
  for (int step = 0; step < 3; ++step) {
    weights.clear();
    agree = 0;
    for (const double e : errors_of(matches, best))
      weights.push_back(e <= slack ? 1 : 0), agree += e <= slack;
    best = fit_turn(matches, weights, &information);
  }
  double squares = 0;
  const std::vector<double> last = errors_of(matches, best);
  for (std::size_t i = 0; i < last.size(); ++i) squares += weights[i] * last[i] * last[i];
  const double rms = std::sqrt(squares / std::max(agree, 1));
  result.residual_px = rms / pixel;
  result.axis_degrees = best / kDegree;
  result.degrees = best.norm() / kDegree;
  result.sigma_degrees = std::sqrt(information.inverse().diagonal().maxCoeff() / 2) * rms / kDegree;
  result.known = agree >= kFewestMatches && 2 * agree >= result.matches;
  measure_parallax(matches, best, pixel, result);
  return result;
}

DriftWatch::DriftWatch(const Rig& rig, DriftReference reference, const DriftOptions& options)
    : rig_(rig),
      reference_(std::move(reference)),
      options_(options),
      turns_(rig.cameras.size()),
      in_a_row_(rig.cameras.size(), 0),
      alarmed_(rig.cameras.size(), false) {}

Result<DriftWatch> DriftWatch::create(const Rig& rig, DriftReference reference, const DriftOptions& options) {
  bool same =
      reference.serials.size() == rig.cameras.size() && reference.patches.size() == rig.cameras.size();
  for (std::size_t i = 0; same && i < rig.cameras.size(); ++i)
    same = reference.serials[i] == rig.cameras[i].serial;
  if (!same)
    return fail(
        ErrorCode::InvalidArgument,
        "the drift reference names other cameras than the rig; make it anew from this rig's pictures");
  return DriftWatch(rig, std::move(reference), options);
}

std::optional<DriftAlarm> DriftWatch::check(int camera, double time, const Image& image) {
  FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(rig_.cameras.size()), "no such camera");
  const std::size_t c = static_cast<std::size_t>(camera);
  CameraTurn& turn = turns_[c];
  turn = measure_turn(rig_.cameras[c].model, reference_.patches[c], image);
  if (!turn.known) return std::nullopt;  // hidden by people or dark: neither moved nor at rest
  const bool turned = turn.degrees > options_.alarm_degrees && turn.degrees > 4 * turn.sigma_degrees;
  // Noise shifts patches every way, a move along one direction only.
  const bool moved =
      turn.parallax_px > options_.alarm_parallax_px && turn.epipolar_px < 0.3 * turn.parallax_px;
  if (!turned && !moved) {
    in_a_row_[c] = 0;
    alarmed_[c] = false;
    return std::nullopt;
  }
  if (++in_a_row_[c] < options_.consecutive || alarmed_[c]) return std::nullopt;
  alarmed_[c] = true;
  const std::string& serial = rig_.cameras[c].serial;
  std::string sentence =
      text("camera '", serial, "' has ", moved ? "moved and " : "", "turned by ", hundredths(turn.degrees),
           "° (pitch ", hundredths(turn.axis_degrees.x()), "°, yaw ", hundredths(turn.axis_degrees.y()),
           "°, roll ", hundredths(turn.axis_degrees.z()), "°) since the calibration");
  if (moved)
    sentence += text("; near things shifted by ", hundredths(turn.parallax_px), " px against far ones");
  return DriftAlarm{serial,
                    time,
                    turn.degrees,
                    turn.residual_px,
                    moved,
                    turn.parallax_px,
                    sentence + "; set it right or calibrate again"};
}

}  // namespace floatstage::calib
