#include "pipeline/calibrate/scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "calib/exif_lens.h"
#include "calib/scene_features.h"
#include "core/added_search.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {
namespace {

// How well yesterday's distances between cameras hold: enough for the scale, loose enough for those that have
// moved.
constexpr double kYesterday = 0.005;

struct Scene {
  std::vector<calib::MarkerlessPicture> pictures;
  std::vector<int> camera_of;  // of the observations
};

Result<Image> load_picture(const std::filesystem::path& file, const std::string& serial) {
  Result<Image> picture = load_still(file);
  if (!picture) return fail(picture.error().code, text("camera '", serial, "': ", picture.error().message));
  return picture;
}

// What is known of a camera's lens by what its photograph's file says, or the session: a start; nothing
// otherwise.
void guess_lens(const SessionMarkerless& session, calib::MarkerlessPicture& picture) {
  CameraModel& m = picture.model;
  picture.lens = calib::Prior::Unknown;
  double focal = session.focal_px;
  if (const Result<std::string> bytes =
          focal > 0 ? Result<std::string>(std::string()) : read_file(picture.file))
    if (const calib::ExifLens lens = calib::exif_lens(*bytes); lens.focal_per_width)
      focal = *lens.focal_per_width * std::max(m.width, m.height);
  if (!(focal > 0))
    focal = std::max(m.width, m.height);  // only so that the model is sound
  else
    picture.lens = calib::Prior::Start;
  m.fx = m.fy = focal;
  m.cx = m.width / 2.0;
  m.cy = m.height / 2.0;
}

// A picture whose lens the scene itself is to tell.
Result<void> add_unknown(const SessionMarkerless& session, calib::LensKind kind,
                         calib::MarkerlessPicture picture, Scene& scene) {
  if (kind == calib::LensKind::BrownConrady) picture.model.lens = BrownConrady{};
  if (kind == calib::LensKind::KannalaBrandt) picture.model.lens = KannalaBrandt{};
  picture.model.width = picture.pixels.width;
  picture.model.height = picture.pixels.height;
  guess_lens(session, picture);
  if (session.lens == UnknownLenses::Shared)
    for (std::size_t i = 0; i < scene.pictures.size(); ++i)
      if (const calib::MarkerlessPicture& first = scene.pictures[i];
          first.lens != calib::Prior::Fixed && !first.same_lens_as) {
        picture.same_lens_as = static_cast<int>(i);
        picture.lens = first.lens;
        if (first.model.width == picture.model.width && first.model.height == picture.model.height)
          picture.model = first.model;
        break;
      }
  scene.pictures.push_back(std::move(picture));
  return {};
}

Unexpected unknown_lens(const std::string& serial) {
  return fail(
      ErrorCode::BadData,
      text("camera '", serial,
           "': its intrinsics are not known; calibrate this camera alone with a board, "
           "then give [known] file = …, intrinsics = \"fixed\"; or let the scene tell them: [markerless] "
           "lens = \"shared\" where all pictures are of one camera or of cameras alike, else \"separate\""));
}

// The pictures of a carried camera are cameras of their own.
Result<void> add_carried(const SessionMarkerless& session, const SessionCamera& camera, const Rig* known,
                         SessionObservations& out, Scene& scene) {
  const int index = known ? camera_index(*known, camera.serial) : -1;
  if (index < 0 && session.lens == UnknownLenses::Refused) return unknown_lens(camera.serial);
  const Result<std::vector<std::filesystem::path>> files = pictures_of(camera.scene, camera.serial);
  if (!files) return forward(files);
  for (std::size_t i = 0; i < files->size(); ++i) {
    Result<Image> pixels = load_picture((*files)[i], camera.serial);
    if (!pixels) return forward(pixels);
    calib::CalibrationCamera c;
    c.serial = text(camera.serial, "-", i + 1);
    c.lens = camera.lens;
    c.width = pixels->width;
    c.height = pixels->height;
    scene.camera_of.push_back(static_cast<int>(out.observations.cameras.size()));
    out.carried.push_back(c.serial);
    calib::MarkerlessPicture picture{c.serial, (*files)[i], {}, *std::move(pixels)};
    if (index < 0) {
      if (Result<void> ok = add_unknown(session, camera.lens, std::move(picture), scene); !ok) return ok;
    } else {
      c.intrinsics = calib::Prior::Fixed;
      c.model = known->cameras[static_cast<std::size_t>(index)].model;
      c.model.width = c.width;
      c.model.height = c.height;
      if (c.model.lens.index() != 0) c.lens = static_cast<calib::LensKind>(c.model.lens.index());
      picture.model = c.model;
      scene.pictures.push_back(std::move(picture));
    }
    out.observations.cameras.push_back(std::move(c));
  }
  return {};
}

// Keypoints of a time stamp or a logo lie at one place in all pictures, and are no points of the scene.
void hide_added(Scene& scene, std::vector<std::string>& remarks) {
  std::vector<std::vector<Image>> pictures;
  for (const calib::MarkerlessPicture& p : scene.pictures) pictures.push_back({p.pixels});
  const std::vector<AddedContent> added = find_added(pictures);
  std::map<std::string, AddedContent> by_serial;
  for (std::size_t i = 0; i < added.size(); ++i) {
    by_serial[scene.pictures[i].serial] = added[i];
    if (!added[i].none()) scene.pictures[i].pixels = without(added[i], std::move(scene.pictures[i].pixels));
  }
  for (const std::string& sentence : describe(by_serial))
    remarks.push_back(sentence + " were added by a camera or a converter, and are not looked at");
}

Result<Scene> gather(const Session& s, const Rig* known, SessionObservations& out) {
  Scene scene;
  for (const SessionCamera& camera : s.cameras) {
    if (camera.scene.empty() || camera.carried) continue;
    const auto& cameras = out.observations.cameras;
    const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const calib::CalibrationCamera& c) {
      return c.serial == camera.serial;
    });
    const Result<std::vector<std::filesystem::path>> files = pictures_of(camera.scene, camera.serial);
    if (!files) return forward(files);
    if (files->size() != 1)
      return fail(ErrorCode::BadData,
                  text("camera '", camera.serial, "': 'scene' has ", files->size(),
                       " pictures; give one, or say carried = true when it was carried about"));
    const bool unknown = found->intrinsics == calib::Prior::Unknown;
    if (unknown && s.markerless->lens == UnknownLenses::Refused) return unknown_lens(camera.serial);
    Result<Image> pixels = load_picture(files->front(), camera.serial);
    if (!pixels) return forward(pixels);
    calib::MarkerlessPicture picture{camera.serial, files->front(), found->model, *std::move(pixels)};
    scene.camera_of.push_back(static_cast<int>(found - cameras.begin()));
    if (!unknown)
      scene.pictures.push_back(std::move(picture));
    else if (Result<void> ok = add_unknown(*s.markerless, camera.lens, std::move(picture), scene); !ok)
      return forward(ok);
  }
  for (const SessionCamera& camera : s.cameras)
    if (camera.carried)
      if (Result<void> ok = add_carried(*s.markerless, camera, known, out, scene); !ok) return forward(ok);
  return scene;
}

// Lenses that the scene told are where the solver starts; boards tell more of a lens where they are seen.
void keep_lenses(const Scene& scene, const Rig& rig, calib::Observations& o) {
  std::set<int> seen;
  for (const calib::TargetView& v : o.views) seen.insert(v.camera);
  for (std::size_t i = 0; i < scene.pictures.size(); ++i) {
    const calib::MarkerlessPicture& picture = scene.pictures[i];
    if (picture.lens == calib::Prior::Fixed) continue;
    calib::CalibrationCamera& c = o.cameras[static_cast<std::size_t>(scene.camera_of[i])];
    c.intrinsics = calib::Prior::Start;
    c.model = rig.cameras[i].model;
    c.plain_lens = seen.empty();
    if (picture.same_lens_as && c.plain_lens)
      c.same_lens_as = scene.camera_of[static_cast<std::size_t>(*picture.same_lens_as)];
  }
}

// Cameras of the observations, as far as they are placed.
Rig placed_rig(const calib::Observations& o, const Scene& scene, const Rig& found) {
  Rig rig;
  for (std::size_t c = 0; c < o.cameras.size(); ++c) {
    const auto at = std::find(scene.camera_of.begin(), scene.camera_of.end(), static_cast<int>(c));
    if (at != scene.camera_of.end())
      rig.cameras.push_back(found.cameras[static_cast<std::size_t>(at - scene.camera_of.begin())]);
  }
  return rig;
}

Result<double> scale_of(const Session& s, const calib::Observations& o, const Scene& scene, const Rig& rig,
                        SessionObservations& out) {
  if (!s.markerless->a.empty()) {
    const Result<Rig> scaled = calib::scale_to(rig, s.markerless->a, s.markerless->b, s.markerless->distance);
    if (!scaled) return forward(scaled);
    return scaled->cameras.front().cam_from_world.translation.norm() /
           rig.cameras.front().cam_from_world.translation.norm();
  }
  if (rig.cameras.size() == o.cameras.size())
    if (const std::optional<double> metres = calib::metres_per_unit(o, placed_rig(o, scene, rig))) {
      out.remarks.push_back("the scale is that of the target in the pictures");
      return *metres;
    }
  return fail(ErrorCode::BadData,
              "nothing says how large the scene is; give [markerless] between = [\"…\", \"…\"] and distance "
              "= metres, show a target of known size to "
              "two cameras at once, or start from a known rig");
}

// Yesterday's distances hold the scale where nothing else does.
void hold_scale(const Rig& known, calib::Observations& o) {
  for (std::size_t a = 0; a < o.cameras.size(); ++a)
    for (std::size_t b = a + 1; b < o.cameras.size(); ++b) {
      const int i = camera_index(known, o.cameras[a].serial), k = camera_index(known, o.cameras[b].serial);
      if (i < 0 || k < 0) continue;
      const double metres = (known.cameras[static_cast<std::size_t>(i)].cam_from_world.center() -
                             known.cameras[static_cast<std::size_t>(k)].cam_from_world.center())
                                .norm();
      if (metres > 0)
        o.distances.push_back({static_cast<int>(a), static_cast<int>(b), metres, kYesterday * metres});
    }
}

// How well a ring that was asked for is one.
std::string ring_of(const calib::MarkerlessResult& found) {
  if (!found.off_ring) return "";
  return text("; the cameras are ", std::round(1e4 * *found.off_ring) / 100,
              " % of its radius off their ring (rms)");
}

}  // namespace

Result<void> add_scene(const Session& s, const std::filesystem::path& workspace, int threads,
                       const Progress* watch, SessionObservations& out) {
  if (!s.markerless) return {};
  std::optional<Rig> known;
  if (s.known) {
    Result<Rig> loaded = load_known(*s.known);
    if (!loaded) return forward(loaded);
    known = *std::move(loaded);
  }
  const calib::Prior poses = s.known ? s.known->poses : calib::Prior::Unknown;
  calib::Observations& o = out.observations;
  const bool boards = !o.views.empty();
  Result<Scene> scene = gather(s, known ? &*known : nullptr, out);
  if (!scene) return forward(scene);
  hide_added(*scene, out.remarks);
  const bool carried = !out.carried.empty();
  if (carried && poses == calib::Prior::Fixed)
    return fail(
        ErrorCode::BadData,
        "pictures of a carried camera have no known pose; say poses = \"start\" or \"compare\" in [known]");

  calib::MarkerlessOptions options{.timeout = s.markerless->timeout,
                                   .threads = threads,
                                   .cancelled = [watch] { return is_cancelled(watch); },
                                   .contrast = s.markerless->contrast,
                                   .least_track = s.markerless->least_track,
                                   .least_points = s.markerless->least_points,
                                   .largest_focal_error = s.markerless->largest_focal_error,
                                   .ring = s.markerless->ring};
  std::optional<calib::MarkerlessResult> found;
  bool kept = false;     // the known poses hold
  std::string not_held;  // why they do not
  if (poses != calib::Prior::Unknown && !carried) {
    options.least_track = 2;  // places are known: ties need not hold them
    Result<calib::MarkerlessResult> result = calib::triangulate_markerless(scene->pictures, *known, options);
    options.least_track = s.markerless->least_track;
    if (result) {
      found = *std::move(result);
      kept = true;
    } else if (poses == calib::Prior::Fixed || result.error().code != ErrorCode::BadData) {
      return forward(result);
    } else {
      not_held = result.error().message;
      out.remarks.push_back(
          text("the known poses do not hold: ", not_held, "; all cameras were placed anew"));
    }
  }
  if (!found) {
    Result<calib::MarkerlessResult> result = calib::calibrate_markerless(scene->pictures, workspace, options);
    if (!result && !not_held.empty())
      return fail(result.error().code,
                  text("the known poses do not hold: ", not_held,
                       "; nor can the cameras be placed anew: ", result.error().message));
    if (!result) return forward(result);
    found = *std::move(result);
  }
  Rig rig = found->settled;
  const bool from_known = poses == calib::Prior::Start;
  if (from_known) {
    const std::optional<Rig> moved = calib::onto_known(rig, *known);
    if (!moved)
      return fail(
          ErrorCode::BadData,
          text(s.known->file.string(),
               ": fewer than three of its cameras see the scene; nothing can be brought back onto it"));
    rig = *moved;
  } else if (!kept) {
    const Result<double> metres = scale_of(s, o, *scene, rig, out);
    if (!metres) return forward(metres);
    for (RigCamera& c : rig.cameras) c.cam_from_world.translation *= *metres;
  }
  for (std::size_t i = 0; i < scene->camera_of.size() && poses != calib::Prior::Fixed; ++i)
    o.cameras[static_cast<std::size_t>(scene->camera_of[i])].found = rig.cameras[i].cam_from_world;
  keep_lenses(*scene, found->rig, o);
  calib::add_features(o, found->features, scene->camera_of);
  if (!s.markerless->a.empty()) {
    const auto index = [&](const std::string& serial) {
      return static_cast<int>(
          std::find_if(o.cameras.begin(), o.cameras.end(),
                       [&](const calib::CalibrationCamera& c) { return c.serial == serial; }) -
          o.cameras.begin());
    };
    o.distances.push_back(
        {index(s.markerless->a), index(s.markerless->b), s.markerless->distance, s.markerless->sigma});
  } else if (from_known && !boards) {
    hold_scale(*known, o);
    out.remarks.push_back("the scale is that of the known rig");
  }
  std::size_t sights = 0;
  for (const calib::SceneFeature& f : found->features) sights += f.seen.size();
  out.detection.push_back(
      text("the scene: ", found->features.size(), " points, each seen by ",
           std::round(10 * static_cast<double>(sights) / static_cast<double>(found->features.size())) / 10,
           " cameras on average", ring_of(*found), kept ? "; the known poses were kept as the start" : ""));
  return {};
}

}  // namespace floatstage::pipeline
