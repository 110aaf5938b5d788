#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr auto kOrigin = PixelOrigin::ImageCorner;
constexpr long kLargestImage = 1 << 20;           // px a side; more is a damaged file
constexpr double kLargestQuaternionError = 1e-3;  // of its length from 1

// Which parameters a model of COLMAP has, in the file's order.
struct ModelShape {
  const char* name;
  std::size_t focals;  // 1 or 2
  std::size_t lens;    // coefficients after the principal point
};
constexpr std::array kModels{ModelShape{"SIMPLE_PINHOLE", 1, 0}, ModelShape{"PINHOLE", 2, 0},
                             ModelShape{"SIMPLE_RADIAL", 1, 1},  ModelShape{"RADIAL", 1, 2},
                             ModelShape{"OPENCV", 2, 4},         ModelShape{"FULL_OPENCV", 2, 8},
                             ModelShape{"OPENCV_FISHEYE", 2, 4}};

Result<Lens> lens_of(std::string_view model, const std::vector<double>& c) {
  if (c.empty()) return Lens{};
  if (model == "OPENCV_FISHEYE") return Lens(KannalaBrandt{c[0], c[1], c[2], c[3]});
  if (model == "SIMPLE_RADIAL") return Lens(BrownConrady{.k1 = c[0]});
  if (model == "RADIAL") return Lens(BrownConrady{.k1 = c[0], .k2 = c[1]});
  if (model == "OPENCV") return Lens(BrownConrady{c[0], c[1], c[2], c[3]});
  if (c[5] != 0 || c[6] != 0 || c[7] != 0)
    return fail(
        ErrorCode::Unsupported,
        "FULL_OPENCV with k4, k5 or k6 other than 0 is a rational lens, which Floatstage does not have; "
        "calibrate again with OPENCV or FULL_OPENCV without them");
  return Lens(BrownConrady{c[0], c[1], c[2], c[3], c[4]});
}

Result<CameraModel> parse_model(const TextLines& lines, const TextLine& line, const std::string& who) {
  if (line.words.size() < 4)
    return lines.bad(text(who, " needs CAMERA_ID MODEL WIDTH HEIGHT and parameters"));
  const std::string_view name = line.words[1];
  const auto shape =
      std::find_if(kModels.begin(), kModels.end(), [&](const ModelShape& m) { return name == m.name; });
  if (shape == kModels.end())
    return fail(ErrorCode::Unsupported,
                text(lines.bad(who).error_value.message, ": the camera model ", name,
                     " is not supported; convert the model to OPENCV or OPENCV_FISHEYE"));
  const std::optional<long> width = parse_integer(line.words[2]), height = parse_integer(line.words[3]);
  if (!width || !height || *width < 1 || *height < 1 || *width > kLargestImage || *height > kLargestImage)
    return lines.bad(text(who, ": the image size is not a pair of positive whole numbers"));
  const std::size_t count = shape->focals + 2 + shape->lens;
  if (line.words.size() != 4 + count)
    return lines.bad(
        text(who, ": ", name, " has ", count, " parameters, but ", line.words.size() - 4, " are here"));
  const Result<std::vector<double>> p = numbers(lines, line, 4, count, who);
  if (!p) return forward(p);
  CameraModel model;
  model.width = static_cast<int>(*width);
  model.height = static_cast<int>(*height);
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = (*p)[0];
  k(1, 1) = (*p)[shape->focals - 1];
  k(0, 2) = (*p)[shape->focals];
  k(1, 2) = (*p)[shape->focals + 1];
  if (Result<void> ok = set_k(model, k, kOrigin); !ok) return lines.bad(text(who, ": ", ok.error().message));
  const auto first_of_lens = p->begin() + static_cast<std::ptrdiff_t>(shape->focals + 2);
  const Result<Lens> lens = lens_of(name, {first_of_lens, p->end()});
  if (!lens)
    return fail(lens.error().code, text(lines.bad(who).error_value.message, ": ", lens.error().message));
  model.lens = *lens;
  return model;
}

Result<std::map<long, CameraModel>> parse_models(std::string_view content, std::string_view name) {
  TextLines lines(content, name);
  std::map<long, CameraModel> models;
  while (const std::optional<TextLine> line = lines.next_filled('#')) {
    const std::optional<long> id = parse_integer(line->words[0]);
    if (!id) return lines.bad("a camera's line must begin with its whole-number id");
    const Result<CameraModel> model = parse_model(lines, *line, text("camera ", *id));
    if (!model) return forward(model);
    if (!models.emplace(*id, *model).second) return lines.bad(text("camera ", *id, " is here a second time"));
  }
  if (models.empty()) return fail(ErrorCode::BadData, text(name, ": there is no camera in this file"));
  return models;
}

// The rest of the line from word `first` on: names may hold blanks.
std::string_view from_word(const TextLine& line, std::size_t first) {
  const char* begin = line.words[first].data();
  const std::string_view last = line.words.back();
  return {begin, static_cast<std::size_t>(last.data() + last.size() - begin)};
}

Result<Rigid3> parse_pose(const TextLines& lines, const TextLine& line, const std::string& who) {
  const Result<std::vector<double>> v = numbers(lines, line, 1, 7, who);
  if (!v) return forward(v);
  const Eigen::Quaterniond q((*v)[0], (*v)[1], (*v)[2], (*v)[3]);
  if (!(std::abs(q.norm() - 1) <= kLargestQuaternionError))
    return lines.bad(text(who, ": the quaternion has length ", q.norm(), " instead of 1"));
  return Rigid3{q.normalized(), {(*v)[4], (*v)[5], (*v)[6]}};
}

std::string camera_line(std::size_t id, const CameraModel& m) {
  const auto* brown = std::get_if<BrownConrady>(&m.lens);
  const auto* fisheye = std::get_if<KannalaBrandt>(&m.lens);
  const char* name = "PINHOLE";
  std::vector<double> p{m.fx, m.fy, from_corner_origin(m.cx, kOrigin), from_corner_origin(m.cy, kOrigin)};
  if (fisheye) {
    name = "OPENCV_FISHEYE";
    p.insert(p.end(), {fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4});
  } else if (brown) {
    name = brown->k3 == 0 ? "OPENCV" : "FULL_OPENCV";
    p.insert(p.end(), {brown->k1, brown->k2, brown->p1, brown->p2});
    if (brown->k3 != 0) p.insert(p.end(), {brown->k3, 0, 0, 0});
  }
  std::string out = text(id, ' ', name, ' ', m.width, ' ', m.height);
  for (double v : p) out += ' ' + to_text(v);
  return out + '\n';
}

std::string image_line(std::size_t id, const Rigid3& pose, const std::string& image) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  std::string out = text(id);
  for (double v : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) out += ' ' + to_text(v);
  return text(out, ' ', id, ' ', image, "\n\n");  // the second line is the image's points: none
}

}  // namespace

Result<ForeignRig> parse_colmap(std::string_view cameras, std::string_view images,
                                std::string_view cameras_name, std::string_view images_name) {
  const Result<std::map<long, CameraModel>> models = parse_models(cameras, cameras_name);
  if (!models) return forward(models);
  TextLines lines(images, images_name);
  ForeignRig foreign;
  while (const std::optional<TextLine> line = lines.next_filled('#')) {
    if (line->words.size() < 10)
      return lines.bad("an image needs IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    const std::string image(from_word(*line, 9));
    const std::string who = text("image '", image, "'");
    const Result<Rigid3> pose = parse_pose(lines, *line, who);
    if (!pose) return forward(pose);
    const std::optional<long> id = parse_integer(line->words[8]);
    const auto model = id ? models->find(*id) : models->end();
    if (model == models->end())
      return lines.bad(
          text(who, " names camera ", line->words[8], ", which ", cameras_name, " does not have"));
    foreign.rig.cameras.push_back({serial_from_name(image), model->second, *pose, {}});
    foreign.image_names.push_back(image);
    // The line after it holds the image's points, three words each; it is there even when it is empty.
    if (const std::optional<TextLine> points = lines.next(); points && points->words.size() % 3 != 0)
      return lines.bad(
          text("the points of ", who, " should stand here as triples X Y POINT3D_ID, or an empty line"));
  }
  return checked(std::move(foreign), images_name);
}

Result<ForeignRig> read_colmap(const std::filesystem::path& folder) {
  const std::filesystem::path cameras_txt = folder / "cameras.txt", images_txt = folder / "images.txt";
  const Result<std::string> cameras = read_file(cameras_txt), images = read_file(images_txt);
  if (!cameras) return forward(cameras);
  if (!images) return forward(images);
  return parse_colmap(*cameras, *images, cameras_txt.string(), images_txt.string());
}

Result<void> write_colmap(const Rig& rig, const std::vector<std::string>& image_names,
                          const std::filesystem::path& folder) {
  if (Result<void> ok = check_writable(rig, image_names, folder.string()); !ok) return ok;
  std::string cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  std::string images =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points: X Y POINT3D_ID …\n";
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const RigCamera& c = rig.cameras[i];
    if (c.model.skew != 0)
      return fail(ErrorCode::Unsupported, text(folder.string(), ": camera '", c.serial,
                                               "' has skewed pixels, which this format cannot hold"));
    cameras += camera_line(i + 1, c.model);
    images += image_line(i + 1, c.cam_from_world, image_names[i]);
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(ErrorCode::Io, text(folder.string(), ": cannot make this folder: ", error.message()));
  // COLMAP opens a text model only with all three files.
  for (const auto& [file, content] : {std::pair<const char*, std::string>{"cameras.txt", cameras},
                                      {"images.txt", images},
                                      {"points3D.txt", "# no points\n"}})
    if (Result<void> ok = write_file(folder / file, content); !ok) return ok;
  return {};
}

}  // namespace floatstage::calib
