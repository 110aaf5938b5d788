// COLMAP's binary models: cameras.bin and images.bin as src/base/reconstruction.cc of COLMAP 3.8 writes them,
// little-endian and without padding.
#include <cmath>
#include <map>

#include "calib/formats/byte_reader.h"
#include "calib/formats/camera_parts.h"
#include "calib/formats/colmap_cameras.h"
#include "calib/formats/parsers.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr double kLargestQuaternionError = 1e-3;  // of its length from 1
constexpr std::size_t kObservation = 24;          // bytes: x, y, id of the point

Unexpected cut_off(std::string_view name, const std::string& what) {
  return fail(ErrorCode::BadData, text(name, ": ends within ", what, "; the file is cut off"));
}

using Models = std::map<std::uint32_t, CameraModel>;

Result<CameraModel> next_model(ByteReader& in, const std::string& who, std::string_view name) {
  const auto model = in.next<std::int32_t>();
  const auto width = in.next<std::uint64_t>(), height = in.next<std::uint64_t>();
  if (!model || !width || !height) return cut_off(name, who);
  const ColmapCameraModel* const shape = colmap_model_numbered(*model);
  if (!shape)
    return fail(ErrorCode::Unsupported,
                text(name, ": ", who, ": the camera model number ", *model, " is none of COLMAP 3.8's"));
  std::vector<double> parameters;
  for (std::size_t i = 0; i < shape->parameters(); ++i) {
    const auto value = in.next<double>();
    if (!value) return cut_off(name, who);
    if (!std::isfinite(*value))
      return fail(ErrorCode::BadData, text(name, ": ", who, ": a parameter is not finite"));
    parameters.push_back(*value);
  }
  const auto side = [](std::uint64_t v) { return static_cast<long>(std::min<std::uint64_t>(v, 1U << 30U)); };
  Result<CameraModel> camera = camera_from_colmap(*shape, side(*width), side(*height), parameters);
  if (!camera) return fail(camera.error().code, text(name, ": ", who, ": ", camera.error().message));
  return camera;
}

Result<Models> models_of(std::string_view bytes, std::string_view name) {
  ByteReader in(bytes);
  const auto count = in.next<std::uint64_t>();
  if (!count) return cut_off(name, "the number of cameras");
  Models models;
  for (std::uint64_t i = 0; i < *count; ++i) {
    const auto id = in.next<std::uint32_t>();
    if (!id) return cut_off(name, text("camera ", i + 1, " of ", *count));
    const std::string who = text("camera ", *id);
    const Result<CameraModel> model = next_model(in, who, name);
    if (!model) return forward(model);
    if (!models.emplace(*id, *model).second)
      return fail(ErrorCode::BadData, text(name, ": ", who, " is here a second time"));
  }
  if (in.remaining() > 0)
    return fail(ErrorCode::BadData, text(name, ": ", in.remaining(), " bytes follow the last camera"));
  if (models.empty()) return fail(ErrorCode::BadData, text(name, ": there is no camera in this file"));
  return models;
}

struct Image {
  std::string name;
  std::uint32_t camera = 0;
  Rigid3 cam_from_world;
};

Result<Image> next_image(ByteReader& in, const std::string& which, std::string_view name) {
  if (!in.next<std::uint32_t>()) return cut_off(name, which);
  std::array<double, 7> v{};
  for (double& value : v) {
    const auto read = in.next<double>();
    if (!read) return cut_off(name, which);
    if (!std::isfinite(*read))
      return fail(ErrorCode::BadData, text(name, ": ", which, ": a number of its pose is not finite"));
    value = *read;
  }
  const auto camera = in.next<std::uint32_t>();
  const std::optional<std::string> image = camera ? in.next_name() : std::nullopt;
  const auto points = image ? in.next<std::uint64_t>() : std::nullopt;
  if (!points || *points > in.remaining() / kObservation || !in.skip(*points * kObservation))
    return cut_off(name, which);
  const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
  if (!(std::abs(q.norm() - 1) <= kLargestQuaternionError))
    return fail(ErrorCode::BadData,
                text(name, ": image '", *image, "': the quaternion has length ", q.norm(), " instead of 1"));
  if (image->empty()) return fail(ErrorCode::BadData, text(name, ": ", which, " has no name"));
  return Image{*image, *camera, {q.normalized(), {v[4], v[5], v[6]}}};
}

}  // namespace

Result<ForeignRig> parse_colmap_binary(std::string_view cameras, std::string_view images,
                                       std::string_view cameras_name, std::string_view images_name) {
  const Result<Models> models = models_of(cameras, cameras_name);
  if (!models) return forward(models);
  ByteReader in(images);
  const auto count = in.next<std::uint64_t>();
  if (!count) return cut_off(images_name, "the number of images");
  ForeignRig foreign;
  for (std::uint64_t i = 0; i < *count; ++i) {
    Result<Image> image = next_image(in, text("image ", i + 1, " of ", *count), images_name);
    if (!image) return forward(image);
    const auto model = models->find(image->camera);
    if (model == models->end())
      return fail(ErrorCode::BadData, text(images_name, ": image '", image->name, "' names camera ",
                                           image->camera, ", which ", cameras_name, " does not have"));
    foreign.rig.cameras.push_back({serial_from_name(image->name), model->second, image->cam_from_world, {}});
    foreign.image_names.push_back(std::move(image->name));
  }
  if (in.remaining() > 0)
    return fail(ErrorCode::BadData, text(images_name, ": ", in.remaining(), " bytes follow the last image"));
  return checked(std::move(foreign), images_name);
}

}  // namespace floatstage::calib
