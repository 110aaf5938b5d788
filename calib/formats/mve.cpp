// Scenes of MVE, the Multi-View Environment: a folder views/ with a folder *.mve a view, which holds meta.ini
// and pictures by their use. Camera and world are as ours (x right, y down, z forward; R X + t); focal
// lengths are in shares of the picture's larger side, and pixels count from the corner, where MVE looks
// through x + 0.5.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/picture_size.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestImage = 1 << 20;  // px a side; more is a damaged picture
constexpr std::string_view kMeta = "meta.ini";

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
  return s;
}

// "camera.focal_length" → "0.9".
using Meta = std::map<std::string, std::string>;

Result<Meta> meta_of(std::string_view content, const std::string& name) {
  if (!content.empty() && content.back() != '\n')
    return fail(ErrorCode::BadData, text(name, ": ends within a line: the file is cut off"));
  Meta meta;
  std::string section;
  TextLines lines(content, name);
  while (const std::optional<TextLine> line = lines.next_filled('#')) {
    const std::string_view whole = trimmed(line->whole);
    if (whole.front() == '[' && whole.back() == ']') {
      section = trimmed(whole.substr(1, whole.size() - 2));
      continue;
    }
    const std::size_t equals = whole.find('=');
    if (equals == std::string_view::npos || section.empty())
      return lines.bad("is neither a [section] nor a 'key = value' in one");
    meta[text(section, '.', trimmed(whole.substr(0, equals)))] = trimmed(whole.substr(equals + 1));
  }
  return meta;
}

// The numbers under `key`; absent where there is no such key.
Result<std::optional<std::vector<double>>> numbers_of(const Meta& meta, const std::string& key,
                                                      std::size_t count) {
  const auto found = meta.find(key);
  if (found == meta.end()) return std::optional<std::vector<double>>();
  const std::string& words = found->second;
  std::vector<double> values;
  for (std::size_t at = 0; (at = words.find_first_not_of(" \t", at)) != std::string::npos;) {
    const std::size_t end = std::min(words.find_first_of(" \t", at), words.size());
    const std::optional<double> value = parse_number(std::string_view(words).substr(at, end - at));
    if (!value)
      return fail(ErrorCode::BadData, text("'", words.substr(at, end - at), "' in ", key, " is no number"));
    values.push_back(*value);
    at = end;
  }
  if (values.size() != count)
    return fail(ErrorCode::BadData,
                text(key, " needs ", count, " numbers, but ", values.size(), " are there"));
  return std::optional(std::move(values));
}

// K of MVE's documentation, for a picture of this size.
Result<CameraModel> model_of(double focal, double aspect, const std::vector<double>& center,
                             const MveView& view) {
  if (!(focal > 0 && aspect > 0))
    return fail(ErrorCode::BadData, "camera.focal_length and camera.pixel_aspect must be above 0");
  if (view.width < 1 || view.height < 1 || view.width > kLargestImage || view.height > kLargestImage)
    return fail(ErrorCode::BadData, text(view.picture, " has no sensible size"));
  const double w = view.width, h = view.height;
  const bool tall = w / h * aspect < 1;
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = tall ? focal * h / aspect : focal * w;
  k(1, 1) = tall ? focal * h : focal * w * aspect;
  k(0, 2) = w * center[0];
  k(1, 2) = h * center[1];
  CameraModel model;
  if (Result<void> ok = set_k(model, k, PixelOrigin::ImageCorner); !ok) return forward(ok);
  model.width = view.width;
  model.height = view.height;
  return model;
}

// Nothing where MVE could not place the view, or has no picture of it.
Result<std::optional<RigCamera>> camera_of(const Meta& meta, const MveView& view) {
  Result<std::optional<std::vector<double>>> focal = numbers_of(meta, "camera.focal_length", 1),
                                             aspect = numbers_of(meta, "camera.pixel_aspect", 1),
                                             center = numbers_of(meta, "camera.principal_point", 2),
                                             rotation = numbers_of(meta, "camera.rotation", 9),
                                             translation = numbers_of(meta, "camera.translation", 3),
                                             lens = numbers_of(meta, "camera.radial_distortion", 2);
  for (const auto* read : {&focal, &aspect, &center, &rotation, &translation, &lens})
    if (!*read) return forward(*read);
  if (!meta.contains("view.name"))
    return fail(ErrorCode::BadData, "has no name in its [view]: the file is cut off, or add one");
  if (!*focal || (**focal)[0] == 0 || view.picture.empty()) return std::optional<RigCamera>();
  if (!*rotation || !*translation)
    return fail(ErrorCode::BadData, "has a focal length, but no rotation and translation in its [camera]");
  RigCamera camera;
  const Result<CameraModel> model = model_of((**focal)[0], *aspect ? (**aspect)[0] : 1,
                                             *center ? **center : std::vector<double>{0.5, 0.5}, view);
  if (!model) return forward(model);
  camera.model = *model;
  if (!view.straight && !*lens)
    return fail(
        ErrorCode::BadData,
        text("there is only ", view.picture,
             ", and the lens that it was taken with is not in [camera]; let MVE make undistorted pictures, "
             "or add 'radial_distortion = k2 k4' (0 0 for none)"));
  if (!view.straight && ((**lens)[0] != 0 || (**lens)[1] != 0))
    camera.model.lens = BrownConrady{.k1 = (**lens)[0], .k2 = (**lens)[1]};
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = (**rotation)[static_cast<std::size_t>(i)];
  const Result<Eigen::Quaterniond> turn = rotation_from_matrix(matrix);
  if (!turn) return fail(turn.error().code, text("camera.rotation: ", turn.error().message));
  camera.cam_from_world = {*turn, {(**translation)[0], (**translation)[1], (**translation)[2]}};
  return std::optional(camera);
}

// Serials are the views' names, which mostly are their photographs'; where two are alike, the folders'.
void name_cameras(ForeignRig& foreign, const std::vector<std::string>& names) {
  const bool differ = std::set<std::string>(names.begin(), names.end()).size() == names.size() &&
                      std::find(names.begin(), names.end(), "") == names.end();
  for (std::size_t i = 0; i < names.size(); ++i)
    foreign.rig.cameras[i].serial =
        differ ? names[i] : serial_from_name(fs::path(foreign.image_names[i]).parent_path().stem().string());
}

// The folder with the views: the scene's views/, or the folder itself.
fs::path views_of(const fs::path& scene) {
  std::error_code error;
  return fs::is_directory(scene / "views", error) ? scene / "views" : scene;
}

std::vector<fs::path> views_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".mve") found.push_back(it->path());
  std::sort(found.begin(), found.end());
  return found;
}

// The undistorted picture, or else the original.
Result<void> find_picture(const fs::path& folder, MveView& view) {
  std::error_code error;
  for (const char* use : {"undistorted", "original"})
    for (const char* extension : {".png", ".jpg", ".jpeg"}) {
      const fs::path picture = folder / text(use, extension);
      if (!fs::is_regular_file(picture, error)) continue;
      const Result<PictureSizePx> size = size_of_picture(picture);
      if (!size) return forward(size);
      view.picture = picture.filename().string();
      view.straight = std::string_view(use) == "undistorted";
      view.width = size->width;
      view.height = size->height;
      return {};
    }
  for (const char* deep : {"undistorted.mvei", "original.mvei"})
    if (fs::is_regular_file(folder / deep, error))
      return fail(ErrorCode::Unsupported,
                  text((folder / deep).string(),
                       ": is what MVE keeps pictures of more than 8 bits in; save it as "
                       "PNG or JPEG beside it, with the same name"));
  return {};
}

}  // namespace

bool is_mve(const fs::path& scene) { return !views_in(views_of(scene)).empty(); }

Result<ForeignRig> parse_mve(const std::vector<MveView>& views, std::string_view name) {
  ForeignRig foreign;
  foreign.one_picture_each = true;
  std::vector<std::string> names;
  for (const MveView& view : views) {
    const std::string file = text(name, "/", view.folder, "/", kMeta);
    const Result<Meta> meta = meta_of(view.meta, file);
    if (!meta) return forward(meta);
    const Result<std::optional<RigCamera>> camera = camera_of(*meta, view);
    if (!camera) return fail(camera.error().code, text(file, ": ", camera.error().message));
    if (!*camera) continue;
    foreign.rig.cameras.push_back(**camera);
    foreign.image_names.push_back(text(view.folder, "/", view.picture));
    names.push_back(serial_from_name(meta->at("view.name")));
  }
  name_cameras(foreign, names);
  if (foreign.rig.cameras.empty() && !views.empty())
    return fail(ErrorCode::BadData, text(name, ": none of its ", views.size(),
                                         " views has a camera and a picture; let MVE place them (sfmrecon), "
                                         "or import them by another format"));
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_mve(const fs::path& scene) {
  const fs::path folder = views_of(scene);
  const std::vector<fs::path> found = views_in(folder);
  std::error_code error;
  if (found.empty())
    return fail(ErrorCode::NotFound,
                text(scene.string(), ": there is no view (a folder views/*.mve) in this scene"));
  std::vector<MveView> views;
  for (const fs::path& path : found) {
    if (fs::is_regular_file(path, error))
      return fail(
          ErrorCode::Unsupported,
          text(path.string(),
               ": is a view of MVE's first format, a file; MVE's sceneupgrade makes folders of such"));
    const Result<std::string> meta = read_file(path / kMeta);
    if (!meta) return forward(meta);
    MveView view{.folder = path.filename().string(), .meta = *meta, .picture = {}};
    if (Result<void> ok = find_picture(path, view); !ok) return forward(ok);
    views.push_back(std::move(view));
  }
  Result<ForeignRig> foreign = parse_mve(views, folder.string());
  if (foreign) foreign->pictures = folder;
  return foreign;
}

}  // namespace floatstage::calib
