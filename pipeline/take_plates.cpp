#include "pipeline/take_plates.h"

#include <string>

#include "capture/added_file.h"
#include "capture/plates.h"

namespace floatstage::pipeline {

std::vector<std::filesystem::path> plate_files(const capture::TakeReader& take, int camera) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  return capture::plate_files(take.layout().plate(serial).parent_path(), serial);
}

Result<std::vector<Image>> plates_of(const capture::TakeReader& take, int camera, std::size_t most) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  const Result<capture::AddedFile> added = capture::load_added(take.layout());
  if (!added) return forward(added);
  Result<std::vector<Image>> plates =
      capture::load_plates(take.layout().plate(serial).parent_path(), serial, most);
  if (!plates) return plates;
  for (Image& plate : *plates) plate = without(added->of(serial), std::move(plate));
  return plates;
}

}  // namespace floatstage::pipeline
