// Method:  match along epipolar lines, join to points, solve for poses, points and lenses together; three
//          times, more often where lenses are unknown
// Paper:   none; the solution is calibrate()'s
// Differs: an unknown lens is plain: square pixels and two radial coefficients are all that a scene tells
// ADR:     0149, 0228

#include "calib/scene_settling.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>

#include "calib/calibrate.h"
#include "calib/scene_features.h"
#include "calib/scene_matching.h"
#include "calib/solver/ring.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

// Lines of sight may miss one another by this many pixels: where poses are COLMAP's or yesterday's, and where
// they were refined.
constexpr double kRoughly = 6, kClosely = 2;
// An unknown lens has settled when its focal length changes by less than this share, or after so many rounds
// more.
constexpr double kSettled = 2e-4;
constexpr int kMostRounds = 4;
// Sigmas by which points may pull a camera off the ring that it is said to stand on.
constexpr double kOffRing = 4;

// A camera for the solver; what its lens may do is set afterwards.
CalibrationCamera solver_camera(const RigCamera& c) {
  CalibrationCamera camera;
  camera.serial = c.serial;
  camera.width = c.model.width;
  camera.height = c.model.height;
  camera.lens = c.model.lens.index() == 0 ? LensKind::None : static_cast<LensKind>(c.model.lens.index());
  camera.intrinsics = Prior::Fixed;
  camera.model = c.model;
  camera.found = c.cam_from_world;
  return camera;
}

// Cameras and points as they are found, the distance of the two outermost cameras held.
Observations observations_of(const std::vector<MarkerlessPicture>& pictures, const MarkerlessResult& found,
                             Lenses lenses) {
  Observations o;
  std::vector<int> camera_of;
  double widest = 0;
  CameraDistance held;
  std::map<std::pair<double, double>, int> alike;  // given lenses, by their numbers
  for (std::size_t i = 0; i < found.rig.cameras.size(); ++i) {
    const RigCamera& c = found.rig.cameras[i];
    CalibrationCamera camera = solver_camera(c);
    const auto index = static_cast<int>(i);
    camera_of.push_back(index);
    if (pictures[i].lens != Prior::Fixed) {
      camera.intrinsics = Prior::Start;
      camera.plain_lens = true;
      camera.same_lens_as = pictures[i].same_lens_as;
    } else if (lenses == Lenses::AllFree) {
      camera.intrinsics = Prior::Start;
      camera.plain_lens = true;
      const auto [owner, is_new] = alike.try_emplace({c.model.fx, c.model.cx}, index);
      if (!is_new && found.rig.cameras[static_cast<std::size_t>(owner->second)].model == c.model)
        camera.same_lens_as = owner->second;
    }
    if (const double apart =
            (c.cam_from_world.center() - found.rig.cameras.front().cam_from_world.center()).norm();
        apart > widest) {
      widest = apart;
      held = {0, index, apart, 1e-3 * apart};
    }
    o.cameras.push_back(std::move(camera));
  }
  if (widest > 0) o.distances.push_back(held);
  add_features(o, found.features, camera_of);
  return o;
}

// Points a picture.
std::vector<int> points_of(const std::vector<MarkerlessPicture>& pictures, const MarkerlessResult& result) {
  std::vector<int> counts(pictures.size());
  for (const SceneFeature& f : result.features)
    for (const auto& [picture, pixel] : f.seen) ++counts[static_cast<std::size_t>(picture)];
  return counts;
}

// A reprojection error would look fine all the same.
Result<void> check_ties(const std::vector<MarkerlessPicture>& pictures, const MarkerlessResult& result,
                        const MarkerlessOptions& options, const char* advice) {
  if (result.mean_track < options.least_track)
    return fail(ErrorCode::BadData,
                text("a point is seen by ", std::round(10 * result.mean_track) / 10,
                     " cameras on average, and by ", options.least_track,
                     " at least it should be: poses could be off although the reprojection error is ",
                     std::round(100 * result.rms_px) / 100, " px; ", advice));
  const std::vector<int> counts = points_of(pictures, result);
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i] < options.least_points)
      return fail(ErrorCode::BadData, text("camera '", pictures[i].serial, "' shows only ", counts[i],
                                           " points, and ", options.least_points, " are needed: ", advice));
  return {};
}

// How much the focal lengths differ, at most, as a share.
double focal_change(const Rig& before, const Rig& after) {
  double most = 0;
  for (std::size_t i = 0; i < before.cameras.size(); ++i)
    most = std::max(most, std::abs(after.cameras[i].model.fx / before.cameras[i].model.fx - 1));
  return most;
}

}  // namespace

void add_points(std::span<const SceneKeypoints> keypoints, double tolerance, int threads,
                MarkerlessResult& result) {
  result.features = points_of_matches(keypoints, match_along_lines(keypoints, result.rig, tolerance, threads),
                                      result.rig, tolerance);
  double squares = 0;
  std::size_t sights = 0;
  for (const SceneFeature& f : result.features)
    for (const auto& [picture, pixel] : f.seen) {
      const RigCamera& c = result.rig.cameras[static_cast<std::size_t>(picture)];
      squares += (project(c.model, c.cam_from_world * f.position).value_or(pixel) - pixel).squaredNorm();
      ++sights;
    }
  const double points = static_cast<double>(std::max<std::size_t>(result.features.size(), 1));
  result.mean_track = static_cast<double>(sights) / points;
  result.rms_px = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(sights, 1)));
}

// Points that pull cameras off a ring say that there is none.
Result<void> check_ring(const std::vector<MarkerlessPicture>& pictures, const MarkerlessOptions& options,
                        MarkerlessResult& result) {
  if (!(options.ring > 0)) return {};
  std::vector<Eigen::Vector3d> centers;
  for (const RigCamera& c : result.rig.cameras) centers.push_back(c.cam_from_world.center());
  const std::optional<solver::Ring> ring = solver::fit_ring(centers);
  if (!ring)
    return fail(
        ErrorCode::BadData,
        "'ring' says that the cameras stand on a circle, but there are fewer than four, or they stand in "
        "one line; leave it out");
  double squares = 0, most = 0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    const double off = ring->off(centers[i]).norm() / ring->radius;
    squares += off * off;
    if (off > most) most = off, worst = i;
  }
  result.off_ring = std::sqrt(squares / static_cast<double>(centers.size()));
  if (most <= kOffRing * options.ring) return {};
  const auto percent = [](double share) { return std::round(1e4 * share) / 100; };
  return fail(ErrorCode::BadData,
              text("the cameras do not stand on a ring as 'ring' says: camera '", pictures[worst].serial,
                   "' is ", percent(most), " % of the radius off the circle that fits best, all are ",
                   percent(*result.off_ring), " % off (rms), and one sigma was said to be ",
                   percent(options.ring), " %; leave 'ring' out, or give a share that is true"));
}

Result<void> settle(const std::vector<MarkerlessPicture>& pictures, std::span<const SceneKeypoints> keypoints,
                    const MarkerlessOptions& options, const char* advice, MarkerlessResult& result) {
  const bool unknown = std::any_of(pictures.begin(), pictures.end(),
                                   [](const MarkerlessPicture& p) { return p.lens != Prior::Fixed; });
  const int rounds = unknown ? 3 + kMostRounds : 3;
  for (int round = 0; round < rounds; ++round) {
    if (options.cancelled && options.cancelled())
      return fail(ErrorCode::Cancelled, "placing the cameras was interrupted");
    add_points(keypoints, round == 0 ? kRoughly : kClosely, options.threads, result);
    // With a lens that is only begun to be known, points that belong together seem not to.
    if (!unknown || round >= 2)
      if (Result<void> ok = check_ties(pictures, result, options, advice); !ok) return ok;
    // From the second time on, matches depend on where the poses began by next to nothing.
    Result<Calibration> solved =
        calibrate(observations_of(pictures, result, Lenses::AsGiven),
                  {.holdout_every = 0, .threads = options.threads, .ring = options.ring});
    if (!solved)
      return fail(solved.error().code,
                  text("the cameras do not agree: ", solved.error().message, "; ", advice));
    const double change = focal_change(result.rig, solved->rig);
    result.rig = std::move(solved->rig);
    if (round >= 2 && change < kSettled) break;
  }
  if (Result<void> ok = check_ring(pictures, options, result); !ok) return ok;
  add_points(keypoints, kClosely, options.threads, result);
  return check_ties(pictures, result, options, advice);
}

Result<std::vector<SuspectLens>> suspect_lenses(const std::vector<MarkerlessPicture>& pictures,
                                                const MarkerlessResult& settled, double least, int threads) {
  std::vector<SuspectLens> out;
  const Observations o = observations_of(pictures, settled, Lenses::AllFree);
  const Result<Calibration> solved = calibrate(o, {.holdout_every = 0, .threads = threads});
  if (!solved) return forward(solved);
  constexpr double kSigmas = 5;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].lens != Prior::Fixed || o.cameras[i].same_lens_as) continue;
    const SuspectLens s{i, pictures[i].model.fx, solved->rig.cameras[i].model.fx,
                        solved->cameras[i].intrinsics_sigma[0]};
    if (std::abs(s.share()) > least && std::abs(s.found - s.given) > kSigmas * s.sigma) out.push_back(s);
  }
  return out;
}

std::string describe(const SuspectLens& s, const std::vector<MarkerlessPicture>& pictures) {
  return text("the suspect is the focal length given for camera '", pictures[s.picture].serial,
              "': ", std::fixed, std::setprecision(0), s.given, " px, where the pictures fit ", s.found,
              " px (±", std::setprecision(1), s.sigma, ", ", 100 * std::abs(s.share()), " % ",
              s.share() > 0 ? "longer" : "shorter",
              "); calibrate that lens again at this zoom, focus and picture size, or let it be solved for: "
              "[markerless] lens = \"shared\" or \"separate\"");
}

}  // namespace floatstage::calib
