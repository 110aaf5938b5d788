#include <algorithm>
#include <cmath>

#include <pugixml.hpp>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

// Lengths on the sensor are in 1/64 px, lengths in the room in millimetres.
constexpr double kUnitsPerPixel = 64;
constexpr double kMetresPerUnit = 1e-3;

// An element together with what messages need to point at it.
struct Place {
  std::string_view xml, file;
  std::string who;

  Unexpected bad(const pugi::xml_node& node, const std::string& what) const {
    const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
    const auto line =
        1 + std::count(xml.begin(), xml.begin() + static_cast<std::ptrdiff_t>(std::min(offset, xml.size())),
                       '\n');
    return fail(ErrorCode::BadData, text(file, ": line ", line, ": ", who, ": ", what));
  }
};

Result<pugi::xml_node> child(const Place& place, const pugi::xml_node& parent, const char* name) {
  const pugi::xml_node node = parent.child(name);
  if (!node) return place.bad(parent, text("<", name, "> is missing"));
  return node;
}

// `absent` is taken where the attribute is not there; without it a missing attribute is an error.
Result<double> number(const Place& place, const pugi::xml_node& node, const char* name,
                      std::optional<double> absent = std::nullopt) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (!attribute && absent) return *absent;
  if (!attribute) return place.bad(node, text(name, " is missing from <", node.name(), ">"));
  const std::optional<double> value = parse_number(attribute.value());
  if (!value)
    return place.bad(node, text(name, "=\"", std::string_view(attribute.value()).substr(0, 40),
                                "\" is not a finite number"));
  return *value;
}

// Several attributes of one element at once, in the order of `names`.
Result<std::vector<double>> attributes(const Place& place, const pugi::xml_node& node,
                                       std::initializer_list<const char*> names,
                                       std::optional<double> absent = std::nullopt) {
  std::vector<double> values;
  for (const char* name : names) {
    const Result<double> value = number(place, node, name, absent);
    if (!value) return forward(value);
    values.push_back(*value);
  }
  return values;
}

Result<CameraModel> parse_model(const Place& place, const pugi::xml_node& camera) {
  const Result<pugi::xml_node> intrinsic = child(place, camera, "intrinsic");
  if (!intrinsic) return forward(intrinsic);
  const auto k =
      attributes(place, *intrinsic, {"focalLengthU", "focalLengthV", "centerPointU", "centerPointV"});
  if (!k) return forward(k);
  const auto d = attributes(place, *intrinsic,
                            {"skew", "radialDistortion1", "radialDistortion2", "radialDistortion3",
                             "tangentalDistortion1", "tangentalDistortion2"},
                            0.0);
  if (!d) return forward(d);
  // The picture may be a part of the sensor; its borders are inclusive pixel numbers of the sensor.
  double left = 0, top = 0;
  CameraModel model;
  if (const pugi::xml_node video = camera.child("fov_video")) {
    const auto fov = attributes(place, video, {"left", "top", "right", "bottom"});
    if (!fov) return forward(fov);
    left = (*fov)[0], top = (*fov)[1];
    const double width = (*fov)[2] - left + 1, height = (*fov)[3] - top + 1;
    if (!(width >= 1 && height >= 1 && width <= 1e6 && height <= 1e6) || width != std::floor(width) ||
        height != std::floor(height))
      return place.bad(video, "<fov_video> is not a picture of whole pixels");
    model.width = static_cast<int>(width);
    model.height = static_cast<int>(height);
  }
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 0) = (*k)[0] / kUnitsPerPixel;
  matrix(1, 1) = (*k)[1] / kUnitsPerPixel;
  matrix(0, 1) = (*d)[0] / kUnitsPerPixel;
  matrix(0, 2) = (*k)[2] / kUnitsPerPixel - left;
  matrix(1, 2) = (*k)[3] / kUnitsPerPixel - top;
  if (Result<void> ok = set_k(model, matrix, PixelOrigin::FirstPixelCenter); !ok)
    return place.bad(*intrinsic, ok.error().message);
  const BrownConrady lens{(*d)[1], (*d)[2], (*d)[4], (*d)[5], (*d)[3]};
  if (lens != BrownConrady{}) model.lens = lens;
  return model;
}

Result<Rigid3> parse_pose(const Place& place, const pugi::xml_node& camera) {
  const Result<pugi::xml_node> transform = child(place, camera, "transform");
  if (!transform) return forward(transform);
  const auto v = attributes(place, *transform,
                            {"r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33", "x", "y", "z"});
  if (!v) return forward(v);
  // Its rows are the camera's axes in the room (x right, y up, z backwards); x, y, z is where the camera
  // stands.
  const Eigen::Matrix3d axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v->data());
  const Eigen::Vector3d center = Eigen::Map<const Eigen::Vector3d>(v->data() + 9) * kMetresPerUnit;
  const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(axes);
  if (!rotation) return place.bad(*transform, rotation.error().message);
  const Eigen::Quaterniond half_turn(0, 1, 0, 0);  // about x: y up, z backwards -> y down, z forward
  const Eigen::Quaterniond cam_from_world = half_turn * *rotation;
  return Rigid3{cam_from_world, cam_from_world * -center};
}

}  // namespace

Result<ForeignRig> parse_qualisys(std::string_view xml, std::string_view name) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) {
    const auto end =
        xml.begin() + std::clamp<std::ptrdiff_t>(parsed.offset, 0, static_cast<std::ptrdiff_t>(xml.size()));
    return fail(ErrorCode::BadData,
                text(name, ": line ", 1 + std::count(xml.begin(), end, '\n'), ": not well-formed XML (",
                     parsed.description(), "); the file may be cut off"));
  }
  ForeignRig foreign;
  for (const pugi::xml_node& node : document.child("calibration").child("cameras").children("camera")) {
    const std::string serial = node.attribute("serial").value();
    const Place place{xml, name, text("camera '", serial, "'")};
    if (serial.empty()) return place.bad(node, "serial is missing");
    if (std::string_view(node.attribute("active").as_string("1")) == "0") continue;
    const Result<CameraModel> model = parse_model(place, node);
    if (!model) return forward(model);
    const Result<Rigid3> pose = parse_pose(place, node);
    if (!pose) return forward(pose);
    foreign.rig.cameras.push_back({serial_from_name(serial), *model, *pose, {}});
    foreign.image_names.push_back(serial);
  }
  if (foreign.rig.cameras.empty())
    return fail(ErrorCode::BadData,
                text(name, ": no active <camera> in <calibration><cameras>; is it a Qualisys calibration?"));
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_qualisys(const std::filesystem::path& qca_txt) {
  const Result<std::string> content = read_file(qca_txt);
  if (!content) return forward(content);
  return parse_qualisys(*content, qca_txt.string());
}

}  // namespace floatstage::calib
