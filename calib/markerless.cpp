#include "calib/markerless.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/calibrate.h"
#include "calib/colmap_steps.h"
#include "calib/formats/format_files.h"
#include "calib/scene_features.h"
#include "calib/scene_matching.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

// Lines of sight may miss one another by this many pixels: where poses are COLMAP's or yesterday's, and where
// they were refined.
constexpr double kRoughly = 6, kClosely = 2;

Result<ForeignRig> largest_model(const Colmap& colmap, const fs::path& workspace) {
  std::optional<ForeignRig> best;
  std::error_code error;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(workspace / "sparse", error))
    folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    const fs::path written = workspace / "model" / folder.filename();
    if (Result<void> ok = colmap.to_text(folder, written); !ok) return forward(ok);
    Result<ForeignRig> model = read_colmap(written);
    if (!model) return model;
    if (!best || best->rig.cameras.size() < model->rig.cameras.size()) best = *std::move(model);
  }
  if (!best) return fail(ErrorCode::BadData, text("COLMAP found no model: ", kWeakScene));
  return *std::move(best);
}

std::vector<SceneKeypoints> keypoints_of(const std::vector<MarkerlessPicture>& pictures, int threads) {
  std::vector<SceneKeypoints> out(pictures.size());
  parallel_for(pictures.size(), threads, [&](std::size_t i) { out[i] = find_keypoints(pictures[i].pixels); });
  return out;
}

// The points that keypoints show given the rig, and what can be said of them.
void add_points(const std::vector<SceneKeypoints>& keypoints, double tolerance, int threads,
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

// Poses and points solved for together; the distance of the two outermost cameras stays.
Result<Rig> refined(const MarkerlessResult& found, int threads) {
  Observations o;
  std::vector<int> camera_of;
  double widest = 0;
  CameraDistance held;
  for (const RigCamera& c : found.rig.cameras) {
    CalibrationCamera camera;
    camera.serial = c.serial;
    camera.width = c.model.width;
    camera.height = c.model.height;
    camera.lens = c.model.lens.index() == 0 ? camera.lens : static_cast<LensKind>(c.model.lens.index());
    camera.intrinsics = Prior::Fixed;
    camera.model = c.model;
    camera.found = c.cam_from_world;
    camera_of.push_back(static_cast<int>(o.cameras.size()));
    if (const double apart =
            (c.cam_from_world.center() - found.rig.cameras.front().cam_from_world.center()).norm();
        apart > widest) {
      widest = apart;
      held = {0, camera_of.back(), apart, 1e-3 * apart};
    }
    o.cameras.push_back(std::move(camera));
  }
  o.distances.push_back(held);
  add_features(o, found.features, camera_of);
  const Result<Calibration> solved = calibrate(o, {.holdout_every = 0, .threads = threads});
  if (!solved) return forward(solved);
  return solved->rig;
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

// From poses that are roughly right to poses and points that agree. From the second time on, matches depend
// on where the poses began by next to nothing.
Result<void> settle(const std::vector<MarkerlessPicture>& pictures,
                    const std::vector<SceneKeypoints>& keypoints, const MarkerlessOptions& options,
                    const char* advice, MarkerlessResult& result) {
  for (const double tolerance : {kRoughly, kClosely, kClosely}) {
    add_points(keypoints, tolerance, options.threads, result);
    if (Result<void> ok = check_ties(pictures, result, options, advice); !ok) return ok;
    Result<Rig> rig = refined(result, options.threads);
    if (!rig)
      return fail(rig.error().code, text("the cameras do not agree: ", rig.error().message, "; ", advice));
    result.rig = *std::move(rig);
  }
  add_points(keypoints, kClosely, options.threads, result);
  return {};
}

}  // namespace

Result<MarkerlessResult> calibrate_markerless(const std::vector<MarkerlessPicture>& pictures,
                                              const fs::path& workspace, const MarkerlessOptions& options) {
  const Colmap colmap(options, workspace);
  if (const Result<void> ready = colmap.prepare(pictures); !ready) return forward(ready);
  const std::vector<SceneKeypoints> keypoints = keypoints_of(pictures, options.threads);
  if (const Result<void> ok = colmap.import(pictures, keypoints, match_pictures(keypoints, options.threads));
      !ok)
    return forward(ok);
  // Intrinsics as they were given.
  if (const Result<void> ok =
          colmap.run("mapper",
                     {"--database_path", colmap.path("database.db"), "--image_path", colmap.path("images"),
                      "--output_path", colmap.path("sparse"), "--Mapper.ba_refine_focal_length", "0",
                      "--Mapper.ba_refine_principal_point", "0", "--Mapper.ba_refine_extra_params", "0",
                      "--Mapper.num_threads", "1", "--Mapper.filter_max_reproj_error", "2"},
                     kWeakScene);
      !ok)
    return forward(ok);
  const Result<ForeignRig> model = largest_model(colmap, workspace);
  if (!model) return forward(model);

  MarkerlessResult result;
  std::string missing;
  for (const MarkerlessPicture& p : pictures) {
    const std::vector<std::string>& names = model->image_names;
    const auto found = std::find(names.begin(), names.end(), image_name(p));
    if (found == names.end()) {
      missing += (missing.empty() ? "'" : ", '") + p.serial + "'";
      continue;
    }
    RigCamera camera = model->rig.cameras[static_cast<std::size_t>(found - names.begin())];
    camera.serial = p.serial;
    camera.model = p.model;
    result.rig.cameras.push_back(std::move(camera));
  }
  if (!missing.empty())
    return fail(ErrorCode::BadData, text("COLMAP placed ", result.rig.cameras.size(), " of ", pictures.size(),
                                         " cameras, not ", missing, ": ", kWeakScene));
  if (const Result<void> ok = settle(pictures, keypoints, options, kWeakScene, result); !ok)
    return fail(ok.error().code, text("where COLMAP placed the cameras: ", ok.error().message));
  result.settled = result.rig;
  return result;
}

Result<MarkerlessResult> triangulate_markerless(const std::vector<MarkerlessPicture>& pictures,
                                                const Rig& known, const MarkerlessOptions& options) {
  if (Result<void> sound = check_pictures(pictures); !sound) return forward(sound);
  MarkerlessResult result;
  for (const MarkerlessPicture& p : pictures) {
    const int index = camera_index(known, p.serial);
    if (index < 0) return fail(ErrorCode::NotFound, text("the known rig has no camera '", p.serial, "'"));
    RigCamera camera = known.cameras[static_cast<std::size_t>(index)];
    camera.model = p.model;
    result.rig.cameras.push_back(std::move(camera));
  }
  const std::vector<SceneKeypoints> keypoints = keypoints_of(pictures, options.threads);
  // Cameras may have moved a little: points are told from mistakes by where cameras are now, not where they
  // are said to be.
  MarkerlessResult now = result;
  if (const Result<void> ok = settle(
          pictures, keypoints, options,
          "either it has moved since the known rig was made, or its pictures show too little texture", now);
      !ok)
    return forward(ok);
  now.settled = std::move(now.rig);
  now.rig = std::move(result.rig);
  return now;
}

Result<Rig> scale_to(Rig rig, const std::string& serial_a, const std::string& serial_b, double metres) {
  const int a = camera_index(rig, serial_a), b = camera_index(rig, serial_b);
  if (a < 0 || b < 0)
    return fail(ErrorCode::NotFound, text("the rig has no camera '", a < 0 ? serial_a : serial_b, "'"));
  const double apart = (rig.cameras[static_cast<std::size_t>(a)].cam_from_world.center() -
                        rig.cameras[static_cast<std::size_t>(b)].cam_from_world.center())
                           .norm();
  if (!(metres > 0) || !std::isfinite(metres) || !(apart > 0))
    return fail(ErrorCode::InvalidArgument,
                text("cameras '", serial_a, "' and '", serial_b, "' cannot be ", metres, " m apart"));
  for (RigCamera& camera : rig.cameras) camera.cam_from_world.translation *= metres / apart;
  return rig;
}

}  // namespace floatstage::calib
