#include "pipeline/matte/plate_correction.h"

#include <algorithm>
#include <optional>
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

bool by_colour(const matting::Keyer& keyer) {
  const std::string word = method_name(keyer.spec());
  return word == "chroma" || word == "luminance";
}

bool in_colour(const std::vector<Image>& pictures) {
  return std::all_of(pictures.begin(), pictures.end(), [](const Image& p) { return p.channels == 3; });
}

// Whether the plate shows the place of most of some photographs, in which most of the fixtures show, too.
Result<bool> fits_photographs(capture::TakeReader& take, int camera, const matting::EmptyStage& stage,
                              const matting::Keyer& keyer) {
  constexpr double kShown = 0.5;  // of fixtures: a majority, whoever stands before some
  return most_photographs_pass(take, camera, [&](const Frame& photograph, const Image& rgb) {
    const Result<Matte> key = keyer.key(photograph);
    if (!key) return std::optional<bool>();  // the photograph's own failure, which is said where it is keyed
    Image alpha = to_image(*key);
    return std::optional(stage.take_out_fixtures(rgb, alpha) &&
                         matting::EmptyStage::fits(stage.solid(rgb), alpha) &&
                         stage.fixtures_shown(rgb) >= kShown);
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
  std::optional<matting::EmptyStage> stage = matting::EmptyStage::seen_by(keyer, plate->plate);
  if (!stage) return none;  // the photographs will tell what the stage lacks
  const Result<bool> fitting = fits_photographs(take, camera, *stage, keyer);
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
  return std::shared_ptr<const PlateCorrection>(new PlateCorrection(std::move(*stage)));
}

Result<Image> PlateCorrection::correct(const Frame& photograph, Image key) const {
  if (key.empty()) return key;
  const Result<Image> rgb = to_rgb(photograph);
  if (!rgb) return rgb;
  if (!stage_.take_out_fixtures(*rgb, key)) return key;
  Image solid = stage_.solid(*rgb);
  if (!matting::EmptyStage::fits(solid, key)) return key;
  solid = matting::EmptyStage::touching(solid, key);
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
