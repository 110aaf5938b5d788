#include "pipeline/matte/camera_key.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <mutex>
#include <optional>

#include "capture/added_file.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/guided_upsample.h"
#include "matting/video/segment_clip.h"
#include "pipeline/camera_still.h"
#include "pipeline/import/matte_files.h"
#include "pipeline/keying.h"
#include "pipeline/matte/affected_frames.h"
#include "pipeline/matte/camera_plate.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/matte/plate_correction.h"
#include "pipeline/matte/quick_keyer.h"
#include "pipeline/matte/take_clip.h"
#include "pipeline/take_plates.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kMostSubject = 0.6;  // of a picture that was taken before cloth

bool clicked(const CameraEdits& edits) { return !seed_of(edits).strokes.empty(); }

bool in_colour(const std::vector<Image>& pictures) {
  return std::all_of(pictures.begin(), pictures.end(), [](const Image& p) { return p.channels == 3; });
}

// What of a picture is cloth.
enum class Cloth {
  Backdrop,
  AMat,    // on the floor: most of the picture would be subject, which is no studio
  Hardly,  // too little to key by: the keyer refuses
};

Result<Cloth> cloth_in(capture::TakeReader& take, int camera, const CameraKey& key) {
  for (int frame = 0; frame < take.frame_count(); ++frame) {
    Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) continue;
    Result<Image> matte = key.key(*photograph, frame);
    if (!matte && matte.error().code == ErrorCode::Unsupported) return Cloth::Hardly;
    if (!matte) return forward(matte);
    return coverage(make_matte({}, *matte)) <= kMostSubject ? Cloth::Backdrop : Cloth::AMat;
  }
  return Cloth::Backdrop;
}

// K of "plate:K".
Result<std::optional<double>> parameter_of(const std::string& how) {
  std::optional<double> k;
  if (how.find(':') == std::string::npos) return k;
  const std::string digits = how.substr(how.find(':') + 1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !(value > 0))
    return fail(ErrorCode::InvalidArgument,
                text("'", how, "': K is a number of standard deviations, as in plate:6"));
  k = value;
  return k;
}

// Somebody's matte of a photograph.
Result<Image> matte_in(const fs::path& file, const Frame& photograph) {
  Result<Image> picture = load_png(file);
  if (!picture) return forward(picture);
  Result<Image> matte = matte_from_picture(*picture);
  if (!matte) return fail(matte.error().code, text(file.string(), " ", matte.error().message));
  if (matte->width != photograph.layout.width || matte->height != photograph.layout.height)
    return fail(ErrorCode::BadData,
                text(file.string(), " is ", matte->width, "x", matte->height, " but the photograph is ",
                     photograph.layout.width, "x", photograph.layout.height));
  return matte;
}

}  // namespace

// Small mattes by frame, made by whoever asks first while the others wait.
struct CameraKey::Cut {
  std::function<Result<std::vector<Image>>()> make;
  std::mutex mutex = {};
  std::optional<Result<std::vector<Image>>> mattes = {};

  const Result<std::vector<Image>>& get() {
    std::lock_guard lock(mutex);
    if (!mattes) mattes.emplace(make());
    return *mattes;
  }
};

CameraKey CameraKey::none(const std::string& reason) {
  CameraKey key;
  key.reason_ = reason;
  key.spec_ = "none";
  return key;
}

Result<CameraKey> CameraKey::guided(const capture::TakeReader& take, int camera, const fs::path& guide) {
  CameraKey key;
  key.kind_ = Kind::Guide;
  key.spec_ = "guide";
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  key.guide_ = guide / serial;
  if (!is_folder(key.guide_))
    return fail(ErrorCode::NotFound,
                text(guide.string(), " has no folder '", serial, "' with mattes of that camera"));
  return key;
}

Result<CameraKey> CameraKey::keyed(capture::TakeReader& take, int camera, const std::string& spec) {
  Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, camera, spec);
  if (!keyer) return forward(keyer);
  Result<std::shared_ptr<const PlateCorrection>> correction = PlateCorrection::of(take, camera, **keyer);
  if (!correction) return forward(correction);
  CameraKey key;
  key.kind_ = Kind::Keyer;
  key.correction_ = *std::move(correction);
  key.spec_ = (*keyer)->spec();
  key.keyer_ = std::make_shared<QuickKeyer>(std::move(*keyer));
  return key;
}

Result<CameraKey> CameraKey::plate(capture::TakeReader& take, int camera, std::optional<double> deviations) {
  Result<std::vector<Image>> shot = plates_of(take, camera);
  if (!shot) return forward(shot);
  if (!in_colour(*shot))
    return fail(ErrorCode::BadData,
                text(plate_files(take, camera).front().string(),
                     " is not an RGB picture; a plate is a photograph of the empty stage in colour"));
  Result<CameraPlate> plate = plate_of(take, camera, *shot, deviations);
  if (!plate) return forward(plate);
  CameraKey key;
  key.kind_ = Kind::Plate;
  key.spec_ = plate->keyer->spec();
  key.plate_ = std::make_shared<matting::Plate>(std::move(plate->plate));
  key.keyer_ = std::make_shared<QuickKeyer>(std::move(plate->keyer));
  key.unseen_ = plate->unseen;
  key.found_ = shot->empty();
  return key;
}

Result<CameraKey> CameraKey::cut(capture::TakeReader& take, int camera, const CameraEdits& edits,
                                 const std::function<bool()>& go_on) {
  const CameraModel& model = take.rig().cameras[static_cast<std::size_t>(camera)].model;
  std::map<int, matting::MatteConstraint> strokes;
  if (const MatteKeyframe seed = seed_of(edits); !seed.strokes.empty())
    strokes[seed.frame] = opinion_of(seed, model.width, model.height);
  const auto make = [&take, camera, strokes, go_on]() -> Result<std::vector<Image>> {
    Result<std::vector<Image>> mattes =
        matting::segment_clip(clip_of(take, camera), strokes, {}, [&](int, int) { return go_on(); });
    if (!mattes)
      return fail(mattes.error().code,
                  text("camera '", take.rig().cameras[static_cast<std::size_t>(camera)].serial,
                       "': ", mattes.error().message));
    return mattes;
  };
  CameraKey key;
  key.kind_ = Kind::Cut;
  key.uses_strokes_ = true;
  key.spec_ = "cut";
  key.cut_ = std::make_shared<Cut>();
  key.cut_->make = make;
  return key;
}

Result<CameraKey> CameraKey::best(capture::TakeReader& take, int camera, const fs::path& guide,
                                  const CameraEdits& edits, const std::function<bool()>& go_on) {
  if (!guide.empty()) return guided(take, camera, guide);
  Result<CameraKey> by_chroma = keyed(take, camera, "chroma");
  if (!by_chroma && by_chroma.error().code != ErrorCode::NotFound) return by_chroma;
  Result<Cloth> cloth = by_chroma ? cloth_in(take, camera, *by_chroma) : Cloth::Hardly;
  if (!cloth) return forward(cloth);
  if (*cloth == Cloth::Backdrop) return by_chroma;
  const bool shot = !plate_files(take, camera).empty();
  if (clicked(edits) && !shot) {
    if (Result<void> ok = check_camera_still(take, camera); !ok) return forward(ok);
    return cut(take, camera, edits, go_on);
  }
  Result<CameraKey> key = plate(take, camera);
  if (!key && *cloth == Cloth::AMat) {
    by_chroma->reason_ = key.error().message;
    key = std::move(by_chroma);
  }
  if (key) key->uses_strokes_ = !shot;
  return key;
}

Result<CameraKey> CameraKey::for_how(capture::TakeReader& take, int camera, const std::string& how,
                                     const fs::path& guide, const CameraEdits& edits,
                                     const std::function<bool()>& go_on) {
  Result<CameraKey> key = without_given(take, camera, how, guide, edits, go_on);
  const fs::path given =
      take.layout().given_mattes(take.rig().cameras[static_cast<std::size_t>(camera)].serial);
  if (key && is_folder(given)) key->given_ = given;
  return key;
}

Result<CameraKey> CameraKey::without_given(capture::TakeReader& take, int camera, const std::string& how,
                                           const fs::path& guide, const CameraEdits& edits,
                                           const std::function<bool()>& go_on) {
  if (how == "given") return guided(take, camera, guide.empty() ? take.layout().given_mattes("") : guide);
  if (method_name(how) == "plate") {
    const Result<std::optional<double>> deviations = parameter_of(how);
    if (!deviations) return forward(deviations);
    return plate(take, camera, *deviations);
  }
  if (is_keyer(how)) return keyed(take, camera, how);
  Result<CameraKey> key = best(take, camera, guide, edits, go_on);
  // Spectral matting needs no key, and is what is left to auto where there is none.
  const bool optional =
      guide.empty() && !key &&
      ((how == "spectral" && key.error().code == ErrorCode::NotFound) ||
       ((how == "spectral" || how == "auto") && key.error().code == ErrorCode::Unsupported));
  if (optional) {
    key = none(key.error().message);
    key->uses_strokes_ = true;
  }
  return key;
}

Result<void> CameraKey::ready() const {
  if (kind_ != Kind::Cut) return {};
  const Result<std::vector<Image>>& mattes = cut_->get();
  return mattes ? Result<void>() : Result<void>(forward(mattes));
}

Result<Image> CameraKey::key(const Frame& photograph, int frame) const {
  const fs::path name = TakeLayout("").matte("", frame).filename();
  if (!given_.empty() && is_there(given_ / name)) return matte_in(given_ / name, photograph);
  if (kind_ == Kind::None) return Image();
  if (kind_ == Kind::Cut) {
    Result<Image> rgb = to_rgb(photograph);
    if (!rgb) return rgb;
    const Result<std::vector<Image>>& mattes = cut_->get();
    if (!mattes) return forward(mattes);
    return matting::guided_upsample(mattes->at(static_cast<std::size_t>(frame)), *rgb);
  }
  if (keyer_) {
    Result<Matte> matte = keyer_->key(photograph);
    if (!matte) return forward(matte);
    return correction_ ? correction_->correct(photograph, to_image(*matte)) : to_image(*matte);
  }
  if (!is_there(guide_ / name)) return Image();
  return matte_in(guide_ / name, photograph);
}

}  // namespace floatstage::pipeline
