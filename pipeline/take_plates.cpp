#include "pipeline/take_plates.h"

#include <algorithm>
#include <string>

#include "capture/added_file.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

std::vector<fs::path> plate_files(const capture::TakeReader& take, int camera) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  const fs::path one = take.layout().plate(serial);
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(one.parent_path() / serial, none))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (is_there(one)) files.insert(files.begin(), one);
  return files;
}

Result<std::vector<Image>> plates_of(const capture::TakeReader& take, int camera, std::size_t most) {
  std::vector<Image> plates;
  const Result<capture::AddedFile> added = capture::load_added(take.layout());
  if (!added) return forward(added);
  const AddedContent hidden = added->of(take.rig().cameras[static_cast<std::size_t>(camera)].serial);
  for (const fs::path& file : plate_files(take, camera)) {
    if (plates.size() == most) break;
    Result<Image> plate = load_png(file);
    if (!plate) return forward(plate);
    if (plate->channels != 1 && plate->channels != 3)
      return fail(
          ErrorCode::BadData,
          text(file.string(), " is neither grey nor RGB; a plate is a photograph of the empty stage"));
    plates.push_back(without(hidden, std::move(*plate)));
  }
  return plates;
}

}  // namespace floatstage::pipeline
