#include "pipeline/matte/camera_plate.h"

#include <algorithm>

#include "core/text.h"
#include "pipeline/camera_still.h"

namespace floatstage::pipeline {
namespace {

constexpr int kPhotographs = 48;
constexpr int kWithAPlate = 4;   // photographs that are compared with a plate that was shot
constexpr int kPlateRounds = 3;  // how often a plate is learnt again without what the last one keys
constexpr double kStillShare =
    0.55;                       // of the pixels must show one thing most of the time, or the camera moved
constexpr int kAgree = 128;     // Plate::confidence from which a pixel does
constexpr int kFewestSeen = 3;  // photographs that show a place without the subject: two agree by chance
constexpr std::size_t kMostBytes = 400u << 20;  // of photographs held at once to learn a plate

struct Photographs {
  std::vector<Image> pictures;
  std::vector<std::string> names;
};

// Spread over the take.
Result<Photographs> photographs_of(capture::TakeReader& take, int camera, int wanted) {
  const CameraModel& model = take.rig().cameras[static_cast<std::size_t>(camera)].model;
  const std::size_t bytes =
      static_cast<std::size_t>(model.width) * static_cast<std::size_t>(model.height) * 3;
  const int room = std::max(5, static_cast<int>(kMostBytes / std::max<std::size_t>(bytes, 1)));
  const int count = take.frame_count(),
            step = std::max(1, (count + std::min(wanted, room) - 1) / std::min(wanted, room));
  Photographs all;
  for (int frame = 0; frame < count; frame += step) {
    Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) continue;
    Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) return forward(rgb);
    all.pictures.push_back(std::move(*rgb));
    all.names.push_back(text("frame ", frame));
  }
  return all;
}

// Of the subject in the pictures, the share that stands where the plate is unknown.
double unseen_share(const matting::Plate& plate, const std::vector<Image>& subjects) {
  std::size_t all = 0, unknown = 0;
  for (const Image& subject : subjects)
    for (std::size_t p = 0; p < subject.pixels.size(); ++p)
      if (subject.pixels[p] >= 128) ++all, unknown += plate.confidence.pixels[p] == 0;
  return all ? static_cast<double>(unknown) / static_cast<double>(all) : 0;
}

Result<std::vector<Image>> keyed(const matting::Keyer& keyer, const std::vector<Image>& pictures) {
  std::vector<Image> subjects;
  for (const Image& picture : pictures) {
    Result<Matte> matte = keyer.key(make_frame({}, picture));
    if (!matte) return forward(matte);
    subjects.push_back(to_image(*matte));
  }
  return subjects;
}

// What a plate takes for subject is left out of the next.
Result<CameraPlate> find_plate(const std::string& serial, const Photographs& seen,
                               const matting::PlateKeyOptions& options) {
  if (Result<void> ok = check_still(serial, seen.pictures, seen.names); !ok) return forward(ok);
  CameraPlate found;
  std::vector<Image> subjects;
  for (int round = 0; round <= kPlateRounds; ++round) {
    Result<matting::Plate> plate = matting::learn_plate(seen.pictures, {.fewest = kFewestSeen}, subjects);
    if (!plate) return fail(plate.error().code, text("camera '", serial, "': ", plate.error().message));
    const auto still = std::count_if(plate->confidence.pixels.begin(), plate->confidence.pixels.end(),
                                     [](int c) { return c >= kAgree; });
    if (round == 0 &&
        (seen.pictures.size() < 3 ||
         static_cast<double>(still) < kStillShare * static_cast<double>(plate->confidence.pixels.size())))
      return fail(
          ErrorCode::Unsupported,
          text("camera '", serial, "': no plate was shot, and its ", seen.pictures.size(),
               " photographs show no backdrop that stands still; shoot a plate or give mattes with --guide"));
    Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_plate_keyer(
        *plate, options, matting::plate_clean_up(plate->color.width, plate->color.height, true));
    if (!keyer) return forward(keyer);
    Result<std::vector<Image>> now = keyed(**keyer, seen.pictures);
    if (!now) return forward(now);
    subjects = std::move(*now);
    found = {std::move(*plate), std::move(*keyer), 0};
  }
  found.unseen = unseen_share(found.plate, subjects);
  return found;
}

}  // namespace

Result<CameraPlate> plate_of(capture::TakeReader& take, int camera, const std::vector<Image>& shot,
                             std::optional<double> deviations) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  matting::PlateKeyOptions options = matting::before_clutter();
  if (deviations) options.sigmas = *deviations;
  Result<Photographs> seen = photographs_of(take, camera, shot.empty() ? kPhotographs : kWithAPlate);
  if (!seen) return forward(seen);
  if (shot.empty()) return find_plate(serial, *seen, options);
  seen->pictures.insert(seen->pictures.begin(), shot.front());
  seen->names.insert(seen->names.begin(), "its plate");
  if (Result<void> ok = check_still(serial, seen->pictures, seen->names); !ok) return forward(ok);
  Result<matting::Plate> plate = matting::learn_plate(shot);
  if (!plate) return fail(plate.error().code, text("camera '", serial, "': ", plate.error().message));
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_plate_keyer(*plate, options);
  if (!keyer) return forward(keyer);
  return CameraPlate{std::move(*plate), std::move(*keyer), 0};
}

}  // namespace floatstage::pipeline
