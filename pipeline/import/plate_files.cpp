#include "pipeline/import/plate_files.h"

#include <optional>

#include "core/file.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMost = 16;  // even; of a minute of empty stage, more tell no more of a camera's noise

// Up to kMost of a stream's pictures, evenly spread, however many there are: whenever it is full, every
// second one goes, and from then on half as many come.
Result<std::vector<Image>> spread(PictureStream& stream) {
  std::vector<Image> kept;
  for (std::size_t at = 0, step = 1;; ++at) {
    Result<std::optional<Image>> picture = stream.next();
    if (!picture) return forward(picture);
    if (!*picture) return kept;
    if (at % step != 0) continue;
    if (kept.size() == kMost) {
      for (std::size_t k = 1; k < kMost / 2; ++k) kept[k] = std::move(kept[2 * k]);
      kept.resize(kMost / 2);
      step *= 2;
    }
    kept.push_back(*std::move(*picture));
  }
}

}  // namespace

Result<PlateFiles> PlateFiles::find(const fs::path& folder, const calib::ForeignRig& foreign) {
  Result<MediaSearch> search = find_media(folder, foreign);
  if (!search) return forward(search);
  PlateFiles files;
  for (std::size_t i = 0; i < search->cameras.size(); ++i)
    if (search->cameras[i].empty()) files.without_.push_back(foreign.rig.cameras[i].serial);
  if (files.without_.size() == search->cameras.size())
    return fail(ErrorCode::NotFound,
                text(folder.string(),
                     ": there is no plate for any camera; they are named as the pictures are: a picture, a "
                     "video or a folder of pictures of the empty stage for each; add them, or leave --plates "
                     "out"));
  files.cameras_ = std::move(search->cameras);
  return files;
}

Result<void> PlateFiles::save(std::size_t camera, const RigCamera& rig_camera, const fs::path& take) const {
  const CameraMedia& media = cameras_[camera];
  if (media.empty()) return {};
  Result<PictureStream> stream = PictureStream::open(media, {});
  if (!stream) return forward(stream);
  if (stream->width() != rig_camera.model.width || stream->height() != rig_camera.model.height)
    return fail(
        ErrorCode::BadData,
        text(media.video.empty() ? media.stills.front().string() : media.video.string(), ": the plate is ",
             stream->width(), "x", stream->height(), ", but the pictures of camera '", rig_camera.serial,
             "' are ", rig_camera.model.width, "x", rig_camera.model.height));
  const Result<std::vector<Image>> plates = spread(*stream);
  if (!plates) return forward(plates);
  const fs::path one = TakeLayout(take).plate(rig_camera.serial);
  const bool several = plates->size() > 1;
  const fs::path into = several ? one.parent_path() / rig_camera.serial : one.parent_path();
  if (Result<void> ok = make_folder(into); !ok) return ok;
  for (std::size_t k = 0; k < plates->size(); ++k) {
    const fs::path file = several ? into / text(k < 10 ? "0" : "", k, ".png") : one;
    if (Result<void> ok = save_png((*plates)[k], file); !ok) return ok;
  }
  return {};
}

}  // namespace floatstage::pipeline
