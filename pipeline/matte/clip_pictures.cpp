#include "pipeline/matte/clip_pictures.h"

#include <charconv>
#include <cstdio>

#include "core/png.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

Result<ClipPictures> ClipPictures::open(const fs::path& media, const fs::path& scratch, Progress* progress) {
  ClipPictures clip;
  std::error_code error;
  if (!fs::exists(media, error))
    return fail(ErrorCode::NotFound,
                text(media.string(), " is not there; name a video or a folder of pictures"));
  const CameraMedia found = media_of(media);
  if (found.empty())
    return fail(ErrorCode::NotFound, text(media.string(), " is no video and no folder of pictures"));
  if (found.video.empty()) {
    clip.stills_ = found;
    return clip;
  }
  Result<PictureStream> video = PictureStream::open(found, {});
  if (!video) return forward(video);
  fs::create_directories(scratch, error);
  if (error) return fail(ErrorCode::Io, text("cannot make ", scratch.string(), ": ", error.message()));
  clip.named_ = false;
  const ProgressPart part(progress, "frames read", 0);
  for (int frame = 0;; ++frame) {
    if (is_cancelled(progress)) return cancelled_unwritten();
    Result<std::optional<Image>> picture = video->next();
    if (!picture) return forward(picture);
    if (!*picture) break;
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", frame);
    if (Result<void> ok = save_png(**picture, scratch / name); !ok) return forward(ok);
    clip.stills_.stills.push_back(scratch / name);
  }
  return clip;
}

Result<Image> ClipPictures::picture(int frame) const {
  CameraMedia one;
  one.stills = {stills_.stills.at(static_cast<std::size_t>(frame))};
  Result<PictureStream> stream = PictureStream::open(one, {});
  if (!stream) return forward(stream);
  Result<std::optional<Image>> picture = stream->next();
  if (!picture) return forward(picture);
  return std::move(**picture);
}

int ClipPictures::frame_of(const std::string& stem) const {
  for (std::size_t f = 0; named_ && f < stills_.stills.size(); ++f)
    if (stills_.stills[f].stem() == stem) return static_cast<int>(f);
  int number = -1;  // of a name that is nothing but a number: "person2" is no frame
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
  const bool whole = error == std::errc() && end == stem.data() + stem.size();
  return whole && number >= 0 && number < frames() ? number : -1;
}

}  // namespace floatstage::pipeline
