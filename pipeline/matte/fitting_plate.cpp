#include "pipeline/matte/fitting_plate.h"

#include <algorithm>
#include <vector>

#include "core/log.h"
#include "core/text.h"
#include "pipeline/matte/camera_plate.h"
#include "pipeline/take_plates.h"

namespace floatstage::pipeline {
namespace {

constexpr int kAsked = 4;             // photographs, spread over the take
constexpr double kMostChanged = 0.5;  // of a picture: nobody fills more, other light does

double changed_share(const matting::Plate& plate, const Image& picture) {
  const Image classes = matting::classify(plate, picture);
  const auto changed = std::count_if(classes.pixels.begin(), classes.pixels.end(), [](int c) {
    return c == static_cast<int>(matting::PlateClass::Subject);
  });
  return static_cast<double>(changed) / static_cast<double>(classes.pixels.size());
}

}  // namespace

Result<bool> most_photographs_pass(
    capture::TakeReader& take, int camera,
    const std::function<std::optional<bool>(const Frame& photograph, const Image& rgb)>& passes) {
  int asked = 0, passing = 0;
  const int step = std::max(1, take.frame_count() / kAsked);
  for (int frame = 0; frame < take.frame_count() && asked < kAsked; frame += step) {
    const Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) continue;
    const Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) return forward(rgb);
    const std::optional<bool> one = passes(*photograph, *rgb);
    asked += one.has_value();
    passing += one.value_or(false);
  }
  return 2 * passing >= asked;
}

Result<bool> shows_the_stage(capture::TakeReader& take, int camera, const matting::Plate& plate) {
  return most_photographs_pass(take, camera, [&](const Frame&, const Image& rgb) {
    return rgb.width == plate.color.width && rgb.height == plate.color.height &&
           changed_share(plate, rgb) <= kMostChanged;
  });
}

Result<matting::Plate> fitting_plate(capture::TakeReader& take, int camera) {
  const Result<std::vector<Image>> shot = plates_of(take, camera);
  if (!shot) return forward(shot);
  const bool in_colour =
      std::all_of(shot->begin(), shot->end(), [](const Image& p) { return p.channels == 3; });
  if (shot->empty() || !in_colour) return matting::Plate();
  Result<CameraPlate> plate = plate_of(take, camera, *shot, std::nullopt);
  if (!plate && plate.error().code == ErrorCode::Unsupported) {
    log::warning(text(plate.error().message, "; its mattes go without its plate"));  // it names the camera
    return matting::Plate();
  }
  if (!plate) return forward(plate);
  const Result<bool> fits = shows_the_stage(take, camera, plate->plate);
  if (!fits) return forward(fits);
  if (!*fits) {
    log::warning(text("camera '", take.rig().cameras[static_cast<std::size_t>(camera)].serial,
                      "': ", kPlateDoesNotFit,
                      ", so that its mattes go without it; shoot another plate, or take it "
                      "away"));
    return matting::Plate();
  }
  return std::move(plate->plate);
}

}  // namespace floatstage::pipeline
