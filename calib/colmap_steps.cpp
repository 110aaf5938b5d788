#include "calib/colmap_steps.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "calib/child_program.h"
#include "calib/formats/colmap_cameras.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

std::string number(double v) {
  std::ostringstream out;
  out.precision(17);
  out << v;
  return out.str();
}

// COLMAP's name and parameters for a camera.
std::pair<std::string, std::string> colmap_camera(const CameraModel& m) {
  const ColmapCamera camera = camera_to_colmap(m);
  std::string parameters;
  for (const double v : camera.parameters) parameters += (parameters.empty() ? "" : ",") + number(v);
  return {std::string(camera.model->name), parameters};
}

// The same of a lens that COLMAP is to find: from a start, or from what the file's EXIF says, else from a
// focal length of 1.2 widths.
std::pair<std::string, std::string> colmap_unknown(const MarkerlessPicture& p) {
  const CameraModel& m = p.model;
  const bool radial = m.lens.index() != 0;
  const std::string name = radial ? "SIMPLE_RADIAL" : "SIMPLE_PINHOLE";
  if (p.lens == Prior::Unknown) return {name, ""};
  const auto* lens = std::get_if<BrownConrady>(&m.lens);
  return {name, text(number(m.fx), ",", number(m.cx), ",", number(m.cy),
                     radial ? "," + number(lens ? lens->k1 : 0) : "")};
}

// One call for each kind of camera: COLMAP takes one set of parameters a call, for one camera or for one a
// picture.
struct Kind {
  std::string model, parameters;
  int lens = -1;  // the picture whose lens all of these have; -1: a camera a picture
  auto operator<=>(const Kind&) const = default;
};

std::map<Kind, std::vector<std::size_t>> by_kind(const std::vector<MarkerlessPicture>& pictures) {
  std::map<Kind, std::vector<std::size_t>> lists;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const MarkerlessPicture& p = pictures[i];
    const auto [model, parameters] = p.lens == Prior::Fixed ? colmap_camera(p.model) : colmap_unknown(p);
    const int lens = p.lens == Prior::Fixed ? -1 : p.same_lens_as.value_or(static_cast<int>(i));
    lists[{model, parameters, lens}].push_back(i);
  }
  return lists;
}

// A picture's keypoints as feature_importer reads them: x, y (corner origin as ours), size, angle, 128
// numbers. Nothing but their places is used: the matches are ours.
std::string feature_file(const SceneKeypoints& keypoints) {
  std::ostringstream out;
  out.precision(9);
  out << keypoints.keypoints.size() << " 128\n";
  static constexpr std::string_view kZeros = " 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0";
  for (const SceneKeypoints::Keypoint& k : keypoints.keypoints) {
    out << k.pixel.x() << ' ' << k.pixel.y() << ' ' << k.size << ' ' << k.angle;
    for (int i = 0; i < 8; ++i) out << kZeros;
    out << '\n';
  }
  return out.str();
}

}  // namespace

std::string image_name(const MarkerlessPicture& p) { return p.serial + p.file.extension().string(); }

Result<void> Colmap::run(const std::string& step, std::vector<std::string> arguments,
                         const std::string& advice) const {
  std::vector<std::string> all = {options_.program, step};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const Result<ProgramEnd> end = run_program(all, log_, options_.timeout, options_.cancelled);
  if (!end && end.error().code == ErrorCode::NotFound)
    return fail(
        ErrorCode::NotFound,
        text(end.error().message, "; markerless calibration needs COLMAP: install the package 'colmap'"));
  if (!end) return forward(end);
  if (end->signal != 0 || end->code != 0)
    return fail(ErrorCode::BadData, text("COLMAP's ", step,
                                         end->signal != 0 ? text(" was ended by signal ", end->signal)
                                                          : text(" ended with code ", end->code),
                                         ": ", advice, " (", end_of_log(log_, 1), ")"));
  return {};
}

Result<void> check_pictures(const std::vector<MarkerlessPicture>& pictures) {
  if (pictures.size() < 2)
    return fail(ErrorCode::InvalidArgument, "markerless calibration needs pictures of two cameras or more");
  std::set<std::string> serials;
  for (const MarkerlessPicture& p : pictures) {
    if (!is_usable_serial(p.serial) || !serials.insert(p.serial).second)
      return fail(ErrorCode::InvalidArgument,
                  text("the serial '", p.serial, "' is there twice or cannot be a file name"));
    if (const Result<void> sound = check(p.model); !sound)
      return fail(ErrorCode::InvalidArgument, text("camera '", p.serial, "': ", sound.error().message));
    if (p.pixels.width != p.model.width || p.pixels.height != p.model.height)
      return fail(ErrorCode::InvalidArgument,
                  text(p.file.string(), ": has ", p.pixels.width, "x", p.pixels.height,
                       " pixels, and camera '", p.serial, "' ", p.model.width, "x", p.model.height));
    if (p.lens == Prior::Fixed) continue;
    if (std::holds_alternative<KannalaBrandt>(p.model.lens))
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", p.serial,
                       "': the scene alone does not tell a fisheye's lens; calibrate it with a board"));
    if (!p.same_lens_as) continue;
    const int of = *p.same_lens_as;
    const auto here = &p - pictures.data();
    if (of < 0 || of >= here || pictures[static_cast<std::size_t>(of)].same_lens_as ||
        pictures[static_cast<std::size_t>(of)].lens != p.lens)
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", p.serial, "' shares no lens of an earlier picture"));
    const CameraModel& owner = pictures[static_cast<std::size_t>(of)].model;
    if (owner.width != p.model.width || owner.height != p.model.height)
      return fail(ErrorCode::InvalidArgument,
                  text("cameras '", pictures[static_cast<std::size_t>(of)].serial, "' and '", p.serial,
                       "' cannot share a lens: their pictures are ", owner.width, "x", owner.height, " and ",
                       p.model.width, "x", p.model.height, "; give each its own"));
  }
  return {};
}

Result<void> Colmap::check_workspace(const std::vector<MarkerlessPicture>& pictures) const {
  const fs::path& workspace = workspace_;
  if (Result<void> sound = check_pictures(pictures); !sound) return sound;
  std::error_code error;
  if (fs::exists(workspace, error) && !fs::is_empty(workspace, error))
    return fail(ErrorCode::AlreadyExists,
                text(workspace.string(), ": holds something already; name a new folder"));
  for (const MarkerlessPicture& p : pictures) {
    if (p.model.skew != 0)
      return fail(ErrorCode::Unsupported, text("camera '", p.serial, "': COLMAP has no skew"));
    if (!fs::is_regular_file(p.file, error))
      return fail(ErrorCode::NotFound, text(p.file.string(), ": there is no such picture"));
  }
  return {};
}

Result<void> Colmap::prepare(const std::vector<MarkerlessPicture>& pictures) const {
  if (Result<void> ok = check_workspace(pictures); !ok) return ok;
  const fs::path& workspace = workspace_;
  std::error_code error;
  for (const char* name : {"images", "features", "sparse", "model"})
    if (Result<void> made = make_folder(workspace / name); !made) return made;
  for (const MarkerlessPicture& p : pictures) {
    fs::copy_file(p.file, workspace / "images" / image_name(p), error);
    if (error)
      return fail(ErrorCode::Io,
                  text(p.file.string(), ": cannot be copied to ", workspace.string(), ": ", error.message()));
  }
  return {};
}

Result<void> Colmap::import(const std::vector<MarkerlessPicture>& pictures,
                            const std::vector<SceneKeypoints>& keypoints,
                            const std::vector<SceneMatches>& matches) const {
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (Result<void> ok = write_file(workspace_ / "features" / (image_name(pictures[i]) + ".txt"),
                                     feature_file(keypoints[i]));
        !ok)
      return ok;
  for (const auto& [camera, indices] : by_kind(pictures)) {
    std::string names;
    for (const std::size_t i : indices) names += image_name(pictures[i]) + "\n";
    if (Result<void> ok = write_file(workspace_ / "list.txt", names); !ok) return ok;
    std::vector<std::string> arguments = {
        "--database_path",
        path("database.db"),
        "--image_path",
        path("images"),
        "--import_path",
        path("features"),
        "--image_list_path",
        path("list.txt"),
        "--ImageReader.camera_model",
        camera.model,
        camera.lens < 0 ? "--ImageReader.single_camera_per_image" : "--ImageReader.single_camera",
        "1"};
    if (!camera.parameters.empty())
      arguments.insert(arguments.end(), {"--ImageReader.camera_params", camera.parameters});
    if (Result<void> ok = run("feature_importer", std::move(arguments), "are the pictures whole?"); !ok)
      return ok;
  }
  std::string pairs;
  for (const SceneMatches& pair : matches) {
    if (pair.matches.empty()) continue;
    pairs += image_name(pictures[static_cast<std::size_t>(pair.a)]) + " " +
             image_name(pictures[static_cast<std::size_t>(pair.b)]) + "\n";
    for (const SceneMatches::Match& m : pair.matches) pairs += text(m.i, " ", m.k, "\n");
    pairs += "\n";
  }
  if (Result<void> ok = write_file(workspace_ / "matches.txt", pairs); !ok) return ok;
  // use_gpu must be 0 where there is no display.
  return run("matches_importer",
             {"--database_path", path("database.db"), "--match_list_path", path("matches.txt"),
              "--match_type", "raw", "--SiftMatching.use_gpu", "0", "--SiftMatching.num_threads",
              text(options_.threads > 0 ? options_.threads : default_threads())},
             kWeakScene);
}

Result<void> Colmap::map(const std::vector<MarkerlessPicture>& pictures) const {
  const bool free = std::any_of(pictures.begin(), pictures.end(),
                                [](const MarkerlessPicture& p) { return p.lens != Prior::Fixed; });
  // The principal point comes later, when the rest is nearly right.
  return run("mapper",
             {"--database_path", path("database.db"), "--image_path", path("images"), "--output_path",
              path("sparse"), "--Mapper.ba_refine_focal_length", free ? "1" : "0",
              "--Mapper.ba_refine_principal_point", "0", "--Mapper.ba_refine_extra_params", free ? "1" : "0",
              "--Mapper.num_threads", "1", "--Mapper.filter_max_reproj_error", free ? "4" : "2"},
             kWeakScene);
}

Result<void> Colmap::to_text(const fs::path& model, const fs::path& written) const {
  if (Result<void> made = make_folder(written); !made) return made;
  return run("model_converter",
             {"--input_path", model.string(), "--output_path", written.string(), "--output_type", "TXT"},
             "is the disk full?");
}

}  // namespace floatstage::calib
