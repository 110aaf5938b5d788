#include <cmath>
#include <cstdio>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

// The files are named with two digits: 00.png.
std::string two_digits(long index) {
  char buffer[24];
  std::snprintf(buffer, sizeof buffer, "%02ld", index);
  return buffer;
}

// Three lines of `Columns` numbers.
template <int Columns>
Result<Eigen::Matrix<double, 3, Columns>> read_rows(TextLines& lines, const std::string& what) {
  Eigen::Matrix<double, 3, Columns> m;
  for (int r = 0; r < 3; ++r) {
    const std::optional<TextLine> line = lines.next_filled();
    if (!line) return lines.cut_off(text("row ", r + 1, " of ", what));
    if (line->words.size() != Columns)
      return lines.bad(text("row ", r + 1, " of ", what, " needs ", Columns, " numbers, but ",
                            line->words.size(), " are here"));
    const Result<std::vector<double>> row = numbers(lines, *line, 0, Columns, what);
    if (!row) return forward(row);
    for (int c = 0; c < Columns; ++c) m(r, c) = (*row)[static_cast<std::size_t>(c)];
  }
  return m;
}

Result<RigCamera> read_camera(TextLines& lines, long index, double metres_per_unit) {
  RigCamera camera;
  camera.serial = two_digits(index);
  const std::string who = text("camera '", camera.serial, "'");
  const Result<Eigen::Matrix3d> k = read_rows<3>(lines, text("K of ", who));
  if (!k) return forward(k);
  if (Result<void> ok = set_k(camera.model, *k, PixelOrigin::FirstPixelCenter); !ok)
    return lines.bad(text(who, ": ", ok.error().message));
  const std::optional<TextLine> lens = lines.next_filled();
  if (!lens) return lines.cut_off(text("k1 k2 of ", who));
  if (lens->words.size() != 2) return lines.bad(text("k1 k2 of ", who, " must be two numbers"));
  const Result<std::vector<double>> k1k2 = numbers(lines, *lens, 0, 2, text("k1 k2 of ", who));
  if (!k1k2) return forward(k1k2);
  if ((*k1k2)[0] != 0 || (*k1k2)[1] != 0)
    camera.model.lens = BrownConrady{.k1 = (*k1k2)[0], .k2 = (*k1k2)[1]};
  const Result<Eigen::Matrix<double, 3, 4>> rt = read_rows<4>(lines, text("R|t of ", who));
  if (!rt) return forward(rt);
  const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(rt->leftCols<3>());
  if (!rotation) return lines.bad(text(who, ": ", rotation.error().message));
  camera.cam_from_world = {*rotation, rt->col(3) * metres_per_unit};
  return camera;
}

}  // namespace

Result<ForeignRig> parse_dome(std::string_view content, double metres_per_unit, std::string_view name) {
  if (!std::isfinite(metres_per_unit) || metres_per_unit <= 0)
    return fail(ErrorCode::InvalidArgument,
                text(metres_per_unit, " metres per unit is not a positive number"));
  TextLines lines(content, name);
  ForeignRig foreign;
  while (const std::optional<TextLine> head = lines.next_filled()) {
    const std::optional<long> index = parse_integer(head->words[0]);
    if (head->words.size() != 1 || !index || *index < 0)
      return lines.bad("a camera's index should stand here, alone, as a whole number from 0");
    Result<RigCamera> camera = read_camera(lines, *index, metres_per_unit);
    if (!camera) return forward(camera);
    foreign.image_names.push_back(camera->serial);
    foreign.rig.cameras.push_back(std::move(*camera));
  }
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_dome(const std::filesystem::path& calibration_txt, double metres_per_unit) {
  const Result<std::string> content = read_file(calibration_txt);
  if (!content) return forward(content);
  return parse_dome(*content, metres_per_unit, calibration_txt.string());
}

}  // namespace floatstage::calib
