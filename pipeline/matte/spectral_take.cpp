#include "pipeline/matte/spectral_take.h"

#include <algorithm>

#include "pipeline/matte/take_clip.h"

namespace floatstage::pipeline {

Result<SpectralTake> SpectralTake::create(capture::TakeReader& take, int camera, const CameraKey& key,
                                          const std::filesystem::path& cache, int threads) {
  matting::MattingClip clip = clip_of(take, camera);
  if (key.kind() != CameraKey::Kind::None)
    clip.likelihood = [&take, camera, key](int frame) -> Result<matting::MatteConstraint> {
      Result<Frame> photograph = take.frame(camera, frame);
      if (!photograph) return forward(photograph);
      if (photograph->empty()) return matting::MatteConstraint();
      Result<Image> opacity = key.key(*photograph, frame);
      if (!opacity) return forward(opacity);
      return matting::MatteConstraint{std::move(*opacity), {}};
    };
  matting::VideoMattingOptions options;
  options.threads = threads;
  options.likelihood_is_matte = key.kind() != CameraKey::Kind::None;
  Result<matting::VideoMatting> video = matting::VideoMatting::create(std::move(clip), cache, options);
  if (!video) return forward(video);
  return SpectralTake(take, camera, std::move(*video));
}

Result<void> SpectralTake::say(const CameraMatting& matting) {
  std::vector<MatteKeyframe> wanted;
  for (const MatteKeyframe& k : matting.edits().keyframes)
    if (!k.strokes.empty()) wanted.push_back(k);
  const auto has = [](const std::vector<MatteKeyframe>& all, const auto& fits) {
    return std::any_of(all.begin(), all.end(), fits);
  };
  for (const MatteKeyframe& old : said_)
    if (!has(wanted, [&](const MatteKeyframe& k) { return k.frame == old.frame; }))
      video_.remove_keyframe(old.frame);
  std::vector<MatteKeyframe> before = std::exchange(said_, {});
  for (const MatteKeyframe& k : wanted) {
    if (!has(before, [&](const MatteKeyframe& old) { return old == k; }))
      if (Result<void> ok = video_.set_keyframe(k.frame, opinion_of(k, video_.width(), video_.height())); !ok)
        return ok;
    said_.push_back(k);
  }
  return {};
}

Result<void> SpectralTake::propagate(const std::function<bool(int)>& done, int first, int last) {
  const Result<std::vector<int>> made = video_.propagate(done, first, last);
  return made ? Result<void>() : Result<void>(forward(made));
}

Result<Image> SpectralTake::matte(const CameraMatting& matting, int frame) const {
  Result<Frame> photograph = take_->frame(camera_, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Image();
  Result<Image> matte = video_.matte(frame);
  if (matte) matting.mask(frame, *matte);
  return matte;
}

Result<matting::MattingComponents> components_of_frame(capture::TakeReader& take, int camera, int frame,
                                                       const std::filesystem::path& cache) {
  const matting::MattingClip all = clip_of(take, camera);
  matting::MattingClip clip;
  clip.frames = 1;
  clip.photograph = [&](int) { return all.photograph(frame); };
  matting::VideoMattingOptions options;
  options.threads = 1;
  Result<matting::VideoMatting> video = matting::VideoMatting::create(std::move(clip), cache, options);
  if (!video) return forward(video);
  if (Result<void> ok = video->prepare(); !ok) return forward(ok);
  return video->components(0);
}

}  // namespace floatstage::pipeline
