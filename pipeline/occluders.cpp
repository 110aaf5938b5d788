#include "pipeline/occluders.h"

#include <algorithm>
#include <utility>

#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/made_files.h"
#include "pipeline/mesh_record.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolder = "occluders";

/// 255 where the picture is white, or opaque where it has an opacity.
Result<Image> load_mask(const fs::path& file, const RigCamera& camera) {
  const Result<Image> picture = load_png(file);
  if (!picture) return forward(picture);
  const CameraModel& m = camera.model;
  if (picture->width != m.width || picture->height != m.height)
    return fail(ErrorCode::BadData,
                text(file.string(), " is ", picture->width, "x", picture->height, ", camera '", camera.serial,
                     "' has pictures of ", m.width, "x", m.height, "; draw it over one of them"));
  Image mask(picture->width, picture->height, 1);
  const int channel = picture->channels == 2 || picture->channels == 4 ? picture->channels - 1 : 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) *mask.at(x, y) = picture->at(x, y)[channel] < 128 ? 0 : 255;
  return mask;
}

}  // namespace

fs::path occluder_file(const TakeLayout& take, const std::string& serial) {
  return take.folder() / kFolder / (serial + ".png");
}

Result<Occluders> load_occluders(const TakeLayout& take, const Rig& rig) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(take.folder() / kFolder, none))
    files.push_back(entry.path());
  if (files.empty()) return Occluders();
  std::sort(files.begin(), files.end());
  std::vector<std::string> hashes;
  std::vector<Image> masks(rig.cameras.size());
  for (const fs::path& file : files) {
    const int camera = file.extension() == ".png" ? camera_index(rig, file.stem().string()) : -1;
    if (camera < 0)
      return fail(ErrorCode::BadData,
                  text(file.string(), " is of no camera of this take; name it <serial>.png"));
    const auto c = static_cast<std::size_t>(camera);
    Result<Image> mask = load_mask(file, rig.cameras[c]);
    if (!mask) return forward(mask);
    const Result<std::optional<std::string>> hash = hash_of(file);
    if (!hash) return forward(hash);
    hashes.push_back(text(rig.cameras[c].serial, " ", hash->value_or("")));
    masks[c] = std::move(*mask);
  }
  return Occluders{recon::Props(rig, std::move(masks)), hash_of_parts(hashes)};
}

}  // namespace floatstage::pipeline
