#include "pipeline/reproduce/light_field_scene.h"

#include <span>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/light_field.h"
#include "render/camera_grid.h"

namespace floatstage::pipeline {
namespace {

constexpr int kBorderShare = 12;  // of the width, as evaluate has it

Result<Image> load_picture(const std::filesystem::path& file, const CameraModel& model) {
  if (file.extension() == ".png") return load_png(file);
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  Result<Image> image = decode_jpeg(std::as_bytes(std::span(*bytes)), model.width, model.height);
  return image ? std::move(image)
               : fail(image.error().code, text(file.string(), ": ", image.error().message));
}

}  // namespace

Result<LightField> load_light_field(const std::filesystem::path& folder) {
  const Result<calib::ForeignRig> read = calib::read_rig({.format = "lightfield", .path = folder});
  if (!read) return forward(read);
  LightField field{read->rig, std::vector<Image>(read->rig.cameras.size()), {}};
  std::vector<Result<void>> loaded(field.pictures.size());
  parallel_for(field.pictures.size(), 0, [&](std::size_t i) {
    Result<Image> picture = load_picture(read->pictures / read->image_names[i], field.rig.cameras[i].model);
    if (picture)
      field.pictures[i] = std::move(*picture);
    else
      loaded[i] = forward(picture);
  });
  for (const Result<void>& ok : loaded)
    if (!ok) return forward(ok);
  const Result<double> distance = plane_of_pictures(field.rig, field.pictures);
  if (!distance) return forward(distance);
  Result<Mesh> plane = plane_before(field.rig, *distance);
  if (!plane) return forward(plane);
  field.plane = std::move(*plane);
  return field;
}

Result<TestScene> thinned(const LightField& field, int step) {
  const Result<render::CameraGrid> grid = render::camera_grid(field.rig.cameras);
  if (!grid) return forward(grid);
  TestScene scene;
  scene.photographs.mesh = field.plane;
  // In the middle between inputs that are `step` rows or columns apart.
  auto between = [&](int place, int count) {
    return step > 1 && place % step == step / 2 && place < (count - 1) / step * step;
  };
  for (int row = 0; row < grid->rows; ++row)
    for (int column = 0; column < grid->columns; ++column) {
      const auto i =
          static_cast<std::size_t>(grid->cameras[static_cast<std::size_t>(row * grid->columns + column)]);
      const RigCamera& camera = field.rig.cameras[i];
      if (row % step == 0 && column % step == 0) {
        FrameInfo info;
        info.camera = static_cast<int>(scene.rig.cameras.size());
        scene.rig.cameras.push_back(camera);
        scene.photographs.images.frames.push_back(make_frame(info, field.pictures[i]));
        scene.photographs.mattes.emplace_back();
      } else if (between(row, grid->rows) && between(column, grid->columns)) {
        scene.views.push_back({camera, field.pictures[i], {}});
      }
    }
  if (scene.views.empty())
    return fail(ErrorCode::InvalidArgument,
                text("a light field of ", grid->rows, " by ", grid->columns,
                     " pictures has none in the middle between every ", step, "-th; take a larger one"));
  scene.border = field.rig.cameras.front().model.width / kBorderShare;
  return scene;
}

}  // namespace floatstage::pipeline
