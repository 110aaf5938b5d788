#include <cmath>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/opencv_yaml.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr auto kOrigin = PixelOrigin::FirstPixelCenter;

Eigen::Matrix3d row_major(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}

Result<Lens> read_lens(const OpenCvYaml& intri, const std::string& key) {
  if (!intri.has(key)) return Lens{};
  const Result<std::vector<double>> read = intri.vector(key);
  if (!read) return forward(read);
  std::vector<double> d = *read;
  if (d.size() != 4 && d.size() != 5 && d.size() != 8 && d.size() != 12 && d.size() != 14)
    return intri.bad(key, text("has ", d.size(), " coefficients; OpenCV has 4, 5, 8, 12 or 14"));
  constexpr std::size_t kRational = 8;  // k1 k2 p1 p2 k3 k4 k5 k6; prisms and tilt come behind
  for (std::size_t i = kRational; i < d.size(); ++i)
    if (d[i] != 0)
      return fail(ErrorCode::Unsupported,
                  intri
                      .bad(key,
                           "has prism or tilt terms (after k6), which Floatstage does not have; calibrate "
                           "again with eight coefficients (CALIB_RATIONAL_MODEL) or five")
                      .error_value.message);
  d.resize(kRational);
  const BrownConrady lens{d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
  return lens == BrownConrady{} ? Lens{} : Lens(lens);
}

Result<CameraModel> read_model(const OpenCvYaml& intri, const std::string& camera) {
  CameraModel model;
  const std::string key = "K_" + camera;
  const Result<std::vector<double>> k = intri.matrix(key, 3, 3);
  if (!k) return forward(k);
  if (Result<void> ok = set_k(model, row_major(*k), kOrigin); !ok)
    return intri.bad(key, text("is wrong: ", ok.error().message));
  const Result<Lens> lens = read_lens(intri, "dist_" + camera);
  if (!lens) return forward(lens);
  model.lens = *lens;
  if (!intri.has("W_" + camera) && !intri.has("H_" + camera)) return model;
  const Result<double> width = intri.number("W_" + camera), height = intri.number("H_" + camera);
  if (!width) return forward(width);
  if (!height) return forward(height);
  if (!(*width >= 1 && *width <= 1e6 && *height >= 1 && *height <= 1e6))
    return intri.bad("W_" + camera, "and H_ are not a picture's size");
  model.width = static_cast<int>(*width);
  model.height = static_cast<int>(*height);
  return model;
}

Result<Eigen::Quaterniond> read_rotation(const OpenCvYaml& extri, const std::string& camera) {
  const std::string matrix_key = "Rot_" + camera, vector_key = "R_" + camera;
  if (extri.has(matrix_key)) {
    const Result<std::vector<double>> m = extri.matrix(matrix_key, 3, 3);
    if (!m) return forward(m);
    const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(row_major(*m));
    if (!rotation) return extri.bad(matrix_key, text("is wrong: ", rotation.error().message));
    return rotation;
  }
  const Result<std::vector<double>> v = extri.matrix(vector_key, 3, 1);
  if (!v) return forward(v);
  const Eigen::Vector3d axis((*v)[0], (*v)[1], (*v)[2]);
  const double angle = axis.norm();
  if (!std::isfinite(angle)) return extri.bad(vector_key, "is not a rotation vector");
  return angle == 0 ? Eigen::Quaterniond::Identity()
                    : Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis / angle));
}

std::string yaml_matrix(const std::string& key, int rows, int cols, const std::vector<double>& values) {
  std::string out =
      text(key, ": !!opencv-matrix\n   rows: ", rows, "\n   cols: ", cols, "\n   dt: d\n   data: [ ");
  for (std::size_t i = 0; i < values.size(); ++i) {
    // As OpenCV writes it: the point keeps readers from taking "1" for an integer.
    std::string number = to_text(values[i]);
    if (number.find_first_of(".e") == std::string::npos) number += '.';
    out += (i == 0 ? "" : ", ") + number;
  }
  return out + " ]\n";
}

std::vector<double> by_rows(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

}  // namespace

Result<ForeignRig> parse_easymocap(std::string_view intri_text, std::string_view extri_text,
                                   std::string_view intri_name, std::string_view extri_name) {
  const Result<OpenCvYaml> intri = OpenCvYaml::parse(intri_text, intri_name);
  if (!intri) return forward(intri);
  const Result<OpenCvYaml> extri = OpenCvYaml::parse(extri_text, extri_name);
  if (!extri) return forward(extri);
  const Result<std::vector<std::string>> names = intri->list("names");
  if (!names) return forward(names);
  ForeignRig foreign;
  for (const std::string& camera : *names) {
    const Result<CameraModel> model = read_model(*intri, camera);
    if (!model) return forward(model);
    const Result<Eigen::Quaterniond> rotation = read_rotation(*extri, camera);
    if (!rotation) return forward(rotation);
    const Result<std::vector<double>> t = extri->matrix("T_" + camera, 3, 1);
    if (!t) return forward(t);
    foreign.rig.cameras.push_back(
        {serial_from_name(camera), *model, {rotation->normalized(), {(*t)[0], (*t)[1], (*t)[2]}}, {}});
    foreign.image_names.push_back(camera);
  }
  return checked(std::move(foreign), intri_name);
}

Result<ForeignRig> read_easymocap(const std::filesystem::path& folder) {
  const std::filesystem::path intri_yml = folder / "intri.yml", extri_yml = folder / "extri.yml";
  const Result<std::string> intri = read_file(intri_yml), extri = read_file(extri_yml);
  if (!intri) return forward(intri);
  if (!extri) return forward(extri);
  return parse_easymocap(*intri, *extri, intri_yml.string(), extri_yml.string());
}

Result<void> write_easymocap(const Rig& rig, const std::filesystem::path& folder) {
  if (Result<void> ok = check(rig); !ok)
    return fail(ok.error().code, text(folder.string(), ": ", ok.error().message));
  std::string intri = "%YAML:1.0\n---\nnames:\n", extri = intri;
  for (const RigCamera& c : rig.cameras) {
    if (std::holds_alternative<KannalaBrandt>(c.model.lens))
      return fail(ErrorCode::Unsupported,
                  text(folder.string(), ": camera '", c.serial,
                       "' has a fisheye lens, which this format cannot hold; write COLMAP instead"));
    if (c.model.skew != 0)
      return fail(ErrorCode::Unsupported,
                  text(folder.string(), ": camera '", c.serial,
                       "' has skewed pixels, which OpenCV ignores; write Qualisys or Middlebury instead"));
    intri += "   - \"" + c.serial + "\"\n";
    extri += "   - \"" + c.serial + "\"\n";
  }
  for (const RigCamera& c : rig.cameras) {
    const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
    const BrownConrady d = brown ? *brown : BrownConrady{};
    const Eigen::AngleAxisd turn(c.cam_from_world.rotation);
    const Eigen::Vector3d r = turn.angle() * turn.axis(), &t = c.cam_from_world.translation;
    intri += yaml_matrix("K_" + c.serial, 3, 3, by_rows(k_with_origin(c.model, kOrigin)));
    std::vector<double> terms{d.k1, d.k2, d.p1, d.p2, d.k3};
    if (d.rational()) terms.insert(terms.end(), {d.k4, d.k5, d.k6});
    intri += yaml_matrix("dist_" + c.serial, 1, static_cast<int>(terms.size()), terms);
    intri += text("H_", c.serial, ": ", c.model.height, "\nW_", c.serial, ": ", c.model.width, '\n');
    extri += yaml_matrix("R_" + c.serial, 3, 1, {r.x(), r.y(), r.z()});
    extri += yaml_matrix("Rot_" + c.serial, 3, 3, by_rows(c.cam_from_world.rotation.toRotationMatrix()));
    extri += yaml_matrix("T_" + c.serial, 3, 1, {t.x(), t.y(), t.z()});
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(ErrorCode::Io, text(folder.string(), ": cannot make this folder: ", error.message()));
  if (Result<void> ok = write_file(folder / "intri.yml", intri); !ok) return ok;
  return write_file(folder / "extri.yml", extri);
}

}  // namespace floatstage::calib
