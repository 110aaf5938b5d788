// Method:  one subject through a clip by minimum cuts, colours and cut in turns
// Paper:   after C. Rother, V. Kolmogorov, A. Blake, "GrabCut", 2004
// Differs: the backdrop's model is each place's own and holds only what was seen; others who move are left
//          alone
// ADR:     0102

#include "matting/video/segment_clip.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/text.h"
#include "matting/color_model.h"
#include "matting/frame_cut.h"
#include "matting/image_mat.h"
#include "matting/keyers/backdrop_memory.h"
#include "matting/keyers/plate.h"
#include "matting/picture_scale.h"
#include "matting/video/flow_carry.h"

namespace floatstage::matting {
namespace {

constexpr std::size_t kMostBytes = 400u << 20;  // of photographs kept in working size
constexpr float kCertain = 1000;                // log-odds of a stroke
constexpr float kColor = 3;           // log-odds at most by colour where the backdrop is unknown …
constexpr float kColorBefore = 0.5f;  // … of which so much counts where it is known
constexpr double kReach =
    0.05;  // of the longer side: how far from the neighbours' mattes the subject is looked for
constexpr double kFirstReach = 0.3;   // likewise from the click, in the first frame
constexpr double kNear = 0.008;       // likewise what is too near the subject to be held for backdrop
constexpr int kStillFor = 10;         // frames that a place must look the same to be called still …
constexpr float kStill = 7;           // … to so many 8-bit steps a channel
constexpr float kStillOdds = -1.5f;   // log-odds of a still place whose backdrop is unknown
constexpr float kStillColors = 0.1f;  // share of the subject's still pixels in its colours
constexpr int kFirstCuts = 4;

bool marks(const MatteConstraint& o, std::size_t p) { return o.weight.empty() || o.weight.pixels[p] > 0; }

bool marks_subject(const MatteConstraint& o) {
  for (std::size_t p = 0; p < o.opacity.pixels.size(); ++p)
    if (marks(o, p) && o.opacity.pixels[p] >= 128) return true;
  return false;
}

struct Colors {
  ColorModel subject, backdrop;
  float odds(const std::uint8_t* rgb) const {
    return std::clamp(std::log(subject.likelihood(rgb) / backdrop.likelihood(rgb)), -kColor, kColor);
  }
};

class Cutter {
 public:
  Cutter(const MattingClip& clip, const SegmentClipOptions& options, int width, int height)
      : clip_(clip), options_(options), width_(width), height_(height), memory_(0, 0) {
    const double shrink =
        std::min(1.0, std::sqrt(options.working_pixels / (static_cast<double>(width) * height)));
    w_ = std::max(16, static_cast<int>(std::lround(width * shrink)));
    h_ = std::max(16, static_cast<int>(std::lround(height * shrink)));
    longer_ = std::max(w_, h_);
    pictures_.resize(static_cast<std::size_t>(clip.frames));
    mattes_.resize(pictures_.size());
    keep_ = pictures_.size() * static_cast<std::size_t>(w_) * static_cast<std::size_t>(h_) * 3 <= kMostBytes;
  }

  void say(int frame, const MatteConstraint& opinion) { said_[frame] = scaled(opinion, w_, h_); }

  Result<std::vector<Image>> run(const std::function<bool(int, int)>& done) {
    first_ = 0;
    for (const auto& [frame, opinion] : said_)
      if (marks_subject(opinion)) {
        first_ = frame;
        break;
      }
    for (int round = 0; round < options_.rounds; ++round) {
      if (Result<void> ok = round == 0 ? begin() : relearn(); !ok) return forward(ok);
      const auto visit = [&](int frame, int from) -> Result<void> {
        if (Result<void> ok = cut(frame, from, round); !ok) return ok;
        if (done && !done(round, frame))
          return fail(ErrorCode::Cancelled, "stopped while the subject was cut out");
        return {};
      };
      for (int f = first_ + (round == 0); f < clip_.frames; ++f)
        if (Result<void> ok = visit(f, f - 1); !ok) return forward(ok);
      for (int f = first_ - 1; f >= 0; --f)
        if (Result<void> ok = visit(f, f + 1); !ok) return forward(ok);
    }
    return std::move(mattes_);
  }

 private:
  int px(double share) const { return std::max(1, static_cast<int>(std::lround(share * longer_))); }
  std::size_t pixels() const { return static_cast<std::size_t>(w_) * static_cast<std::size_t>(h_); }

  Result<Image> picture(int frame) {
    Image& kept = pictures_[static_cast<std::size_t>(frame)];
    if (!kept.empty()) return kept;
    Result<Image> large = clip_.photograph(frame);
    if (!large) return large;
    if (large->width != width_ || large->height != height_ || large->channels != 3)
      return fail(ErrorCode::BadData,
                  text("frame ", frame, ": the photograph is ", large->width, "x", large->height, " with ",
                       large->channels, " channels, the first one is ", width_, "x", height_,
                       " in RGB; a clip has one size"));
    Image small = scaled(*large, w_, h_);
    if (keep_) kept = small;
    return small;
  }

  // Frames spread over the clip.
  std::vector<int> training_frames() const {
    std::vector<int> frames;
    const int wanted = std::min(options_.training_frames, clip_.frames);
    for (int i = 0; i < wanted; ++i)
      frames.push_back(static_cast<int>((2L * i + 1) * clip_.frames / (2L * wanted)));
    return frames;
  }

  void apply_strokes(int frame, std::vector<float>& odds) const {
    const auto found = said_.find(frame);
    if (found == said_.end()) return;
    for (std::size_t p = 0; p < odds.size(); ++p)
      if (marks(found->second, p)) odds[p] = found->second.opacity.pixels[p] >= 128 ? kCertain : -kCertain;
  }

  // Only what hangs together with the neighbours' mattes, or is marked, is the subject.
  void keep_connected(int frame, const Image& expected, Image& matte) const {
    cv::Mat labels;
    const int count = cv::connectedComponents(as_mat(matte), labels, 8, CV_32S, cv::CCL_SAUF);
    std::vector<long> overlap(static_cast<std::size_t>(count)), area(overlap.size());
    const auto found = said_.find(frame);
    for (std::size_t p = 0; p < matte.pixels.size(); ++p) {
      const auto label =
          static_cast<std::size_t>(labels.at<int>(static_cast<int>(p) / w_, static_cast<int>(p) % w_));
      ++area[label];
      if (!expected.empty() && expected.pixels[p] >= 128) ++overlap[label];
      if (found != said_.end() && marks(found->second, p) && found->second.opacity.pixels[p] >= 128)
        overlap[label] = area[0] + static_cast<long>(pixels());
    }
    for (std::size_t p = 0; p < matte.pixels.size(); ++p) {
      const auto label =
          static_cast<std::size_t>(labels.at<int>(static_cast<int>(p) / w_, static_cast<int>(p) % w_));
      if (label && 5 * overlap[label] < area[label]) matte.pixels[p] = 0;
    }
  }

  // The first frame knows nothing but a click. What never changed is backdrop, what moves and is near the
  // click is subject; from there, colours and cut take turns.
  Result<void> begin() {
    std::vector<Image> seen;
    for (const int f : training_frames()) {
      Result<Image> p = picture(f);
      if (!p) return forward(p);
      seen.push_back(std::move(*p));
    }
    Result<Plate> plate = learn_plate(seen);
    if (!plate) return forward(plate);
    BackdropMemory guess(w_, h_);
    if (Result<void> ok = guess.learn(seen, std::vector<Image>(seen.size(), Image(w_, h_, 1))); !ok)
      return ok;
    Result<Image> now = picture(first_);
    if (!now) return forward(now);
    Result<std::vector<std::uint8_t>> still = stands_still(first_, *now);
    if (!still) return forward(still);

    Image click(w_, h_, 1);
    const MatteConstraint& said = said_.at(first_);
    for (std::size_t p = 0; p < pixels(); ++p)
      click.pixels[p] = marks(said, p) && said.opacity.pixels[p] >= 128 ? 255 : 0;
    const Image around = grown(click, px(kFirstReach)), close = grown(click, px(0.015));
    CutEvidence evidence{std::vector<float>(pixels()), std::vector<std::uint8_t>(pixels()), guess.calm(*now)};
    std::vector<float> motion(pixels());
    Image matte(w_, h_, 1);
    for (std::size_t p = 0; p < pixels(); ++p) {
      const float odds = guess.odds(p, now->pixels.data() + 3 * p);
      motion[p] = (*still)[p] ? std::min(odds, kStillOdds) : odds;
      motion[p] = std::clamp(motion[p], -1.5f, 3.0f);
      evidence.asked[p] = around.pixels[p] != 0;
      matte.pixels[p] = around.pixels[p] && (close.pixels[p] || (odds > 0 && !(*still)[p])) ? 255 : 0;
    }
    for (int i = 0; i < kFirstCuts; ++i) {
      Colors colors;
      for (std::size_t p = 0; p < pixels(); ++p)
        if (around.pixels[p])
          (matte.pixels[p] ? colors.subject : colors.backdrop)
              .add(now->pixels.data() + 3 * p, i == 0 && close.pixels[p] ? 3.0f : 1.0f);
      colors.subject.finish();
      colors.backdrop.finish();
      for (std::size_t p = 0; p < pixels(); ++p)
        evidence.odds[p] = motion[p] + colors.odds(now->pixels.data() + 3 * p);
      apply_strokes(first_, evidence.odds);
      matte = cut_frame(*now, evidence, options_.smooth);
      keep_connected(first_, Image(w_, h_, 1), matte);
    }
    memory_ = BackdropMemory(w_, h_);
    memory_.observe(*now, grown(matte, px(kNear)));
    colors_ = Colors();
    teach(*now, matte, *still);
    colors_.subject.finish();
    colors_.backdrop.finish();
    mattes_[static_cast<std::size_t>(first_)] = std::move(matte);
    return {};
  }

  // Where nothing changes for a while, before or after: more likely backdrop, as nobody stands quite still.
  Result<std::vector<std::uint8_t>> stands_still(int frame, const Image& now) {
    std::vector<std::uint8_t> still(pixels());
    for (const int direction : {-1, 1}) {
      if (frame + direction * kStillFor < 0 || frame + direction * kStillFor >= clip_.frames) continue;
      std::vector<std::uint8_t> same(pixels(), 1);
      for (int d = 2; d <= kStillFor; d += 2) {
        Result<Image> other = picture(frame + direction * d);
        if (!other) return forward(other);
        for (std::size_t p = 0; p < pixels(); ++p)
          for (std::size_t c = 3 * p; c < 3 * p + 3; ++c)
            same[p] = same[p] && std::abs(now.pixels[c] - other->pixels[c]) <= kStill;
      }
      for (std::size_t p = 0; p < pixels(); ++p) still[p] |= same[p];
    }
    return still;
  }

  // Colours of the subject, and of what is near it.
  void teach(const Image& picture, const Image& matte, const std::vector<std::uint8_t>& still) {
    const Image near = grown(matte, px(kReach)), edge = grown(matte, px(kNear));
    for (std::size_t p = 0; p < pixels(); ++p) {
      if (matte.pixels[p])
        colors_.subject.add(picture.pixels.data() + 3 * p, still[p] ? kStillColors : 1);
      else if (near.pixels[p] && !edge.pixels[p])
        colors_.backdrop.add(picture.pixels.data() + 3 * p);
    }
  }

  Result<void> relearn() {
    std::vector<Image> seen, near;
    colors_ = Colors();
    for (const int f : training_frames()) {
      Result<Image> p = picture(f);
      if (!p) return forward(p);
      const Image& matte = mattes_[static_cast<std::size_t>(f)];
      Result<std::vector<std::uint8_t>> still = stands_still(f, *p);
      if (!still) return forward(still);
      teach(*p, matte, *still);
      near.push_back(grown(matte, px(kNear)));
      seen.push_back(std::move(*p));
    }
    colors_.subject.finish();
    colors_.backdrop.finish();
    return memory_.learn(seen, near);
  }

  // Flow is only wanted where the subject is.
  Carried carry(const Image& from, const Image& matte, const Image& to) const {
    cv::Rect box = cv::boundingRect(as_mat(matte));
    Carried all{Image(w_, h_, 1), Image(w_, h_, 1)};
    if (box.empty()) return all;
    const int margin = std::max(16, px(kReach));
    box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
          cv::Rect(0, 0, w_, h_);
    const auto part = [&](const Image& picture) {
      Image out(box.width, box.height, picture.channels);
      as_mat(picture)(box).copyTo(as_mat(out));
      return out;
    };
    const Carried carried = carry_matte(part(from), part(matte), part(to));
    as_mat(carried.matte).copyTo(as_mat(all.matte)(box));
    as_mat(carried.doubt).copyTo(as_mat(all.doubt)(box));
    return all;
  }

  Result<void> cut(int frame, int from, int round) {
    Result<Image> now = picture(frame);
    if (!now) return forward(now);
    // What the frame before says, and, once there is one, the matte of the frame after.
    std::vector<float> prior(pixels());
    Image expected(w_, h_, 1);
    std::vector<int> neighbours;
    for (const int f : {from, 2 * frame - from})
      if (f >= 0 && f < clip_.frames && (f == from || round > 0)) neighbours.push_back(f);
    for (const int f : neighbours) {
      Result<Image> other = picture(f);
      if (!other) return forward(other);
      const Carried carried = carry(*other, mattes_[static_cast<std::size_t>(f)], *now);
      for (std::size_t p = 0; p < pixels(); ++p) {
        const float sure = carried.doubt.pixels[p] ? 0.15f : 1;
        prior[p] += static_cast<float>(options_.carried) * sure * (carried.matte.pixels[p] / 127.5f - 1) /
                    static_cast<float>(neighbours.size());
        expected.pixels[p] = std::max(expected.pixels[p], carried.matte.pixels[p]);
      }
    }
    const Image reach = grown(expected, px(kReach));
    Result<std::vector<std::uint8_t>> still = stands_still(frame, *now);
    if (!still) return forward(still);
    CutEvidence evidence{std::move(prior), std::vector<std::uint8_t>(pixels()), memory_.calm(*now)};
    for (std::size_t p = 0; p < pixels(); ++p) {
      const std::uint8_t* rgb = now->pixels.data() + 3 * p;
      evidence.asked[p] = reach.pixels[p] != 0;
      evidence.odds[p] += memory_.odds(p, rgb) + colors_.odds(rgb) * (memory_.known(p) ? kColorBefore : 1);
      if ((*still)[p] && !memory_.known(p)) evidence.odds[p] += kStillOdds;
    }
    apply_strokes(frame, evidence.odds);
    if (said_.count(frame))
      for (std::size_t p = 0; p < pixels(); ++p)
        if (evidence.odds[p] >= kCertain) evidence.asked[p] = 1;
    Image matte = cut_frame(*now, evidence, options_.smooth);
    keep_connected(frame, expected, matte);
    if (round == 0) memory_.observe(*now, grown(matte, px(kNear)));
    mattes_[static_cast<std::size_t>(frame)] = std::move(matte);
    return {};
  }

  const MattingClip& clip_;
  SegmentClipOptions options_;
  int width_, height_, w_ = 0, h_ = 0, longer_ = 0, first_ = 0;
  bool keep_ = false;
  std::map<int, MatteConstraint> said_;
  std::vector<Image> pictures_, mattes_;
  BackdropMemory memory_;
  Colors colors_;
};

}  // namespace

Result<void> SegmentClipOptions::check() const {
  const struct {
    const char* name;
    double value, low, high;
  } ranges[] = {{"working_pixels", static_cast<double>(working_pixels), 1000, 4e6},
                {"rounds", static_cast<double>(rounds), 1, 10},
                {"training_frames", static_cast<double>(training_frames), 8, 1000},
                {"smooth", smooth, 0, 100},
                {"carried", carried, 0, 100}};
  for (const auto& r : ranges)
    if (!(r.value >= r.low && r.value <= r.high))
      return fail(ErrorCode::InvalidArgument, text("cutting a clip: ", r.name, " is ", r.value,
                                                   "; it must lie between ", r.low, " and ", r.high));
  return {};
}

Result<std::vector<Image>> segment_clip(const MattingClip& clip,
                                        const std::map<int, MatteConstraint>& strokes,
                                        const SegmentClipOptions& options,
                                        const std::function<bool(int, int)>& done) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (clip.frames <= 0 || !clip.photograph)
    return fail(ErrorCode::InvalidArgument, "there is no frame in the clip to be cut");
  bool subject = false;
  for (const auto& [frame, opinion] : strokes) {
    if (frame < 0 || frame >= clip.frames)
      return fail(ErrorCode::InvalidArgument,
                  text("there is no frame ", frame, " in a clip of ", clip.frames));
    subject = subject || marks_subject(opinion);
  }
  if (!subject)
    return fail(ErrorCode::InvalidArgument, "no stroke marks the subject; click on it in one frame at least");
  const Result<Image> first = clip.photograph(0);
  if (!first) return forward(first);
  if (first->width < 16 || first->height < 16 || first->channels != 3)
    return fail(ErrorCode::BadData,
                text("the first photograph is ", first->width, "x", first->height, " with ", first->channels,
                     " channels; RGB of 16x16 at least is wanted"));
  Cutter cutter(clip, options, first->width, first->height);
  for (const auto& [frame, opinion] : strokes) cutter.say(frame, opinion);
  return cutter.run(done);
}

}  // namespace floatstage::matting
