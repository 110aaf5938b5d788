#include <cmath>
#include <opencv2/core.hpp>

#include "calib/formats/camera_parts.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr auto kOrigin = PixelOrigin::FirstPixelCenter;
constexpr std::size_t kMostNumbers = 32;  // in a matrix of this format

/// One of the two files, opened. Its matrices are read element by element: cv::Mat would be allocated from sizes that
/// the file claims.
class YamlFile {
 public:
  static Result<YamlFile> open(std::string_view content, std::string_view name) {
    YamlFile file;
    file.name_ = name;
    if (content.substr(0, 5) != "%YAML")
      return fail(ErrorCode::BadData, text(name, ": does not begin with %YAML; it should be written by OpenCV's FileStorage"));
    if (content.find('\0') != std::string_view::npos)
      return fail(ErrorCode::BadData, text(name, ": holds a zero byte; it is not a text file"));
    try {
      if (!file.storage_.open(std::string(content), cv::FileStorage::READ | cv::FileStorage::MEMORY |
                                                        cv::FileStorage::FORMAT_YAML))
        return fail(ErrorCode::BadData, text(name, ": is not a YAML file as OpenCV writes it"));
    } catch (const std::exception& e) {
      return fail(ErrorCode::BadData, text(name, ": ", one_line(e.what())));
    }
    return file;
  }

  bool has(const std::string& key) const { return !storage_[key].empty(); }

  /// A matrix of `rows`×`cols`, row by row. rows = 1 takes any vector of up to kMostNumbers, lying or standing.
  Result<std::vector<double>> matrix(const std::string& key, int rows, int cols) const {
    const cv::FileNode node = storage_[key];
    if (!node.isMap()) return bad(key, "is missing or is not a matrix");
    const Result<double> r = element(key, node["rows"]), c = element(key, node["cols"]);
    if (!r) return forward(r);
    if (!c) return forward(c);
    const cv::FileNode data = node["data"];
    const bool shape_fits = rows == 1 ? *r == 1 || *c == 1 : (*r == rows && *c == cols);
    if (!shape_fits || !data.isSeq() || data.size() > kMostNumbers || static_cast<double>(data.size()) != *r * *c)
      return bad(key, rows == 1 ? std::string("should be a vector of a few numbers") : text("should be ", rows, "×", cols, " numbers"));
    std::vector<double> values;
    for (const cv::FileNode& e : data) {
      const Result<double> value = element(key, e);
      if (!value) return forward(value);
      values.push_back(*value);
    }
    return values;
  }

  Result<double> number(const std::string& key) const { return element(key, storage_[key]); }

  Result<std::vector<std::string>> names() const {
    const cv::FileNode node = storage_["names"];
    if (!node.isSeq() || node.size() == 0) return bad("names", "is missing or is not a list of camera names");
    std::vector<std::string> names;
    for (const cv::FileNode& e : node) {
      // A name of digits that its writer did not quote reads as a number.
      if (e.isInt()) names.push_back(std::to_string(static_cast<int>(e)));
      else if (e.isString()) names.push_back(static_cast<std::string>(e));
      else return bad("names", "holds something that is not a name");
    }
    return names;
  }

  Unexpected bad(const std::string& key, const std::string& what) const {
    return fail(ErrorCode::BadData, text(name_, ": ", key, " ", what));
  }

 private:
  Result<double> element(const std::string& key, const cv::FileNode& node) const {
    if (!node.isInt() && !node.isReal()) return bad(key, "holds something that is not a number");
    const double value = static_cast<double>(node);
    if (!std::isfinite(value)) return bad(key, "holds a number that is not finite");
    return value;
  }

  static std::string one_line(std::string message) {
    for (char& c : message)
      if (c == '\n') c = ' ';
    while (!message.empty() && message.back() == ' ') message.pop_back();
    return message;
  }

  cv::FileStorage storage_;
  std::string name_;
};

Eigen::Matrix3d row_major(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}

Result<Lens> read_lens(const YamlFile& intri, const std::string& key) {
  if (!intri.has(key)) return Lens{};
  const Result<std::vector<double>> read = intri.matrix(key, 1, 0);
  if (!read) return forward(read);
  std::vector<double> d = *read;
  if (d.size() != 4 && d.size() != 5 && d.size() != 8 && d.size() != 12 && d.size() != 14)
    return intri.bad(key, text("has ", d.size(), " coefficients; OpenCV has 4, 5, 8, 12 or 14"));
  for (std::size_t i = 5; i < d.size(); ++i)
    if (d[i] != 0)
      return fail(ErrorCode::Unsupported, intri.bad(key, "has rational, prism or tilt terms (after k3), which Floatstage does "
                                                         "not have; calibrate again with five coefficients").error_value.message);
  d.resize(5);
  const BrownConrady lens{d[0], d[1], d[2], d[3], d[4]};
  return lens == BrownConrady{} ? Lens{} : Lens(lens);
}

Result<CameraModel> read_model(const YamlFile& intri, const std::string& camera) {
  CameraModel model;
  const std::string key = "K_" + camera;
  const Result<std::vector<double>> k = intri.matrix(key, 3, 3);
  if (!k) return forward(k);
  if (Result<void> ok = set_k(model, row_major(*k), kOrigin); !ok) return intri.bad(key, text("is wrong: ", ok.error().message));
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

Result<Eigen::Quaterniond> read_rotation(const YamlFile& extri, const std::string& camera) {
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
  return angle == 0 ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis / angle));
}

std::string yaml_matrix(const std::string& key, int rows, int cols, const std::vector<double>& values) {
  std::string out = text(key, ": !!opencv-matrix\n   rows: ", rows, "\n   cols: ", cols, "\n   dt: d\n   data: [ ");
  for (std::size_t i = 0; i < values.size(); ++i) {
    // OpenCV takes "1" for an integer and is content; the point keeps other readers from doing so.
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

Result<ForeignRig> parse_easymocap(std::string_view intri_text, std::string_view extri_text, std::string_view intri_name,
                                   std::string_view extri_name) {
  const Result<YamlFile> intri = YamlFile::open(intri_text, intri_name);
  if (!intri) return forward(intri);
  const Result<YamlFile> extri = YamlFile::open(extri_text, extri_name);
  if (!extri) return forward(extri);
  try {
    const Result<std::vector<std::string>> names = intri->names();
    if (!names) return forward(names);
    ForeignRig foreign;
    for (const std::string& camera : *names) {
      const Result<CameraModel> model = read_model(*intri, camera);
      if (!model) return forward(model);
      const Result<Eigen::Quaterniond> rotation = read_rotation(*extri, camera);
      if (!rotation) return forward(rotation);
      const Result<std::vector<double>> t = extri->matrix("T_" + camera, 3, 1);
      if (!t) return forward(t);
      foreign.rig.cameras.push_back({serial_from_name(camera), *model, {rotation->normalized(), {(*t)[0], (*t)[1], (*t)[2]}}, {}});
      foreign.image_names.push_back(camera);
    }
    return checked(std::move(foreign), intri_name);
  } catch (const cv::Exception& e) {  // its nodes may throw when they are read, too
    return fail(ErrorCode::BadData, text(intri_name, " or ", extri_name, ": damaged: ", e.err));
  }
}

Result<ForeignRig> read_easymocap(const std::filesystem::path& folder) {
  const std::filesystem::path intri_yml = folder / "intri.yml", extri_yml = folder / "extri.yml";
  const Result<std::string> intri = read_file(intri_yml), extri = read_file(extri_yml);
  if (!intri) return forward(intri);
  if (!extri) return forward(extri);
  return parse_easymocap(*intri, *extri, intri_yml.string(), extri_yml.string());
}

Result<void> write_easymocap(const Rig& rig, const std::filesystem::path& folder) {
  if (Result<void> ok = check(rig); !ok) return fail(ok.error().code, text(folder.string(), ": ", ok.error().message));
  std::string intri = "%YAML:1.0\n---\nnames:\n", extri = intri;
  for (const RigCamera& c : rig.cameras) {
    if (std::holds_alternative<KannalaBrandt>(c.model.lens))
      return fail(ErrorCode::Unsupported, text(folder.string(), ": camera '", c.serial,
                                               "' has a fisheye lens, which this format cannot hold; write COLMAP instead"));
    intri += "   - \"" + c.serial + "\"\n";
    extri += "   - \"" + c.serial + "\"\n";
  }
  for (const RigCamera& c : rig.cameras) {
    const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
    const BrownConrady d = brown ? *brown : BrownConrady{};
    const Eigen::AngleAxisd turn(c.cam_from_world.rotation);
    const Eigen::Vector3d r = turn.angle() * turn.axis(), &t = c.cam_from_world.translation;
    intri += yaml_matrix("K_" + c.serial, 3, 3, by_rows(k_with_origin(c.model, kOrigin)));
    intri += yaml_matrix("dist_" + c.serial, 1, 5, {d.k1, d.k2, d.p1, d.p2, d.k3});
    intri += text("H_", c.serial, ": ", c.model.height, "\nW_", c.serial, ": ", c.model.width, '\n');
    extri += yaml_matrix("R_" + c.serial, 3, 1, {r.x(), r.y(), r.z()});
    extri += yaml_matrix("Rot_" + c.serial, 3, 3, by_rows(c.cam_from_world.rotation.toRotationMatrix()));
    extri += yaml_matrix("T_" + c.serial, 3, 1, {t.x(), t.y(), t.z()});
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(ErrorCode::Io, text(folder.string(), ": cannot make this folder: ", error.message()));
  if (Result<void> ok = write_file(folder / "intri.yml", intri); !ok) return ok;
  return write_file(folder / "extri.yml", extri);
}

}  // namespace floatstage
