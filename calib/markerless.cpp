#include "calib/markerless.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/colmap_model.h"
#include "calib/colmap_steps.h"
#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

struct Model {
  ForeignRig rig;
  ColmapPoints points;
  std::vector<ColmapImage> images;
};

Result<Model> read_model(const fs::path& folder) {
  Result<ForeignRig> rig = read_colmap(folder);
  if (!rig) return forward(rig);
  const Result<std::string> points_bytes = read_file(folder / "points3D.txt"), images_bytes = read_file(folder / "images.txt");
  if (!points_bytes) return forward(points_bytes);
  if (!images_bytes) return forward(images_bytes);
  Result<ColmapPoints> points = parse_colmap_points(*points_bytes, (folder / "points3D.txt").string());
  if (!points) return forward(points);
  Result<std::vector<ColmapImage>> images = parse_colmap_keypoints(*images_bytes, (folder / "images.txt").string());
  if (!images) return forward(images);
  return Model{*std::move(rig), *std::move(points), *std::move(images)};
}

Result<Model> largest_model(const Colmap& colmap, const fs::path& workspace) {
  std::optional<Model> best;
  std::error_code error;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(workspace / "sparse", error)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    const fs::path written = workspace / "model" / folder.filename();
    if (Result<void> ok = colmap.to_text(folder, written); !ok) return forward(ok);
    Result<Model> model = read_model(written);
    if (!model) return model;
    if (!best || best->rig.rig.cameras.size() < model->rig.rig.cameras.size()) best = *std::move(model);
  }
  if (!best) return fail(ErrorCode::BadData, text("COLMAP found no model: ", kWeakScene));
  return *std::move(best);
}

// Which image of the model each picture is; its id, or -1.
std::vector<int> image_ids(const std::vector<MarkerlessPicture>& pictures, const Model& model) {
  std::vector<int> ids;
  for (const MarkerlessPicture& p : pictures) {
    const auto found = std::find_if(model.images.begin(), model.images.end(), [&](const ColmapImage& i) { return i.name == image_name(p); });
    ids.push_back(found == model.images.end() ? -1 : found->id);
  }
  return ids;
}

Result<void> add_features(const std::vector<MarkerlessPicture>& pictures, const Model& model, MarkerlessResult& result) {
  const std::vector<int> ids = image_ids(pictures, model);
  std::map<int, std::pair<int, const ColmapImage*>> of_id;
  for (const ColmapImage& image : model.images) {
    const auto picture = std::find(ids.begin(), ids.end(), image.id);
    if (picture != ids.end()) of_id[image.id] = {static_cast<int>(picture - ids.begin()), &image};
  }
  for (const ColmapPoint& point : model.points.points) {
    SceneFeature feature{.position = point.position, .seen = {}};
    for (const auto& [image, index] : point.track) {
      const auto found = of_id.find(image);
      if (found == of_id.end() || static_cast<std::size_t>(index) >= found->second.second->keypoints.size())
        return fail(ErrorCode::BadData, text("COLMAP's points name keypoint ", index, " of image ", image, ", which its images do not have"));
      feature.seen.emplace_back(found->second.first, found->second.second->keypoints[static_cast<std::size_t>(index)]);
    }
    result.features.push_back(std::move(feature));
  }
  result.mean_track = model.points.mean_track;
  result.rms_px = model.points.mean_error;
  return {};
}

// Points a picture.
std::vector<int> points_of(const std::vector<MarkerlessPicture>& pictures, const MarkerlessResult& result) {
  std::vector<int> counts(pictures.size());
  for (const SceneFeature& f : result.features)
    for (const auto& [picture, pixel] : f.seen) ++counts[static_cast<std::size_t>(picture)];
  return counts;
}

// A reprojection error would look fine all the same.
Result<void> check_ties(const std::vector<MarkerlessPicture>& pictures, const MarkerlessResult& result, const MarkerlessOptions& options, const char* advice) {
  if (result.mean_track < options.least_track)
    return fail(ErrorCode::BadData, text("a point is seen by ", std::round(10 * result.mean_track) / 10, " cameras on average, and by ", options.least_track,
                                         " at least it should be: poses could be off although the reprojection error is ",
                                         std::round(100 * result.rms_px) / 100, " px; ", advice));
  const std::vector<int> counts = points_of(pictures, result);
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i] < options.least_points)
      return fail(ErrorCode::BadData, text("camera '", pictures[i].serial, "' shows only ", counts[i], " points, and ", options.least_points,
                                           " are needed: ", advice));
  return {};
}

}  // namespace

Result<MarkerlessResult> calibrate_markerless(const std::vector<MarkerlessPicture>& pictures, const fs::path& workspace,
                                              const MarkerlessOptions& options) {
  const Colmap colmap(options, workspace);
  if (const Result<void> ready = colmap.prepare(pictures); !ready) return forward(ready);
  if (const Result<void> ok = colmap.match(pictures); !ok) return forward(ok);
  // One thread, and intrinsics as they were given: the same pictures give the same rig.
  if (const Result<void> ok = colmap.run("mapper", {"--database_path", colmap.path("database.db"), "--image_path", colmap.path("images"), "--output_path",
                                                   colmap.path("sparse"), "--Mapper.ba_refine_focal_length", "0", "--Mapper.ba_refine_principal_point",
                                                   "0", "--Mapper.ba_refine_extra_params", "0", "--Mapper.num_threads", "1", "--Mapper.filter_max_reproj_error", "2"},
                                         kWeakScene);
      !ok)
    return forward(ok);
  const Result<Model> model = largest_model(colmap, workspace);
  if (!model) return forward(model);

  MarkerlessResult result;
  std::string missing;
  for (const MarkerlessPicture& p : pictures) {
    const std::vector<std::string>& names = model->rig.image_names;
    const auto found = std::find(names.begin(), names.end(), image_name(p));
    if (found == names.end()) {
      missing += (missing.empty() ? "'" : ", '") + p.serial + "'";
      continue;
    }
    RigCamera camera = model->rig.rig.cameras[static_cast<std::size_t>(found - names.begin())];
    camera.serial = p.serial;
    camera.model = p.model;
    result.rig.cameras.push_back(std::move(camera));
  }
  if (!missing.empty())
    return fail(ErrorCode::BadData, text("COLMAP placed ", result.rig.cameras.size(), " of ", pictures.size(), " cameras, not ", missing, ": ", kWeakScene));
  if (const Result<void> ok = add_features(pictures, *model, result); !ok) return forward(ok);
  if (const Result<void> ok = check_ties(pictures, result, options, kWeakScene); !ok) return forward(ok);
  return result;
}

Result<MarkerlessResult> triangulate_markerless(const std::vector<MarkerlessPicture>& pictures, const Rig& known, const fs::path& workspace,
                                                const MarkerlessOptions& options) {
  MarkerlessResult result;
  std::vector<std::string> names;
  for (const MarkerlessPicture& p : pictures) {
    const int index = camera_index(known, p.serial);
    if (index < 0) return fail(ErrorCode::NotFound, text("the known rig has no camera '", p.serial, "'"));
    RigCamera camera = known.cameras[static_cast<std::size_t>(index)];
    camera.model = p.model;
    result.rig.cameras.push_back(std::move(camera));
  }
  Rig numbered;
  for (const std::size_t i : database_order(pictures)) {
    numbered.cameras.push_back(result.rig.cameras[i]);
    names.push_back(image_name(pictures[i]));
  }
  const Colmap colmap(options, workspace);
  if (const Result<void> ready = colmap.prepare(pictures); !ready) return forward(ready);
  if (const Result<void> ok = colmap.match(pictures); !ok) return forward(ok);
  if (const Result<void> ok = write_colmap(numbered, names, workspace / "known"); !ok) return forward(ok);
  if (const Result<void> ok = colmap.run("point_triangulator", {"--database_path", colmap.path("database.db"), "--image_path", colmap.path("images"),
                                                               "--input_path", colmap.path("known"), "--output_path", colmap.path("sparse")},
                                         kWeakScene);
      !ok)
    return forward(ok);
  if (const Result<void> ok = colmap.to_text(colmap.path("sparse"), workspace / "model"); !ok) return forward(ok);
  const Result<Model> model = read_model(workspace / "model");
  if (!model) return forward(model);
  if (const Result<void> ok = add_features(pictures, *model, result); !ok) return forward(ok);
  if (const Result<void> ok = check_ties(pictures, result, options, "either it has moved since the known rig was made, or its pictures show too little texture"); !ok)
    return forward(ok);
  return result;
}

Result<Rig> scale_to(Rig rig, const std::string& serial_a, const std::string& serial_b, double metres) {
  const int a = camera_index(rig, serial_a), b = camera_index(rig, serial_b);
  if (a < 0 || b < 0) return fail(ErrorCode::NotFound, text("the rig has no camera '", a < 0 ? serial_a : serial_b, "'"));
  const double apart = (rig.cameras[static_cast<std::size_t>(a)].cam_from_world.center() -
                        rig.cameras[static_cast<std::size_t>(b)].cam_from_world.center()).norm();
  if (!(metres > 0) || !std::isfinite(metres) || !(apart > 0))
    return fail(ErrorCode::InvalidArgument, text("cameras '", serial_a, "' and '", serial_b, "' cannot be ", metres, " m apart"));
  for (RigCamera& camera : rig.cameras) camera.cam_from_world.translation *= metres / apart;
  return rig;
}

}  // namespace floatstage
