#include <cmath>
#include <map>

#include "calib/colmap_model.h"
#include "calib/formats/camera_parts.h"
#include "calib/formats/colmap_cameras.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr double kLargestQuaternionError = 1e-3;  // of its length from 1

Result<CameraModel> parse_model(const TextLines& lines, const TextLine& line, const std::string& who) {
  if (line.words.size() < 4)
    return lines.bad(text(who, " needs CAMERA_ID MODEL WIDTH HEIGHT and parameters"));
  const std::string_view name = line.words[1];
  const ColmapCameraModel* const shape = colmap_model_named(name);
  if (!shape)
    return fail(ErrorCode::Unsupported,
                text(lines.bad(who).error_value.message, ": the camera model ", name,
                     " is not supported; convert the model to OPENCV or OPENCV_FISHEYE"));
  const std::optional<long> width = parse_integer(line.words[2]), height = parse_integer(line.words[3]);
  const std::size_t count = shape->parameters();
  if (line.words.size() != 4 + count)
    return lines.bad(
        text(who, ": ", name, " has ", count, " parameters, but ", line.words.size() - 4, " are here"));
  const Result<std::vector<double>> p = numbers(lines, line, 4, count, who);
  if (!p) return forward(p);
  const Result<CameraModel> model = camera_from_colmap(*shape, width.value_or(0), height.value_or(0), *p);
  if (!model)
    return fail(model.error().code, text(lines.bad(who).error_value.message, ": ", model.error().message));
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
  const bool binary = is_there(folder / "images.bin");
  const std::string extension = binary ? ".bin" : ".txt";
  const std::string cameras_file = (folder / ("cameras" + extension)).string(),
                    images_file = (folder / ("images" + extension)).string();
  const Result<std::string> cameras = read_file(cameras_file), images = read_file(images_file);
  if (!cameras) return forward(cameras);
  if (!images) return forward(images);
  return (binary ? parse_colmap_binary : parse_colmap)(*cameras, *images, cameras_file, images_file);
}

Result<void> write_colmap(const Rig& rig, const std::vector<std::string>& image_names,
                          const std::filesystem::path& folder) {
  return write_colmap_model(rig, image_names, {}, folder);
}

}  // namespace floatstage::calib
