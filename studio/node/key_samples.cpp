#include "studio/node/key_samples.h"

#include "capture/plates.h"

namespace floatstage::studio {

Result<matting::KeySamples> empty_stage_of(const std::filesystem::path& plates, const std::string& serial) {
  matting::KeySamples samples;
  if (plates.empty()) return samples;
  Result<std::vector<Image>> shot = capture::load_plates(plates, serial);
  if (!shot) return forward(shot);
  samples.pictures = std::move(*shot);
  samples.empty_stage = !samples.pictures.empty();
  return samples;
}

}  // namespace floatstage::studio
