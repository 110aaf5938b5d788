// Light fields of which every picture's name says where it was taken: NAME_<row>_<column>_<y mm>_<x
// mm>_<focal length mm>_<sensor width mm>.jpg, parallel cameras in a plane, as Blender scripts write them.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/picture_size.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFields = 6;
constexpr double kMetres = 1e-3;  // a millimetre

std::optional<double> number(std::string_view word) {
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || stop != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

// The six numbers at a name's end; absent when they are not there.
std::optional<std::array<double, kFields>> fields_of(const std::string& file_name) {
  const std::size_t dot = file_name.find_last_of('.');
  if (dot == std::string::npos) return std::nullopt;
  std::string_view rest = std::string_view(file_name).substr(0, dot);
  std::array<double, kFields> fields{};
  for (std::size_t i = kFields; i-- > 0;) {
    const std::size_t bar = rest.find_last_of('_');
    if (bar == std::string_view::npos || bar == 0) return std::nullopt;
    const std::optional<double> value = number(rest.substr(bar + 1));
    if (!value) return std::nullopt;
    fields[i] = *value;
    rest = rest.substr(0, bar);
  }
  return fields;
}

bool is_picture(const std::string& name) {
  return name.ends_with(".jpg") || name.ends_with(".jpeg") || name.ends_with(".png");
}

std::vector<std::string> pictures_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (is_picture(name) && fields_of(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path folder_of(const fs::path& path) { return pictures_in(path).empty() ? path / "views" : path; }

}  // namespace

bool names_a_lightfield(const fs::path& path) { return !pictures_in(folder_of(path)).empty(); }

Result<ForeignRig> parse_lightfield(const std::vector<std::string>& names, int width, int height,
                                    std::string_view name_for_errors) {
  ForeignRig foreign;
  for (const std::string& name : names) {
    const std::optional<std::array<double, kFields>> fields = fields_of(name);
    if (!fields)
      return fail(ErrorCode::BadData, text(name_for_errors, ": '", name,
                                           "' does not end in row, column, y, x, focal length, width"));
    const auto [row, column, y, x, focal, sensor] = *fields;
    if (!(focal > 0) || !(sensor > 0) || row < 0 || column < 0 || row > 9999 || column > 9999)
      return fail(ErrorCode::BadData, text(name_for_errors, ": '", name, "' states a focal length of ", focal,
                                           " mm and a sensor of ", sensor, " mm at row ", row, ", column ",
                                           column, "; none can be"));
    RigCamera camera;
    camera.serial = serial_from_name(name.substr(0, name.find_last_of('.')));
    camera.model.width = width;
    camera.model.height = height;
    camera.model.fx = camera.model.fy = focal / sensor * width;
    camera.model.cx = 0.5 * width;
    camera.model.cy = 0.5 * height;
    // The x of the names grows to the right, their y downwards; ours is a wall that looks along +y.
    const Eigen::Vector3d eye(x * kMetres, 0, -y * kMetres);
    camera.cam_from_world = look_at(eye, eye + Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
    foreign.rig.cameras.push_back(camera);
    foreign.image_names.push_back(name);
  }
  return checked(std::move(foreign), name_for_errors);
}

Result<ForeignRig> read_lightfield(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error))
    return fail(ErrorCode::NotFound, text(path.string(), ": there is no such folder"));
  const fs::path folder = folder_of(path);
  const std::vector<std::string> names = pictures_in(folder);
  if (names.empty())
    return fail(ErrorCode::NotFound, text(path.string(),
                                          ": holds no picture (nor does views/ in it) named "
                                          "NAME_<row>_<column>_<y mm>_<x mm>_<focal mm>_<sensor mm>.jpg"));
  const Result<PictureSizePx> size = size_of_picture(folder / names.front());
  if (!size) return forward(size);
  Result<ForeignRig> foreign = parse_lightfield(names, size->width, size->height, path.string());
  if (foreign) foreign->pictures = folder;
  return foreign;
}

}  // namespace floatstage::calib
