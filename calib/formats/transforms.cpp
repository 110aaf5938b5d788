// transforms.json of instant-ngp and nerfstudio (and of the synthetic scenes of NeRF, which state an angle of
// view in the place of a focal length): camera-to-world matrices with OpenGL's axes, x right, y up, z
// backward; the origin of pixels is the picture's corner, as COLMAP has it, from whose models most of these
// files are made.
#include <array>
#include <cmath>

#include <unistd.h>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "core/file.h"
#include "core/file_descriptor.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr int kLargestImage = 1 << 20;  // px a side; more is a damaged file

// What a frame says of its camera, or else the file for all of them.
class Stated {
 public:
  Stated(JsonFields& frame, JsonFields& file) : frame_(frame), file_(file) {}

  bool has(const char* key) const { return frame_.has(key) || file_.has(key); }
  double number(const char* key, double fallback) {
    if (frame_.has(key)) return frame_.number(key);
    return file_.has(key) ? file_.number(key) : fallback;
  }
  std::string word(const char* key) {
    if (frame_.has(key)) return frame_.string(key);
    return file_.has(key) ? file_.string(key) : std::string();
  }
  bool yes(const char* key) {
    if (frame_.has(key)) return frame_.boolean(key);
    return file_.has(key) && file_.boolean(key);
  }

 private:
  JsonFields &frame_, &file_;
};

Result<Lens> lens_of(Stated& stated) {
  const std::string model = stated.word("camera_model");
  const double k1 = stated.number("k1", 0), k2 = stated.number("k2", 0), k3 = stated.number("k3", 0),
               k4 = stated.number("k4", 0), p1 = stated.number("p1", 0), p2 = stated.number("p2", 0);
  const bool straight = k1 == 0 && k2 == 0 && k3 == 0 && k4 == 0 && p1 == 0 && p2 == 0;
  if (model == "OPENCV_FISHEYE" || stated.yes("is_fisheye")) {
    if (p1 != 0 || p2 != 0)
      return fail(ErrorCode::Unsupported, "a fisheye with p1 or p2 is no lens that Floatstage has");
    return Lens(KannalaBrandt{k1, k2, k3, k4});
  }
  const bool known = model.empty() || model == "OPENCV" || model == "PINHOLE" || model == "SIMPLE_PINHOLE" ||
                     model == "SIMPLE_RADIAL" || model == "RADIAL";
  if (!known)
    return fail(ErrorCode::Unsupported, text("the camera model '", model,
                                             "' is not supported; there are PINHOLE, SIMPLE_PINHOLE, "
                                             "SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE"));
  if (k4 != 0) return fail(ErrorCode::Unsupported, "k4 is of no lens that Floatstage has but a fisheye");
  return straight ? Lens() : Lens(BrownConrady{k1, k2, p1, p2, k3});
}

// Width, height and focal lengths; the size that its picture has where the file states none.
Result<CameraModel> model_of(Stated& stated, const PictureSize& size_of, const std::string& picture) {
  double w = stated.number("w", 0), h = stated.number("h", 0);
  if (!stated.has("w") || !stated.has("h")) {
    const Result<std::pair<int, int>> size = size_of(picture);
    if (!size) return forward(size);
    w = size->first;
    h = size->second;
  }
  if (!(w >= 1 && h >= 1 && w <= kLargestImage && h <= kLargestImage && w == std::floor(w) &&
        h == std::floor(h)))
    return fail(ErrorCode::BadData, "w and h are not a pair of positive whole numbers");
  CameraModel model;
  model.width = static_cast<int>(w);
  model.height = static_cast<int>(h);
  const auto from_angle = [&](const char* key, double side) {
    return stated.has(key) ? 0.5 * side / std::tan(0.5 * stated.number(key, 0)) : 0.0;
  };
  double fx = stated.number("fl_x", from_angle("camera_angle_x", w));
  double fy = stated.number("fl_y", from_angle("camera_angle_y", h));
  if (fx == 0) fx = fy;  // one stated: square pixels
  if (fy == 0) fy = fx;
  if (!(fx > 0 && fy > 0 && std::isfinite(fx) && std::isfinite(fy)))
    return fail(ErrorCode::BadData, "there is no focal length above 0: neither fl_x nor camera_angle_x");
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = fx;
  k(1, 1) = fy;
  k(0, 2) = stated.number("cx", 0.5 * w);
  k(1, 2) = stated.number("cy", 0.5 * h);
  if (Result<void> ok = set_k(model, k, PixelOrigin::ImageCorner); !ok) return forward(ok);
  const Result<Lens> lens = lens_of(stated);
  if (!lens) return forward(lens);
  model.lens = *lens;
  return model;
}

Result<Rigid3> pose_of(const std::vector<double>& rows) {
  Eigen::Matrix4d world_from_camera;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) world_from_camera(r, c) = rows[static_cast<std::size_t>(4 * r + c)];
  if ((world_from_camera.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-9)
    return fail(ErrorCode::BadData, "the last row of transform_matrix is not 0 0 0 1");
  world_from_camera.middleCols<2>(1) *= -1;  // y down, z forward
  const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(world_from_camera.topLeftCorner<3, 3>());
  if (!rotation) return forward(rotation);
  return Rigid3{*rotation, world_from_camera.topRightCorner<3, 1>()}.inverse();
}

// The size in a PNG's header; nothing where there is no PNG.
std::optional<std::pair<int, int>> png_size(const std::filesystem::path& file) {
  constexpr std::size_t kHeader = 24;
  std::array<unsigned char, kHeader> bytes{};
  const Result<FileDescriptor> in = open_to_read(file);  // no pipe, which would wait for ever
  if (!in || ::read(in->get(), bytes.data(), kHeader) != kHeader || bytes[0] != 0x89 || bytes[1] != 'P')
    return std::nullopt;
  const auto number = [&](std::size_t at) {
    return static_cast<int>((bytes[at] & 127U) << 24 | bytes[at + 1] << 16 | bytes[at + 2] << 8 |
                            bytes[at + 3]);
  };
  return std::pair(number(16), number(20));
}

// "./images/cam00.png" and "images/cam00" → "images/cam00.png" and "images/cam00".
std::string plain_path(std::string path) {
  while (path.starts_with("./")) path.erase(0, 2);
  return path;
}

}  // namespace

Result<ForeignRig> parse_transforms(std::string_view content, const PictureSize& size_of,
                                    std::string_view name) {
  const Result<nlohmann::json> root = parse_json(content, name);
  if (!root) return forward(root);
  JsonProblem problem;
  JsonFields file(*root, std::string(name), problem);
  const nlohmann::json* const frames = file.list("frames");
  ForeignRig foreign;
  for (std::size_t i = 0; frames && !problem.first && i < frames->size(); ++i) {
    const std::string where = text(name, ": frame ", i);
    JsonFields frame((*frames)[i], where, problem);
    const std::string picture = plain_path(frame.string("file_path"));
    const std::vector<double> matrix = frame.numbers("transform_matrix", 16);
    if (problem.first) break;
    Stated stated(frame, file);
    const Result<CameraModel> model = model_of(stated, size_of, picture);
    if (problem.first) break;
    if (!model) return fail(model.error().code, text(where, ": ", model.error().message));
    const Result<Rigid3> pose = pose_of(matrix);
    if (!pose) return fail(pose.error().code, text(where, ": ", pose.error().message));
    const std::string file_name = std::filesystem::path(picture).filename().string();
    foreign.rig.cameras.push_back({serial_from_name(file_name), *model, *pose, {}});
    foreign.image_names.push_back(picture);
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_transforms(const std::filesystem::path& file) {
  const Result<std::string> content = read_file(file);
  if (!content) return forward(content);
  const std::filesystem::path folder = file.parent_path();
  const PictureSize size_of = [&](const std::string& picture) -> Result<std::pair<int, int>> {
    for (const char* extension : {"", ".png"})
      if (const std::optional<std::pair<int, int>> size = png_size(folder / (picture + extension)))
        return *size;
    return fail(ErrorCode::BadData, text("states no w and h, and ", (folder / picture).string(),
                                         " is no PNG that does; add them"));
  };
  return parse_transforms(*content, size_of, file.string());
}

}  // namespace floatstage::calib
