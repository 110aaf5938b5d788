#include "capture/plates.h"

#include <algorithm>

#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::capture {

namespace fs = std::filesystem;

std::vector<fs::path> plate_files(const fs::path& folder, const std::string& serial) {
  const fs::path one = folder / (serial + ".png");
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / serial, none))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (is_there(one)) files.insert(files.begin(), one);
  return files;
}

Result<std::vector<Image>> load_plates(const fs::path& folder, const std::string& serial, std::size_t most) {
  std::vector<Image> plates;
  for (const fs::path& file : plate_files(folder, serial)) {
    if (plates.size() == most) break;
    Result<Image> plate = load_png(file);
    if (!plate) return forward(plate);
    if (plate->channels != 1 && plate->channels != 3)
      return fail(
          ErrorCode::BadData,
          text(file.string(), " is neither grey nor RGB; a plate is a photograph of the empty stage"));
    plates.push_back(std::move(*plate));
  }
  return plates;
}

}  // namespace floatstage::capture
