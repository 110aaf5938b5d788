#include "matting/video/video_matting.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/file.h"
#include "core/text.h"
#include "matting/guided_upsample.h"
#include "matting/picture_scale.h"
#include "matting/video/closed_form_video.h"
#include "matting/video/component_store.h"
#include "matting/video/matte_propagation.h"

namespace floatstage::matting {
namespace {

Image mean_of(const Image& a, const Image& b, double share_of_b) {
  Image out = a;
  for (std::size_t p = 0; p < out.pixels.size(); ++p)
    out.pixels[p] =
        static_cast<std::uint8_t>(std::lround(a.pixels[p] + share_of_b * (b.pixels[p] - a.pixels[p])));
  return out;
}

struct Extent {
  bool subject = false, background = false, everywhere = true;
  bool whole() const { return subject && background && everywhere; }
};

Extent extent_of(const MatteConstraint& opinion) {
  Extent e;
  for (std::size_t p = 0; p < opinion.opacity.pixels.size(); ++p) {
    if (!opinion.weight.empty() && opinion.weight.pixels[p] == 0) {
      e.everywhere = false;
      continue;
    }
    (opinion.opacity.pixels[p] >= 128 ? e.subject : e.background) = true;
  }
  return e;
}

Unexpected stopped() { return fail(ErrorCode::Cancelled, "stopped while mattes were carried along"); }

}  // namespace

Result<void> VideoMattingOptions::check() const {
  if (const auto good = spectral.check(); !good) return good;
  const struct {
    const char* name;
    double value, low, high;
  } ranges[] = {{"working_pixels", static_cast<double>(working_pixels), 1000, 1e6},
                {"guidance_strength", guidance_strength, 0, 1e6},
                {"likelihood_strength", likelihood_strength, 0, 1e6},
                {"keyframe_strength", keyframe_strength, 0, 1e6},
                {"persistence", persistence, 0, 1e6},
                {"misfit", misfit, 0, 1e6},
                {"temporal_filter", temporal_filter, 0, 0.9},
                {"threads", static_cast<double>(threads), 0, 1024}};
  for (const auto& r : ranges)
    if (!(r.value >= r.low && r.value <= r.high))
      return fail(ErrorCode::InvalidArgument, text("video matting: ", r.name, " is ", r.value,
                                                   "; it must lie between ", r.low, " and ", r.high));
  return {};
}

struct VideoMatting::Impl {
  // A frame's matte on the way in one direction.
  struct Step {
    Image matte;
    std::vector<bool> chosen;
    double energy = 0;
    bool fits = true;
    Image likelihood = {};  // what a key said, where components do not fit
    bool settled = false;   // that is the matte
  };
  struct FrameState {
    Image matte;  // working size; empty: stale
    MattedFrame report;
  };

  MattingClip clip;
  VideoMattingOptions options;
  int width = 0, height = 0, small_width = 0, small_height = 0, usable = 0;
  std::optional<ComponentStore> store;
  std::map<int, MatteConstraint> keyframes;
  std::vector<FrameState> states;
  std::function<bool(int)> watch;  // of the propagate() that runs

  Result<Image> photograph(int frame) const;
  Result<Image> small(int frame) const;
  Result<MatteConstraint> likelihood(int frame) const;
  Result<Step> step(int frame, const Image& picture, std::vector<FrameEvidence::Carried> carried) const;
  Result<Step> step(int frame, const Image& picture, std::vector<FrameEvidence::Carried> carried,
                    const MatteConstraint& keyframe) const;
  Result<FrameEvidence::Carried> carry(int from, const Step& before, const Image& before_picture, int to,
                                       const Image& picture) const;
  Result<void> walk(int first, int last, int direction, std::map<int, Step>& steps) const;
  Result<void> blend(int first, int last, std::map<int, Step>& forwards,
                     const std::map<int, Step>& backwards) const;
  Result<void> span(int first, int last, std::map<int, Step>& out) const;
  void make_stale(int frame);
};

Result<Image> VideoMatting::Impl::photograph(int frame) const {
  auto picture = clip.photograph(frame);
  if (!picture) return picture;
  if (picture->width != width || picture->height != height)
    return fail(ErrorCode::BadData, text("the photograph is ", picture->width, "x", picture->height,
                                         ", the first one is ", width, "x", height, "; a clip has one size"));
  return picture;
}

Result<Image> VideoMatting::Impl::small(int frame) const {
  const auto picture = photograph(frame);
  if (!picture) return forward(picture);
  return matting::scaled(*picture, small_width, small_height);
}

Result<MatteConstraint> VideoMatting::Impl::likelihood(int frame) const {
  if (!clip.likelihood) return MatteConstraint{};
  const auto opinion = clip.likelihood(frame);
  if (!opinion) return forward(opinion);
  return scaled(*opinion, small_width, small_height);
}

Result<VideoMatting::Impl::Step> VideoMatting::Impl::step(int frame, const Image& picture,
                                                          std::vector<FrameEvidence::Carried> carried) const {
  const auto found = keyframes.find(frame);
  return step(frame, picture, std::move(carried),
              found == keyframes.end() ? MatteConstraint() : found->second);
}

Result<VideoMatting::Impl::Step> VideoMatting::Impl::step(int frame, const Image& picture,
                                                          std::vector<FrameEvidence::Carried> carried,
                                                          const MatteConstraint& keyframe) const {
  const auto components = store->load(frame);
  if (!components) return forward(components);
  auto said = likelihood(frame);
  if (!said) return forward(said);
  FrameEvidence evidence{keyframe, std::move(*said), std::move(carried)};
  const bool alone = evidence.likelihood.empty() && evidence.carried.empty();
  Result<Selection> selection = fail(ErrorCode::InvalidArgument, "");
  if (alone && evidence.keyframe.empty()) {
    const auto laplacian = matting_laplacian(picture, options.spectral.laplacian);
    if (!laplacian) return forward(laplacian);
    selection = guess_selection(*components, *laplacian);
  } else {
    if (alone && !extent_of(evidence.keyframe).subject)
      return fail(ErrorCode::InvalidArgument,
                  text("frame ", frame, ": the first keyframe marks background only; mark what is subject"));
    selection = choose(*components, evidence, options);
  }
  if (!selection) return fail(selection.error().code, text("frame ", frame, ": ", selection.error().message));
  Step made{matte_of(*components, selection->chosen), std::move(selection->chosen), selection->energy};
  const bool given = !evidence.keyframe.empty() && extent_of(evidence.keyframe).whole();
  if (given)
    made.matte = evidence.keyframe.opacity;
  else
    made.fits = misfit_of(made.matte, evidence.carried) <= options.misfit;
  if (options.likelihood_is_matte && !evidence.likelihood.empty() && !given) {
    MatteConstraint whole = evidence.likelihood;
    if (whole.weight.empty()) whole.weight = Image(whole.opacity.width, whole.opacity.height, 1, 255);
    made.settled = misfit_of(made.matte, {{std::move(whole), {}, 1}}) > options.misfit;
    if (made.settled) made.fits = false, made.matte = evidence.likelihood.opacity;
  }
  if (!made.fits) made.likelihood = std::move(evidence.likelihood.opacity);
  return made;
}

Result<FrameEvidence::Carried> VideoMatting::Impl::carry(int from, const Step& before,
                                                         const Image& before_picture, int to,
                                                         const Image& picture) const {
  const bool same_run = from / ComponentStore::kRun == to / ComponentStore::kRun;
  return FrameEvidence::Carried{guidance_from(before.matte, before_picture, picture),
                                same_run ? before.chosen : std::vector<bool>{}, 1};
}

// From frame `first`, whose step is there, to `last` in one direction.
Result<void> VideoMatting::Impl::walk(int first, int last, int direction, std::map<int, Step>& steps) const {
  auto before = small(first);
  if (!before) return forward(before);
  auto closed_form = ClosedFormVideo::create();
  if (!closed_form) return forward(closed_form);
  bool carrying = false;  // closed form made the frame before
  for (int frame = first + direction; frame != last + direction; frame += direction) {
    if (watch && !watch(frame)) return stopped();
    auto picture = small(frame);
    if (!picture) return forward(picture);
    auto guidance = carry(frame - direction, steps.at(frame - direction), *before, frame, *picture);
    if (!guidance) return forward(guidance);
    auto made = step(frame, *picture, {std::move(*guidance)});
    if (!made) return forward(made);
    if (!made->fits && !made->settled && picture->channels == 3) {
      if (!carrying)
        if (const auto r = closed_form->keyframe(*before, steps.at(frame - direction).matte); !r) return r;
      auto carried_on = closed_form->next(*picture, made->likelihood);
      if (!carried_on) return forward(carried_on);
      made->matte = std::move(*carried_on);
      carrying = true;
    } else {
      carrying = false;
    }
    steps[frame] = std::move(*made);
    before = std::move(picture);
  }
  return {};
}

// Between two keyframes every frame is chosen once more by what comes from both, the nearer one counting
// more.
Result<void> VideoMatting::Impl::blend(int first, int last, std::map<int, Step>& forwards,
                                       const std::map<int, Step>& backwards) const {
  auto before = small(first), picture = small(first + 1);
  if (!before) return forward(before);
  for (int frame = first + 1; frame < last; ++frame) {
    if (watch && !watch(frame)) return stopped();
    if (!picture) return forward(picture);
    auto after = small(frame + 1);
    if (!after) return forward(after);
    auto a = carry(frame - 1, forwards.at(frame - 1), *before, frame, *picture);
    auto b = carry(frame + 1, backwards.at(frame + 1), *after, frame, *picture);
    if (!a) return forward(a);
    if (!b) return forward(b);
    const double share = static_cast<double>(frame - first) / (last - first);
    b->share = share;
    a->share = 1 - share;
    auto made = step(frame, *picture, {std::move(*a), std::move(*b)});
    if (!made) return forward(made);
    if (!made->fits && !made->settled)
      made->matte = mean_of(forwards.at(frame).matte, backwards.at(frame).matte, share);
    forwards[frame] = std::move(*made);
    before = std::move(picture);
    picture = std::move(after);
  }
  return {};
}

// All frames between two keyframes, or from one to an end of the clip; the keyframes themselves are made
// first.
Result<void> VideoMatting::Impl::span(int first, int last, std::map<int, Step>& out) const {
  const bool from = keyframes.contains(first) || keyframes.empty(),
             to = last > first && keyframes.contains(last);
  const auto start = [&](int frame) -> Result<void> {
    if (out.contains(frame)) return {};
    const auto picture = small(frame);
    if (!picture) return forward(picture);
    auto made = step(frame, *picture, {});
    if (!made) return forward(made);
    out[frame] = std::move(*made);
    return {};
  };
  if (from)
    if (const auto r = start(first); !r) return r;
  if (to)
    if (const auto r = start(last); !r) return r;
  if (!to) return walk(first, last, 1, out);
  if (!from) return walk(last, first, -1, out);
  if (last - first < 2) return {};
  std::map<int, Step> backwards;
  backwards[last] = out.at(last);
  if (const auto r = walk(first, last - 1, 1, out); !r) return r;
  if (const auto r = walk(last, first + 1, -1, backwards); !r) return r;
  return blend(first, last, out, backwards);
}

void VideoMatting::Impl::make_stale(int frame) {
  const auto next = keyframes.upper_bound(frame);
  auto at = keyframes.lower_bound(frame);
  const int first = at == keyframes.begin() ? 0 : std::prev(at)->first + 1;
  const int last = next == keyframes.end() ? static_cast<int>(states.size()) : next->first;
  for (int f = first; f < last; ++f) states[static_cast<std::size_t>(f)] = {};
}

VideoMatting::VideoMatting(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoMatting::VideoMatting(VideoMatting&&) noexcept = default;
VideoMatting& VideoMatting::operator=(VideoMatting&&) noexcept = default;
VideoMatting::~VideoMatting() = default;

Result<VideoMatting> VideoMatting::create(MattingClip clip, const std::filesystem::path& cache,
                                          const VideoMattingOptions& options) {
  if (const auto good = options.check(); !good) return forward(good);
  if (clip.frames <= 0 || !clip.photograph)
    return fail(ErrorCode::InvalidArgument, "there is no frame in the clip to be matted");
  const auto first = clip.photograph(0);
  if (!first) return forward(first);
  if (first->width < 3 || first->height < 3)
    return fail(ErrorCode::BadData,
                text("the first photograph is ", first->width, "x", first->height, ": too small to matte"));
  if (const auto made = make_folder(cache); !made) return forward(made);
  auto impl = std::make_unique<Impl>();
  impl->clip = std::move(clip);
  impl->options = options;
  impl->width = first->width;
  impl->height = first->height;
  const double pixels = static_cast<double>(first->width) * first->height;
  const double scale = std::min(1.0, std::sqrt(options.working_pixels / pixels));
  impl->small_width = std::max(3, static_cast<int>(std::lround(first->width * scale)));
  impl->small_height = std::max(3, static_cast<int>(std::lround(first->height * scale)));
  impl->store.emplace(cache, impl->small_width, impl->small_height, options.spectral);
  impl->states.resize(static_cast<std::size_t>(impl->clip.frames));
  return VideoMatting(std::move(impl));
}

int VideoMatting::frames() const { return impl_->clip.frames; }
int VideoMatting::width() const { return impl_->width; }
int VideoMatting::height() const { return impl_->height; }
int VideoMatting::working_width() const { return impl_->small_width; }
int VideoMatting::working_height() const { return impl_->small_height; }
int VideoMatting::usable() const { return impl_->usable; }

Result<void> VideoMatting::prepare(const std::function<bool(int)>& done) {
  auto outcome = impl_->store->prepare(
      impl_->clip.frames, impl_->options.threads, [this](int frame) { return impl_->small(frame); }, done);
  impl_->usable = outcome.usable;
  return outcome.result;
}

Result<MattingComponents> VideoMatting::components(int frame) const {
  if (frame < 0 || frame >= impl_->usable)
    return fail(ErrorCode::NotFound,
                text("frame ", frame, " has no matting components; ", impl_->usable, " frames have"));
  return impl_->store->load(frame);
}

Result<void> VideoMatting::set_keyframe(int frame, const MatteConstraint& opinion) {
  if (frame < 0 || frame >= impl_->clip.frames)
    return fail(ErrorCode::InvalidArgument,
                text("there is no frame ", frame, " in a clip of ", impl_->clip.frames));
  if (opinion.opacity.channels != 1 || opinion.empty() ||
      (!opinion.weight.empty() &&
       (opinion.weight.width != opinion.opacity.width || opinion.weight.height != opinion.opacity.height ||
        opinion.weight.channels != 1)))
    return fail(ErrorCode::InvalidArgument,
                text("keyframe ", frame, ": opacity and weight must be one channel of one size"));
  const Extent extent = extent_of(opinion);
  if (!extent.subject && !extent.background)
    return fail(ErrorCode::InvalidArgument, text("keyframe ", frame, " says nothing: all its weights are 0"));
  if (extent.everywhere && !(extent.subject && extent.background))
    return fail(ErrorCode::InvalidArgument,
                text("keyframe ", frame, " is all ", extent.subject ? "subject" : "background",
                     ": there is nothing to tell apart"));
  impl_->keyframes[frame] = scaled(opinion, impl_->small_width, impl_->small_height);
  impl_->make_stale(frame);
  return {};
}

Result<Image> VideoMatting::matte_alone(int frame, const MatteConstraint& opinion) const {
  if (frame < 0 || frame >= impl_->usable)
    return fail(ErrorCode::NotFound, text("frame ", frame, " has no matting components"));
  const auto photograph = impl_->photograph(frame);
  if (!photograph) return forward(photograph);
  const auto made = impl_->step(frame, matting::scaled(*photograph, impl_->small_width, impl_->small_height),
                                {}, scaled(opinion, impl_->small_width, impl_->small_height));
  if (!made) return forward(made);
  return guided_upsample(made->matte, *photograph);
}

void VideoMatting::remove_keyframe(int frame) {
  if (impl_->keyframes.erase(frame) == 0) return;
  impl_->make_stale(frame);
  if (impl_->keyframes.empty())
    for (auto& state : impl_->states) state = {};
}

Result<std::vector<int>> VideoMatting::propagate(const std::function<bool(int)>& done, int from, int to) {
  Impl& s = *impl_;
  s.watch = done;
  // Spans between neighbouring keyframes and the ends of what is usable; those with stale frames are made.
  std::vector<int> ends{0};
  for (const auto& [frame, opinion] : s.keyframes)
    if (frame < s.usable && frame > 0) ends.push_back(frame);
  if (s.usable > 0 && ends.back() != s.usable - 1) ends.push_back(s.usable - 1);
  if (s.usable == 0)
    return fail(ErrorCode::NotFound, "no frame has matting components yet; prepare them first");
  if (!s.keyframes.empty() && s.keyframes.begin()->first >= s.usable)
    return fail(ErrorCode::InvalidArgument, text("the first keyframe is frame ", s.keyframes.begin()->first,
                                                 ", but only ", s.usable, " frames can be matted"));
  std::set<int> made;
  if (ends.size() == 1) ends.push_back(ends.front());
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const int first = ends[i], last = ends[i + 1];
    if (last < from || first > to) continue;
    const bool stale = std::any_of(s.states.begin() + first, s.states.begin() + last + 1,
                                   [](const auto& state) { return state.matte.empty(); });
    if (!stale) continue;
    std::map<int, Impl::Step> steps;
    if (const auto r = s.span(first, last, steps); !r) return forward(r);
    // Filtered in the order of time. A frame that two spans share is the same in both.
    Image before_picture;
    if (first > 0) {
      const auto picture = s.small(first - 1);
      if (!picture) return forward(picture);
      before_picture = *picture;
    }
    for (int frame = first; frame <= last; ++frame) {
      const auto picture = s.small(frame);
      if (!picture) return forward(picture);
      const Impl::Step& step = steps.at(frame);
      auto& state = s.states[static_cast<std::size_t>(frame)];
      state = {step.matte, {step.energy, 0, s.keyframes.contains(frame), step.fits}};
      // A keyframe that begins this span is not filtered; the span before it may not be made yet.
      if (frame > 0 && !s.states[static_cast<std::size_t>(frame - 1)].matte.empty()) {
        const MatteConstraint previous =
            guidance_from(s.states[static_cast<std::size_t>(frame - 1)].matte, before_picture, *picture);
        if (s.options.temporal_filter > 0 && !state.report.keyframe)
          state.matte = filtered(state.matte, previous, s.options.temporal_filter);
        state.report.flicker = flicker_between(state.matte, previous.opacity);
      }
      before_picture = *picture;
      made.insert(frame);
    }
  }
  return std::vector<int>(made.begin(), made.end());
}

Result<double> matte_flicker(const Image& photograph_before, const Image& matte_before,
                             const Image& photograph, const Image& matte) {
  constexpr double kPixels = 30000;
  const auto fits = [&](const Image& i) {
    return i.width == photograph.width && i.height == photograph.height && !i.empty();
  };
  if (!fits(photograph_before) || !fits(matte_before) || !fits(matte) || matte.channels != 1 ||
      matte_before.channels != 1)
    return fail(ErrorCode::InvalidArgument,
                "the flicker of a matte needs photographs and mattes of one size");
  const double scale = std::min(1.0, std::sqrt(kPixels / (static_cast<double>(matte.width) * matte.height)));
  const int width = std::max(3, static_cast<int>(std::lround(matte.width * scale)));
  const int height = std::max(3, static_cast<int>(std::lround(matte.height * scale)));
  const MatteConstraint carried =
      guidance_from(scaled(matte_before, width, height), scaled(photograph_before, width, height),
                    scaled(photograph, width, height));
  return flicker_between(scaled(matte, width, height), carried.opacity);
}

Result<Image> VideoMatting::working_matte(int frame) const {
  if (frame < 0 || frame >= frames() || impl_->states[static_cast<std::size_t>(frame)].matte.empty())
    return fail(ErrorCode::NotFound, text("frame ", frame, " has no matte yet; propagate first"));
  return impl_->states[static_cast<std::size_t>(frame)].matte;
}

Result<Image> VideoMatting::matte(int frame) const {
  const auto small = working_matte(frame);
  if (!small) return small;
  const auto photograph = impl_->photograph(frame);
  if (!photograph) return forward(photograph);
  return guided_upsample(*small, *photograph);
}

const MattedFrame& VideoMatting::report(int frame) const {
  FLOATSTAGE_CHECK(frame >= 0 && frame < frames(), text("frame ", frame));
  return impl_->states[static_cast<std::size_t>(frame)].report;
}

}  // namespace floatstage::matting
