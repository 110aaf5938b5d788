#include "apps/matte/spectral_take.h"

#include "apps/interrupt.h"
#include "core/text.h"
#include "matting/video_matting.h"

namespace floatstage {
namespace {

// A gap shows what was seen last, or first: the engine wants a picture for every frame.
Result<Frame> nearest_photograph(TakeReader& take, int camera, int frame) {
  for (int away = 0; away < take.frame_count(); ++away)
    for (const int f : {frame - away, frame + away}) {
      if (f < 0 || f >= take.frame_count()) continue;
      Result<Frame> photograph = take.frame(camera, f);
      if (!photograph || !photograph->empty()) return photograph;
    }
  return fail(ErrorCode::NotFound, "the camera has no photograph at all");
}

}  // namespace

Result<void> spectral_mattes(TakeReader& take, const CameraMatter& matter, const std::filesystem::path& cache, int threads,
                             const std::function<Result<void>(int frame, Image matte)>& done) {
  const int camera = matter.camera();
  MattingClip clip;
  clip.frames = take.frame_count();
  clip.photograph = [&](int frame) -> Result<Image> {
    Result<Frame> photograph = nearest_photograph(take, camera, frame);
    if (!photograph) return forward(photograph);
    return to_rgb(*photograph);
  };
  if (matter.key().kind() != CameraKey::Kind::None)
    clip.likelihood = [&](int frame) -> Result<MatteOpinion> {
      Result<Frame> photograph = take.frame(camera, frame);
      if (!photograph) return forward(photograph);
      if (photograph->empty()) return MatteOpinion();
      Result<Image> key = matter.key().key(*photograph, frame);
      if (!key) return forward(key);
      return MatteOpinion{std::move(*key), {}};
    };
  VideoMattingOptions options;
  options.threads = threads;
  Result<VideoMatting> video = VideoMatting::create(std::move(clip), cache, options);
  if (!video) return forward(video);
  for (const MatteKeyframe& keyframe : matter.edits().keyframes)
    if (!keyframe.strokes.empty())
      if (Result<void> ok = video->set_keyframe(keyframe.frame, matter.strokes_of(keyframe, video->width(), video->height())); !ok) return ok;
  if (Result<void> ok = video->prepare([](int) { return !interrupted(); }); !ok) return ok;
  Result<std::vector<int>> made = video->propagate();
  if (!made) return forward(made);
  for (int frame = 0; frame < video->frames() && !interrupted(); ++frame) {
    Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) return forward(photograph);
    Result<Image> matte = photograph->empty() ? Image() : video->matte(frame);
    if (!matte) return forward(matte);
    if (!matte->empty()) matter.mask(frame, *matte);
    if (Result<void> ok = done(frame, std::move(*matte)); !ok) return ok;
  }
  return interrupted() ? Result<void>(cancelled()) : Result<void>();
}

}  // namespace floatstage
