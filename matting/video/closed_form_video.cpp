// Method:  a matte carried along a clip: flow, a band around
//          its edge, closed form in the band
// Paper:   thesis, section 7.3, with closed form (Levin and others 2008) in the place of components
// Differs: backdrop that was uncovered once is remembered and known
// ADR:     0094, 0097

#include "matting/video/closed_form_video.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/video/flow_carry.h"

namespace floatstage::matting {
namespace {

constexpr int kSurelyBackground = 5;  // opacity up to here is remembered as backdrop
constexpr int kSurelySubject = 230;   // opacity from here on is subject where nothing speaks against it
constexpr float kStill = 2;      // mean squared change in units of the noise; 2 is what noise alone makes
constexpr float kForget = 0.1f;  // how fast the memory follows slow changes of light

bool fits(const Image& map, const Image& picture) {
  return map.empty() || (map.channels == 1 && map.width == picture.width && map.height == picture.height);
}

}  // namespace

struct ClosedFormVideo::Impl {
  ClosedFormVideoOptions options;
  Image picture, matte;            // of the last frame
  std::vector<float> backdrop;     // RGB
  std::vector<std::uint8_t> seen;  // how often, up to 255

  void remember(const Image& now, const Image& alpha) {
    if (!options.still_camera) return;
    const std::size_t n = alpha.pixels.size();
    if (seen.size() != n) backdrop.assign(3 * n, 0), seen.assign(n, 0);
    for (std::size_t p = 0; p < n; ++p) {
      if (alpha.pixels[p] > kSurelyBackground) continue;
      const float weight = std::max(kForget, 1.0f / (seen[p] + 1));
      for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) backdrop[c] += weight * (now.pixels[c] - backdrop[c]);
      if (seen[p] < 255) ++seen[p];
    }
  }

  // Squared distance to the remembered backdrop in units of the noise, mean over channels; negative where
  // unknown.
  float distance(const Image& now, std::size_t p) const {
    if (seen.empty() || seen[p] == 0) return -1;
    float sum = 0;
    for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) {
      const float d = (now.pixels[c] - backdrop[c]) / static_cast<float>(options.noise);
      sum += d * d;
    }
    return sum / 3;
  }

  // The 3x3 around p shows what it showed in the last frame: before a still camera, backdrop that was
  // uncovered just now, unless the subject rests.
  bool stands_still(const Image& now, std::size_t p) const {
    const int x = static_cast<int>(p) % now.width, y = static_cast<int>(p) / now.width;
    if (!options.still_camera || x < 1 || y < 1 || x + 1 >= now.width || y + 1 >= now.height) return false;
    float sum = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        for (int c = 0; c < 3; ++c) {
          const float d =
              (now.at(x + dx, y + dy)[c] - picture.at(x + dx, y + dy)[c]) / static_cast<float>(options.noise);
          sum += d * d;
        }
    return sum / 27 < kStill;
  }

  // No pixel of the 3x3 around p shows the remembered backdrop, which is known for all of them.
  bool covered(const Image& now, std::size_t p, float same) const {
    const int x = static_cast<int>(p) % now.width, y = static_cast<int>(p) / now.width;
    if (x < 1 || y < 1 || x + 1 >= now.width || y + 1 >= now.height) return false;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (distance(now, static_cast<std::size_t>(y + dy) * now.width + x + dx) <= same) return false;
    return true;
  }

  // What the carried matte, the memory and the person leave unknown.
  Image band(const Image& now, const Carried& carried, const Image& keep) const {
    TrimapOptions around = options.refine.band;
    around.margin = options.margin;
    Image trimap = trimap_around(carried.matte, around);
    const float same = static_cast<float>(options.same_backdrop * options.same_backdrop);
    for (std::size_t p = 0; p < trimap.pixels.size(); ++p) {
      const float d = distance(now, p);
      if (carried.doubt.pixels[p] && trimap.pixels[p] == 255) trimap.pixels[p] = 128;
      if (trimap.pixels[p] == 128 && d >= 0 && d < 1.5f) trimap.pixels[p] = 0;
      // All around, something stands before the backdrop, and the flow says that it is the subject.
      if (trimap.pixels[p] == 128 && !carried.doubt.pixels[p] && carried.matte.pixels[p] >= kSurelySubject &&
          covered(now, p, same))
        trimap.pixels[p] = 255;
      // Backdrop that shows something else than it should is not surely background near the subject, but only
      // there: other people walk through pictures too.
      if (trimap.pixels[p] == 0 && carried.matte.pixels[p] > 0 && d > same) trimap.pixels[p] = 128;
      if (!keep.empty() && (keep.pixels[p] == 0 || keep.pixels[p] == 255)) trimap.pixels[p] = keep.pixels[p];
    }
    return trimap;
  }

  // What is likely inside the band, and how hard it holds at weight 255: where the backdrop is known, whether
  // the pixel shows something else; elsewhere the carried matte, and the guidance on top of both.
  double opinion(const Image& now, const Carried& carried, const Image& guidance, Image& prior,
                 Image& weight) const {
    const double most =
        std::max({options.hold_backdrop, options.hold_carried, guidance.empty() ? 0.0 : options.prior});
    if (most == 0) return 0;
    prior = carried.matte;
    weight = Image(now.width, now.height, 1);
    const float same = static_cast<float>(options.same_backdrop * options.same_backdrop);
    for (std::size_t p = 0; p < prior.pixels.size(); ++p) {
      double sum = 0, total = 0;
      const auto add = [&](double opacity, double hold) { sum += hold * opacity, total += hold; };
      const float d = distance(now, p);
      if (!carried.doubt.pixels[p]) add(carried.matte.pixels[p], options.hold_carried);
      if (d < 0 && carried.matte.pixels[p] < kSurelySubject && stands_still(now, p))
        add(0, options.hold_backdrop);
      if (d > same) add(255, options.hold_backdrop * std::min(1.0f, d / same / 4));
      if (!guidance.empty()) add(guidance.pixels[p], options.prior);
      if (total == 0) continue;
      prior.pixels[p] = static_cast<std::uint8_t>(std::lround(sum / total));
      weight.pixels[p] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, total / most)));
    }
    return most;
  }
};

Result<void> ClosedFormVideoOptions::check() const {
  if (Result<void> ok = refine.solve.check(); !ok) return ok;
  if (margin < 1 || margin > 100)
    return fail(ErrorCode::InvalidArgument, text("margin is ", margin, "; it must be 1 to 100 px"));
  if (!(noise > 0) || !(same_backdrop > 0))
    return fail(ErrorCode::InvalidArgument, "the backdrop's noise and tolerance must be positive");
  return {};
}

ClosedFormVideo::ClosedFormVideo(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ClosedFormVideo::ClosedFormVideo(ClosedFormVideo&&) noexcept = default;
ClosedFormVideo& ClosedFormVideo::operator=(ClosedFormVideo&&) noexcept = default;
ClosedFormVideo::~ClosedFormVideo() = default;

Result<ClosedFormVideo> ClosedFormVideo::create(const ClosedFormVideoOptions& options) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  return ClosedFormVideo(std::move(impl));
}

Result<void> ClosedFormVideo::keyframe(const Image& picture, const Image& matte) {
  if (picture.channels != 3 || matte.empty() || !fits(matte, picture))
    return fail(ErrorCode::InvalidArgument, text("a keyframe's matte of ", matte.width, "x", matte.height,
                                                 " does not fit its picture of ", picture.width, "x",
                                                 picture.height, " with ", picture.channels, " channels"));
  if (!impl_->picture.empty() &&
      (impl_->picture.width != picture.width || impl_->picture.height != picture.height))
    impl_->seen.clear();
  impl_->remember(picture, matte);
  impl_->picture = picture;
  impl_->matte = matte;
  return {};
}

Result<Image> ClosedFormVideo::next(const Image& picture, const Image& guidance, const Image& keep) {
  Impl& s = *impl_;
  if (s.picture.empty())
    return fail(ErrorCode::InvalidArgument, "a clip is matted from a keyframe; give one first");
  if (picture.channels != 3 || picture.width != s.picture.width || picture.height != s.picture.height ||
      !fits(guidance, picture) || !fits(keep, picture))
    return fail(ErrorCode::InvalidArgument,
                text("a frame of ", picture.width, "x", picture.height, " follows one of ", s.picture.width,
                     "x", s.picture.height, "; pictures change their size within the clip"));
  const Carried carried = carry_matte(s.picture, s.matte, picture);
  const Image trimap = s.band(picture, carried, keep);
  Image prior, weight;
  ClosedFormOptions solve = s.options.refine.solve;
  solve.prior = s.opinion(picture, carried, guidance, prior, weight);
  Result<Image> matte = closed_form_matte(picture, trimap, solve, prior, weight);
  if (!matte) return matte;
  s.remember(picture, *matte);
  s.picture = picture;
  s.matte = *matte;
  return matte;
}

}  // namespace floatstage::matting
