// calibration_<sequence>.json of the CMU Panoptic Studio (Joo et al., ICCV 2015): centimetres, OpenCV's lens
// and pixels.
#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr double kMetres = 0.01;  // a centimetre

Eigen::Matrix3d matrix_of(const std::vector<double>& rows) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = rows[static_cast<std::size_t>(i)];
  return m;
}

}  // namespace

Result<ForeignRig> parse_panoptic(std::string_view content, std::string_view name) {
  const Result<nlohmann::json> root = parse_json(content, name);
  if (!root) return forward(root);
  JsonProblem problem;
  JsonFields file(*root, std::string(name), problem);
  const nlohmann::json* const cameras = file.list("cameras");
  ForeignRig foreign;
  for (std::size_t i = 0; cameras && !problem.first && i < cameras->size(); ++i) {
    JsonFields fields((*cameras)[i], text(name, ": camera ", i), problem);
    const std::string serial = fields.string("name");
    const std::string where = text(name, ": camera '", serial, "'");
    const std::vector<double> size = fields.numbers("resolution", 2), k = fields.numbers("K", 9),
                              d = fields.numbers("distCoef", 5), r = fields.numbers("R", 9),
                              t = fields.numbers("t", 3);
    if (problem.first) break;
    CameraModel model;
    constexpr double kLargestImage = 1 << 20;
    for (const double side : size)
      if (!(side >= 1 && side <= kLargestImage))
        return fail(ErrorCode::BadData, text(where, ": the resolution is not a pair of positive numbers"));
    model.width = static_cast<int>(size[0]);
    model.height = static_cast<int>(size[1]);
    if (Result<void> ok = set_k(model, matrix_of(k), PixelOrigin::FirstPixelCenter); !ok)
      return fail(ok.error().code, text(where, ": ", ok.error().message));
    const BrownConrady lens{d[0], d[1], d[2], d[3], d[4]};
    if (!(lens == BrownConrady{})) model.lens = lens;
    const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(matrix_of(r));
    if (!rotation) return fail(rotation.error().code, text(where, ": ", rotation.error().message));
    foreign.rig.cameras.push_back(
        {serial_from_name(serial), model, {*rotation, kMetres * Eigen::Vector3d(t[0], t[1], t[2])}, {}});
    foreign.image_names.push_back(serial);
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_panoptic(const std::filesystem::path& file) {
  const Result<std::string> content = read_file(file);
  if (!content) return forward(content);
  return parse_panoptic(*content, file.string());
}

}  // namespace floatstage::calib
