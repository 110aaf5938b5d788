#include "pipeline/matte/plate_correction.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/log.h"
#include "core/text.h"
#include "pipeline/matte/camera_plate.h"
#include "pipeline/matte/corrected_key.h"
#include "pipeline/matte/fitting_plate.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/take_plates.h"

namespace floatstage::pipeline {
namespace {

constexpr matting::CleanupOptions kAsItIs{.smallest_island = 0, .smallest_hole = 0};

bool by_colour(const matting::Keyer& keyer) {
  const std::string word = method_name(keyer.spec());
  return word == "chroma" || word == "luminance";
}

bool in_colour(const std::vector<Image>& pictures) {
  return std::all_of(pictures.begin(), pictures.end(), [](const Image& p) { return p.channels == 3; });
}

// Of `more`, what hangs together with the key's subject: a plate adds to whom the key has found. Cables that
// were laid since, and cloth that was pulled, are nobody's.
Image touching(const Image& more, const Image& key) {
  Image found(key.width, key.height, 1);
  std::vector<std::pair<int, int>> open;
  const auto visit = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= key.width || y >= key.height || *found.at(x, y) != 0 || *more.at(x, y) < 128)
      return;
    *found.at(x, y) = 255;
    open.emplace_back(x, y);
  };
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x)
      if (*key.at(x, y) >= 128) visit(x, y);
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u) visit(u, v);
  }
  return found;
}

// Whether a plate shows the place of a photograph: what it alone takes for subject is no more than what the
// key does. A camera that was moved, or other light, gives it edges and walls everywhere.
bool fits(const Image& solid, const Image& key) {
  std::size_t alone = 0, keyed = 0;
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    keyed += key.pixels[p] >= 128;
    alone += key.pixels[p] < 128 && solid.pixels[p] >= 128;
  }
  return alone <= keyed;
}

// The same of most of some photographs, in which most of the fixtures show, too.
Result<bool> fits_photographs(capture::TakeReader& take, int camera, const matting::EmptyStage& stage,
                              const matting::Keyer& keyer) {
  constexpr double kShown = 0.5;  // of fixtures: a majority, whoever stands before some
  return most_photographs_pass(take, camera, [&](const Frame& photograph, const Image& rgb) {
    const Result<Matte> key = keyer.key(photograph);
    if (!key) return std::optional<bool>();  // the photograph's own failure, which is said where it is keyed
    Image alpha = to_image(*key);
    return std::optional(stage.take_out_fixtures(rgb, keyer.cleanup().smallest_island, alpha) &&
                         fits(stage.solid(rgb), alpha) && stage.fixtures_shown(rgb) >= kShown);
  });
}

}  // namespace

Result<std::shared_ptr<const PlateCorrection>> PlateCorrection::of(capture::TakeReader& take, int camera,
                                                                   const matting::Keyer& keyer) {
  const std::shared_ptr<const PlateCorrection> none;
  if (!by_colour(keyer)) return none;
  const Result<std::vector<Image>> shot = plates_of(take, camera);
  if (!shot) return forward(shot);
  if (shot->empty() || !in_colour(*shot)) return none;
  Result<CameraPlate> plate = plate_of(take, camera, *shot, std::nullopt);
  if (!plate && plate.error().code == ErrorCode::Unsupported) {
    log::warning(text(plate.error().message, "; keys go without its plate"));  // it names the camera
    return none;
  }
  if (!plate) return forward(plate);
  // What the keyer does not clean away of the empty stage it need not clean away beside a subject either.
  const Image& empty = plate->plate.color;
  const Result<std::unique_ptr<matting::Keyer>> raw = matting::make_keyer(keyer.spec(), {empty}, kAsItIs);
  if (!raw) return none;
  const Result<Matte> key = (*raw)->key(make_frame({}, empty));
  if (!key) return none;  // the photographs will tell what the stage lacks
  matting::EmptyStage stage(plate->plate, to_image(*key));
  const Result<bool> fitting = fits_photographs(take, camera, stage, keyer);
  if (!fitting) return forward(fitting);
  if (!*fitting) {
    const Result<bool> right = shows_the_stage(take, camera, plate->plate);
    if (!right) return forward(right);
    const std::string said =
        *right ? "its key and its plate tell different subjects, so that its key goes without the plate; "
                 "--matte plate and --matte consistent go by the plate"
               : text(kPlateDoesNotFit, ", so that keys go without it; shoot another plate, or take it away");
    log::warning(text("camera '", take.rig().cameras[static_cast<std::size_t>(camera)].serial, "': ", said));
    return none;
  }
  return std::shared_ptr<const PlateCorrection>(
      new PlateCorrection(std::move(stage), keyer.cleanup().smallest_island));
}

Result<Image> PlateCorrection::correct(const Frame& photograph, Image key) const {
  if (key.empty()) return key;
  const Result<Image> rgb = to_rgb(photograph);
  if (!rgb) return rgb;
  if (!stage_.take_out_fixtures(*rgb, smallest_island_, key)) return key;
  Image solid = stage_.solid(*rgb);
  if (!fits(solid, key)) return key;
  solid = touching(solid, key);
  // What the key lacks in thick parts: a step of the outline all around, which hangs together with them, is
  // none.
  const Image coarse_key = coarse_cut(key), coarse_solid = coarse_cut(solid);
  Image lacks(coarse_key.width, coarse_key.height, 1);
  for (std::size_t p = 0; p < lacks.pixels.size(); ++p)
    lacks.pixels[p] = coarse_solid.pixels[p] >= 128 && coarse_key.pixels[p] < 128 ? 255 : 0;
  lacks = matting::EmptyStage::not_outlines(lacks, coarse_solid);
  for (std::size_t p = 0; p < lacks.pixels.size(); ++p)
    lacks.pixels[p] = std::max(lacks.pixels[p], coarse_key.pixels[p]);
  Result<Image> corrected = corrected_key(*rgb, key, lacks);
  if (!corrected) return corrected;
  const Image inside = matting::EmptyStage::inside(solid);
  for (std::size_t p = 0; p < inside.pixels.size(); ++p)
    corrected->pixels[p] = std::max(corrected->pixels[p], inside.pixels[p]);
  return corrected;
}

}  // namespace floatstage::pipeline
