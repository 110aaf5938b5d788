#include "pipeline/export/export_light_field.h"

#include <cstdio>

#include "calib/colmap_model.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/export/transforms_json.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

constexpr int kMostAlong = 99;    // rows, columns
constexpr double kSensor = 36;    // mm: of a full frame, only its share of the focal length counts
constexpr double kMetres = 1e-3;  // a millimetre

// A view of the grid: where it stands, from the middle, in metres to the right and down.
struct Place {
  int row, column;
  double right, down;
};

std::vector<Place> places_of(const ExportLightFieldOptions& o) {
  std::vector<Place> places;
  for (int row = 0; row < o.rows; ++row)
    for (int column = 0; column < o.columns; ++column)
      places.push_back({row, column, (column - 0.5 * (o.columns - 1)) * o.baseline,
                        (row - 0.5 * (o.rows - 1)) * o.baseline});
  return places;
}

// A key a view, a second each: a film of one picture a second stands at each of them.
CameraPath path_of(const PathKey& middle, const std::vector<Place>& places) {
  const Eigen::Matrix3d axes = look_at(middle.eye, middle.target, middle.up).rotation.toRotationMatrix();
  CameraPath path;
  for (const Place& place : places) {
    PathKey key;
    const Eigen::Vector3d moved = axes.row(0) * place.right + axes.row(1) * place.down;
    key.time = static_cast<double>(path.keys.size());
    key.eye = middle.eye + moved, key.target = middle.target + moved;
    key.up = middle.up, key.fov_y = middle.fov_y;
    path.keys.push_back(key);
  }
  path.keys.push_back(path.keys.back());
  path.keys.back().time += 1;
  return path;
}

std::string name_of(const Place& place, const CameraModel& model) {
  char name[160] = "";
  std::snprintf(name, sizeof name, "view_%02d_%02d_%.6f_%.6f_%.12g_%g", place.row, place.column,
                place.down / kMetres, place.right / kMetres, model.fx / model.width * kSensor, kSensor);
  return name;
}

Result<void> check(const ExportLightFieldOptions& o) {
  if (o.rows < 2 || o.columns < 2 || o.rows > kMostAlong || o.columns > kMostAlong || !(o.baseline > 0))
    return fail(ErrorCode::InvalidArgument, text("a light field has 2 to ", kMostAlong,
                                                 " rows and columns, a positive number of metres apart"));
  if (o.film.frames.size() != 1 || o.film.methods.size() != 1 || o.film.array.views != 1)
    return fail(ErrorCode::InvalidArgument, "a light field is of one frame, one method and one eye a view");
  return {};
}

}  // namespace

Result<ExportLightFieldReport> export_light_field(const ExportLightFieldOptions& options) {
  if (Result<void> ok = check(options); !ok) return forward(ok);
  const Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  Result<UnfinishedFolder> out = UnfinishedFolder::begin(options.out);
  if (!out) return forward(out);
  if (Result<void> ok = make_folder(out->folder() / "views"); !ok) return forward(ok);
  const std::vector<Place> places = places_of(options);
  FilmOptions film = options.film;
  film.frame_rate = 1;
  film.seconds = static_cast<double>(places.size());
  Rig rig;
  std::vector<std::string> names;
  PicturePaths paths;
  const Result<FilmReport> drawn = render_film(
      **take, path_of(options.middle, places), film, [&](const FilmPicture& picture) -> Result<void> {
        const Place& place = places[static_cast<std::size_t>(picture.index)];
        const std::string name = name_of(place, picture.view.model);
        char serial[24] = "";
        std::snprintf(serial, sizeof serial, "view_%02d_%02d", place.row, place.column);
        rig.cameras.push_back({serial, picture.view.model, picture.view.view_from_world, {}});
        names.push_back(name + ".png");
        paths.pictures.push_back("views/" + name + ".png");
        paths.mattes.emplace_back();
        return save_png(over(picture.renders.front(), film.renderer.background),
                        out->folder() / paths.pictures.back());
      });
  if (!drawn) return forward(drawn);
  if (Result<void> ok = calib::write_colmap_model(rig, names, {}, out->folder() / "sparse" / "0"); !ok)
    return forward(ok);
  if (Result<void> ok = write_file(out->folder() / "transforms.json", transforms_json(rig, paths)); !ok)
    return forward(ok);
  if (Result<void> ok = out->publish(); !ok) return forward(ok);
  return ExportLightFieldReport{drawn->pictures, drawn->seconds};
}

}  // namespace floatstage::pipeline
