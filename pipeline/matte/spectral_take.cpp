#include "pipeline/matte/spectral_take.h"

#include <algorithm>

#include "pipeline/matte/affected_frames.h"
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
  std::map<int, MatteKeyframe> wanted;
  for (const MatteKeyframe& k : matting.edits().keyframes)
    if (!k.strokes.empty() && k.frame < usable()) wanted[k.frame] = k;
  for (auto old = said_.begin(); old != said_.end();) {
    const auto now = wanted.find(old->first);
    if (now != wanted.end() && now->second == old->second.keyframe) {
      wanted.erase(now);
      ++old;
    } else {
      video_.remove_keyframe(old->first);
      old = said_.erase(old);
    }
  }
  for (const auto& [frame, keyframe] : wanted)
    if (Result<void> ok = say(matting, keyframe); !ok) return ok;
  return {};
}

Result<void> SpectralTake::say(const CameraMatting& matting, const MatteKeyframe& keyframe) {
  const int frame = keyframe.frame;
  Result<Frame> photograph = take_->frame(camera_, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return {};
  Result<Image> rgb = to_rgb(*photograph);
  if (!rgb) return forward(rgb);
  const MatteKeyframe seed = seed_of({{keyframe}, {}});
  const bool none = matting.key().kind() == CameraKey::Kind::None, seeded = none && !seed.strokes.empty();
  if (none && !seeded) {  // nothing to choose components by: it guides what is carried here
    said_[frame] = {keyframe, {}};
    return {};
  }
  Result<Image> base = video_.matte_alone(
      frame, seeded ? opinion_of(seed, video_.width(), video_.height()) : matting::MatteConstraint());
  if (!base) return forward(base);
  Result<CameraMatting::Link> made = matting.guided(frame, *rgb, std::move(*base));
  if (!made) return forward(made);
  const auto [low, high] = std::minmax_element(made->matte.pixels.begin(), made->matte.pixels.end());
  const bool says = seeded || made->matte != made->base, tells_apart = *low < 128 && *high >= 128;
  const bool carried = says && tells_apart;
  if (carried)
    if (Result<void> ok = video_.set_keyframe(frame, {made->matte, {}}); !ok) return ok;
  if (says || !made->idle.empty()) said_[frame] = {keyframe, std::move(*made), carried};
  return {};
}

std::vector<std::string> SpectralTake::idle() const {
  std::vector<std::string> all;
  for (const auto& [frame, said] : said_) all.insert(all.end(), said.made.idle.begin(), said.made.idle.end());
  return all;
}

std::vector<bool> SpectralTake::reached(int frames) const {
  std::vector<bool> out(static_cast<std::size_t>(frames));
  for (const auto& [frame, said] : said_) {
    if (!said.made.matte.empty() && said.carried)
      out.assign(out.size(), true);
    else if (said.made.matte.empty() && frame < frames)
      out[static_cast<std::size_t>(frame)] = true;
  }
  return out;
}

Result<void> SpectralTake::propagate(const std::function<bool(int)>& done, int first, int last) {
  const Result<std::vector<int>> made = video_.propagate(done, first, last);
  return made ? Result<void>() : Result<void>(forward(made));
}

Result<Image> SpectralTake::matte(const CameraMatting& matting, int frame) const {
  Result<Frame> photograph = take_->frame(camera_, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Image();
  const auto said = said_.find(frame);
  const bool own = said != said_.end() && said->second.made.matte != said->second.made.base;
  Result<Image> matte = own ? said->second.made.matte : video_.matte(frame);
  if (matte && said != said_.end() && said->second.made.matte.empty()) {
    const Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) return forward(rgb);
    Result<CameraMatting::Link> guided = matting.guided(frame, *rgb, std::move(*matte));
    if (!guided) return forward(guided);
    matte = std::move(guided->matte);
  }
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
