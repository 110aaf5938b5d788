#include "calib/markerless.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/colmap_steps.h"
#include "calib/formats/format_files.h"
#include "calib/scene_matching.h"
#include "calib/scene_settling.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

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

bool is_cancelled(const MarkerlessOptions& options) { return options.cancelled && options.cancelled(); }

Result<std::vector<SceneKeypoints>> keypoints_of(const std::vector<MarkerlessPicture>& pictures,
                                                 const MarkerlessOptions& options) {
  std::vector<SceneKeypoints> out(pictures.size());
  parallel_for(pictures.size(), options.threads, [&](std::size_t i) {
    if (!is_cancelled(options)) out[i] = find_keypoints(pictures[i].pixels, options.contrast);
  });
  if (is_cancelled(options)) return fail(ErrorCode::Cancelled, "looking for keypoints was interrupted");
  return out;
}

// Where COLMAP puts the cameras, with the lenses that they begin from.
Result<Rig> placed(const Colmap& colmap, const std::vector<MarkerlessPicture>& pictures,
                   const std::vector<SceneKeypoints>& keypoints, const std::vector<SceneMatches>& matches) {
  if (const Result<void> ready = colmap.prepare(pictures); !ready) return forward(ready);
  if (const Result<void> ok = colmap.import(pictures, keypoints, matches); !ok) return forward(ok);
  if (const Result<void> ok = colmap.map(pictures); !ok) return forward(ok);
  const Result<ForeignRig> model = largest_model(colmap, colmap.workspace());
  if (!model) return forward(model);
  Rig rig;
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
    if (p.lens == Prior::Fixed)
      camera.model = p.model;
    else if (p.same_lens_as)
      camera.model = rig.cameras[static_cast<std::size_t>(*p.same_lens_as)].model;
    else if (p.model.lens.index() != 0 && camera.model.lens.index() == 0)
      camera.model.lens = BrownConrady{};
    rig.cameras.push_back(std::move(camera));
  }
  if (!missing.empty())
    return fail(ErrorCode::BadData, text("COLMAP placed ", rig.cameras.size(), " of ", pictures.size(),
                                         " cameras, not ", missing, ": ", kWeakScene));
  return rig;
}

Result<MarkerlessResult> placed_and_settled(const Colmap& colmap,
                                            const std::vector<MarkerlessPicture>& pictures,
                                            const std::vector<SceneKeypoints>& keypoints,
                                            const std::vector<SceneMatches>& matches,
                                            const MarkerlessOptions& options) {
  Result<Rig> rig = placed(colmap, pictures, keypoints, matches);
  if (!rig) return forward(rig);
  MarkerlessResult result;
  result.rig = *std::move(rig);
  if (const Result<void> ok = settle(pictures, keypoints, options, kWeakScene, result); !ok) {
    if (ok.error().code == ErrorCode::Cancelled) return forward(ok);
    return fail(ok.error().code, text("where COLMAP placed the cameras: ", ok.error().message));
  }
  result.settled = result.rig;
  return result;
}

// The same pictures with the given lenses as a start, equal ones shared.
std::vector<MarkerlessPicture> with_free_lenses(std::vector<MarkerlessPicture> pictures) {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].lens != Prior::Fixed) continue;
    pictures[i].lens = Prior::Unknown;
    for (std::size_t k = 0; k < i && !pictures[i].same_lens_as; ++k)
      if (!pictures[k].same_lens_as && pictures[k].model == pictures[i].model)
        pictures[i].same_lens_as = static_cast<int>(k);
  }
  return pictures;
}

// Cameras could not be placed with the lenses that were given: whether they can without them, and what lenses
// those are. Empty when that is not so.
std::string blame_of_lenses(const std::vector<MarkerlessPicture>& pictures, const fs::path& workspace,
                            const std::vector<SceneKeypoints>& keypoints,
                            const std::vector<SceneMatches>& matches, const MarkerlessOptions& options) {
  if (std::none_of(pictures.begin(), pictures.end(),
                   [](const MarkerlessPicture& p) { return p.lens == Prior::Fixed; }))
    return {};
  const Colmap colmap(options, workspace / "without-lenses");
  const Result<MarkerlessResult> without =
      placed_and_settled(colmap, with_free_lenses(pictures), keypoints, matches, options);
  if (!without) return {};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const SuspectLens s{i, pictures[i].model.fx, without->rig.cameras[i].model.fx, 0};
    if (pictures[i].lens == Prior::Fixed && std::abs(s.share()) > options.largest_focal_error)
      return "; without the lenses that were given they can be placed, so " + describe(s, pictures);
  }
  return {};
}

}  // namespace

double contrast_for(std::span<const Image> pictures, int threads) {
  constexpr double kEnough = 700, kBare = kUsualContrast / 4;
  if (pictures.empty()) return kUsualContrast;
  std::vector<double> counts(pictures.size());
  parallel_for(pictures.size(), threads, [&](std::size_t i) {
    counts[i] = static_cast<double>(find_keypoints(pictures[i], kUsualContrast).keypoints.size());
  });
  return median(std::move(counts)) < kEnough ? kBare : kUsualContrast;
}

Result<MarkerlessResult> calibrate_markerless(const std::vector<MarkerlessPicture>& pictures,
                                              const fs::path& workspace, const MarkerlessOptions& options) {
  const Colmap colmap(options, workspace);
  if (const Result<void> ok = colmap.check_workspace(pictures); !ok) return forward(ok);
  const Result<std::vector<SceneKeypoints>> keypoints = keypoints_of(pictures, options);
  if (!keypoints) return forward(keypoints);
  const std::vector<SceneMatches> matches = match_pictures(*keypoints, options.threads);
  if (is_cancelled(options)) return fail(ErrorCode::Cancelled, "matching the pictures was interrupted");
  Result<MarkerlessResult> result = placed_and_settled(colmap, pictures, *keypoints, matches, options);
  if (!result && result.error().code == ErrorCode::BadData)
    return fail(result.error().code,
                result.error().message + blame_of_lenses(pictures, workspace, *keypoints, matches, options));
  if (!result) return result;
  const Result<std::vector<SuspectLens>> suspects =
      suspect_lenses(pictures, *result, options.largest_focal_error, options.threads);
  if (suspects && !suspects->empty()) return fail(ErrorCode::BadData, describe(suspects->front(), pictures));
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
  const Result<std::vector<SceneKeypoints>> keypoints = keypoints_of(pictures, options);
  if (!keypoints) return forward(keypoints);
  // Cameras may have moved a little: points are told from mistakes by where cameras are now, not where they
  // are said to be.
  MarkerlessResult now = result;
  if (const Result<void> ok = settle(
          pictures, *keypoints, options,
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
