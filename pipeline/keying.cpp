#include "pipeline/keying.h"

#include "capture/added_file.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/camera_still.h"

namespace floatstage::pipeline {

Result<std::unique_ptr<matting::Keyer>> keyer_for(capture::TakeReader& take, int camera,
                                                  const std::string& spec) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  std::vector<Image> samples;
  const std::filesystem::path plate = take.layout().plate(serial);
  // How far black cloth is lit shows beside the subject: an empty stage has nothing brighter to tell it from.
  const bool of_photographs = spec.starts_with("luminance");
  if (is_there(plate) && !of_photographs) {
    Result<Image> picture = load_png(plate);
    if (!picture) return forward(picture);
    const Result<capture::AddedFile> added = capture::load_added(take.layout());
    if (!added) return forward(added);
    samples.push_back(without(added->of(serial), std::move(*picture)));
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
  if (spec.starts_with("difference") && samples.size() < kFewest && !is_there(plate))
    return fail(ErrorCode::NotFound,
                text("camera '", serial, "': there is no plate ", plate.string(), " and only ",
                     samples.size(), " photographs to make one of; shoot a plate, or key otherwise"));
  if (spec.starts_with("difference") && !is_there(plate))
    if (Result<void> ok = check_camera_still(take, camera); !ok) return forward(ok);
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_keyer(spec, samples);
  if (!keyer) return fail(keyer.error().code, text("camera '", serial, "': ", keyer.error().message));
  return keyer;
}

}  // namespace floatstage::pipeline
