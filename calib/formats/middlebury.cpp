#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr auto kOrigin = PixelOrigin::FirstPixelCenter;
constexpr std::size_t kWordsPerCamera = 1 + 9 + 9 + 3;  // name, K, R, t
constexpr long kMostCameras = 100'000;                  // more is a damaged count

Eigen::Matrix3d row_major(const std::vector<double>& values, std::size_t first) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data() + first);
}

void append_row_major(std::string& out, const Eigen::Matrix3d& m) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out += ' ' + to_text(m(r, c));
}

}  // namespace

Result<ForeignRig> parse_middlebury(std::string_view content, std::string_view name) {
  TextLines lines(content, name);
  const std::optional<TextLine> head = lines.next_filled();
  if (!head) return lines.cut_off("the number of cameras");
  const std::optional<long> count = parse_integer(head->words[0]);
  if (head->words.size() != 1 || !count || *count < 1 || *count > kMostCameras)
    return lines.bad("the file must begin with a line that holds only the number of cameras");
  ForeignRig foreign;
  for (long i = 0; i < *count; ++i) {
    const std::optional<TextLine> line = lines.next_filled();
    if (!line) return lines.cut_off(text("camera ", i + 1, " of ", *count));
    const std::string image(line->words[0]);
    if (line->words.size() != kWordsPerCamera)
      return lines.bad(text("camera '", image, "' needs a name, K, R and t: ", kWordsPerCamera,
                            " words, but ", line->words.size(), " are here"));
    const Result<std::vector<double>> values =
        numbers(lines, *line, 1, kWordsPerCamera - 1, text("camera '", image, "'"));
    if (!values) return forward(values);
    RigCamera camera;
    camera.serial = serial_from_name(image);
    if (Result<void> ok = set_k(camera.model, row_major(*values, 0), kOrigin); !ok)
      return lines.bad(text("camera '", image, "': ", ok.error().message));
    const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(row_major(*values, 9));
    if (!rotation) return lines.bad(text("camera '", image, "': ", rotation.error().message));
    camera.cam_from_world = {*rotation, Eigen::Map<const Eigen::Vector3d>(values->data() + 18)};
    foreign.rig.cameras.push_back(camera);
    foreign.image_names.push_back(image);
  }
  if (lines.next_filled())
    return lines.bad(text("more cameras than the ", *count, " that the first line announces"));
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_middlebury(const std::filesystem::path& par_txt) {
  const Result<std::string> content = read_file(par_txt);
  if (!content) return forward(content);
  return parse_middlebury(*content, par_txt.string());
}

Result<void> write_middlebury(const Rig& rig, const std::vector<std::string>& image_names,
                              const std::filesystem::path& par_txt) {
  if (Result<void> ok = check_writable(rig, image_names, par_txt.string()); !ok) return ok;
  std::string out = text(rig.cameras.size(), '\n');
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const RigCamera& c = rig.cameras[i];
    if (!std::holds_alternative<std::monostate>(c.model.lens))
      return fail(ErrorCode::Unsupported,
                  text(par_txt.string(), ": camera '", c.serial,
                       "' has lens distortion, which this format cannot hold; undistort the "
                       "pictures first or write COLMAP or OpenCV"));
    if (image_names[i].find_first_of(" \t\r\n") != std::string::npos)
      return fail(ErrorCode::Unsupported,
                  text(par_txt.string(), ": the image name '", image_names[i],
                       "' holds a blank, which this format cannot hold; rename the image"));
    out += image_names[i];
    append_row_major(out, k_with_origin(c.model, kOrigin));
    append_row_major(out, c.cam_from_world.rotation.toRotationMatrix());
    for (int r = 0; r < 3; ++r) out += ' ' + to_text(c.cam_from_world.translation[r]);
    out += '\n';
  }
  return write_file(par_txt, out);
}

}  // namespace floatstage::calib
