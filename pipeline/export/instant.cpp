#include "pipeline/export/instant.h"

#include <algorithm>
#include <set>

#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/undistort.h"

namespace floatstage::pipeline {
namespace {

void recolor(Image& rgb, const ColorTransform& color) {
  if (color.is_identity()) return;
  const ColorTable table(color);
  for (std::size_t i = 0; i < rgb.pixels.size(); i += 3) table.apply(&rgb.pixels[i], &rgb.pixels[i]);
}

Result<void> check_serials(const Rig& rig, const std::vector<std::string>& serials) {
  for (const std::string& serial : serials)
    if (camera_index(rig, serial) < 0)
      return fail(ErrorCode::InvalidArgument, text("the take has no camera '", serial, "'"));
  return {};
}

}  // namespace

Result<StraightInstant> load_straight_instant(capture::TakeReader& take, SceneLoader& loader, int frame,
                                              const std::vector<std::string>& serials) {
  if (Result<void> ok = check_serials(take.rig(), serials); !ok) return forward(ok);
  const Result<Rig> rig = rig_with_colors(take);
  if (!rig) return forward(rig);
  Result<SceneFrame> scene = loader.load(frame);
  if (!scene) return forward(scene);
  const std::set<std::string> wanted(serials.begin(), serials.end());
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < rig->cameras.size(); ++i)
    if (!scene->images.frames[i].empty() && (wanted.empty() || wanted.contains(rig->cameras[i].serial)))
      used.push_back(i);
  if (used.empty())
    return fail(ErrorCode::NotFound, text("no camera has a picture of frame ", frame, " of ",
                                          take.layout().folder().string(), "; name others with --frames"));
  StraightInstant instant;
  instant.mesh = std::move(scene->mesh);
  instant.rig.cameras.resize(used.size());
  instant.pictures.resize(used.size());
  instant.mattes.resize(used.size());
  std::vector<Result<void>> done(used.size());
  parallel_for(used.size(), 0, [&](std::size_t i) {
    const RigCamera& from = rig->cameras[used[i]];
    RigCamera& to = instant.rig.cameras[i];
    to = {from.serial, straight(from.model), from.cam_from_world, {}};
    Result<Image> rgb = to_rgb(scene->images.frames[used[i]]);
    if (!rgb) {
      done[i] = fail(rgb.error().code, text("camera '", from.serial, "': ", rgb.error().message));
      return;
    }
    recolor(*rgb, from.color);
    instant.pictures[i] = retaken(*rgb, from.model, to.model);
    if (const Matte& matte = scene->mattes[used[i]]; !matte.empty())
      instant.mattes[i] = retaken(to_image(matte), from.model, to.model);
  });
  for (const Result<void>& ok : done)
    if (!ok) return forward(ok);
  return instant;
}

}  // namespace floatstage::pipeline
