#include "pipeline/keying.h"

#include "core/text.h"
#include "pipeline/camera_still.h"
#include "pipeline/take_plates.h"

namespace floatstage::pipeline {

Result<std::unique_ptr<matting::Keyer>> keyer_for(capture::TakeReader& take, int camera,
                                                  const std::string& spec) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  std::vector<Image> samples;
  constexpr std::size_t kPlates = 3;  // an empty stage looks the same on all
  const bool shot = !plate_files(take, camera).empty();
  // How far black cloth is lit shows beside the subject: an empty stage has nothing brighter to tell it from.
  const bool of_photographs = spec.starts_with("luminance");
  if (shot && !of_photographs) {
    Result<std::vector<Image>> plates = plates_of(take, camera, kPlates);
    if (!plates) return forward(plates);
    samples = *std::move(plates);
  } else {
    constexpr int kPhotographs =
        3;  // spread over the take: the cloth's colour does not change, the performer moves
    const int count = take.frame_count(), wanted = std::min(kPhotographs, count);
    for (int i = 0; i < wanted; ++i) {
      Result<Frame> frame = take.frame(camera, static_cast<int>(static_cast<long>(count) * i / wanted));
      if (!frame) return forward(frame);
      if (frame->empty()) continue;
      Result<Image> picture = to_rgb(*frame);
      if (!picture) return forward(picture);
      samples.push_back(std::move(*picture));
    }
  }
  // The median of two photographs is no plate: the subject would be taken for its own backing.
  constexpr std::size_t kFewest = 3;
  if (spec.starts_with("difference") && samples.size() < kFewest && !shot)
    return fail(ErrorCode::NotFound, text("camera '", serial, "': there is no plate ",
                                          take.layout().plate(serial).string(), " and only ", samples.size(),
                                          " photographs to make one of; shoot a plate, or key otherwise"));
  if (spec.starts_with("difference") && !shot)
    if (Result<void> ok = check_camera_still(take, camera); !ok) return forward(ok);
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_keyer(spec, samples);
  if (!keyer) return fail(keyer.error().code, text("camera '", serial, "': ", keyer.error().message));
  return keyer;
}

}  // namespace floatstage::pipeline
