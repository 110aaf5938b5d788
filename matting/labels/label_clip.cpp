// Method:  labels of a clip from key frames: carried forward, backward, and joined between them
// Paper:   X. Bai, J. Wang, D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using Localized
//          Classifiers", SIGGRAPH 2009
// Differs: both neighbouring key frames speak, each by how near it is and how well its labels reach the other
// ADR:     0274, 0333, 0338

#include "matting/labels/label_clip.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/image_mat.h"
#include "matting/labels/label_carry.h"
#include "matting/labels/label_descent.h"
#include "matting/labels/label_join.h"
#include "matting/labels/label_step.h"

namespace floatstage::matting {
namespace {

constexpr int kMostLabels = 254;
constexpr int kSmallest = 32;  // px: dense flow needs a few of its patches

struct Known {
  Image picture, labels;
  LabelDescent descent = {};
  std::vector<double> unfound = {};  // of each label, as in CarriedLabels
};

// A key frame's labels: its masks over what was carried there.
Image with_masks(Image labels, const LabelMasks& masks) {
  for (std::uint8_t& l : labels.pixels)
    if (masks.contains(l)) l = 0;
  for (const auto& [label, mask] : masks)
    for (std::size_t p = 0; p < labels.pixels.size(); ++p)
      if (mask.pixels[p] > 127) labels.pixels[p] = static_cast<std::uint8_t>(label);
  return labels;
}

// A frame whose labels are held to be right, and masks of those that somebody said.
struct Key {
  int frame = 0;
  Known known;
  LabelMasks said;
};

class Follower {
 public:
  Follower(const LabelClip& clip, const std::map<int, LabelMasks>& keys, const LabelStrokes& strokes,
           int labels, const LabelDone& done, const LabelClipOptions& options)
      : clip_(clip), keys_(keys), strokes_(strokes), count_(labels + 1), done_(done), options_(options) {}

  Result<LabelsFollowed> run() {
    const int first = keys_.empty() ? strokes_.begin()->first : keys_.begin()->first;
    Result<Image> rgb = picture(first);
    if (!rgb) return forward(rgb);
    width_ = rgb->width;
    height_ = rgb->height;
    Result<Key> begin = key_of(first, {std::move(*rgb), Image(width_, height_, 1)});
    if (!begin) return forward(begin);
    Key key = std::move(*begin);
    if (Result<void> ok = done_(first, key.known.picture, key.known.labels); !ok) return forward(ok);
    if (Result<void> ok = outward(key, -1); !ok) return forward(ok);
    for (auto next = keys_.upper_bound(first); next != keys_.end(); ++next)
      if (Result<void> ok = between(key, next->first, nullptr); !ok) return forward(ok);
    if (Result<void> ok = outward(std::move(key), 1); !ok) return forward(ok);
    return std::move(out_);
  }

 private:
  Result<Image> picture(int frame) const {
    Result<Image> rgb = clip_.picture(frame);
    if (!rgb) return rgb;
    if (rgb->channels != 3 || std::min(rgb->width, rgb->height) < kSmallest ||
        (width_ > 0 && (rgb->width != width_ || rgb->height != height_)))
      return fail(
          ErrorCode::InvalidArgument,
          text("frame ", frame, " has ", rgb->width, "x", rgb->height, " pixels of ", rgb->channels,
               " channels; a clip's pictures are RGB, of one size, at least ", kSmallest, " px a side"));
    return rgb;
  }

  // A frame in which somebody gave masks, or the first one, from what was carried there.
  Result<Key> key_of(int frame, Known known) {
    Key key{frame, std::move(known), {}};
    if (const auto masks = keys_.find(frame); masks != keys_.end()) {
      for (const auto& [label, mask] : masks->second)
        if (mask.channels != 1 || mask.width != key.known.picture.width ||
            mask.height != key.known.picture.height)
          return fail(ErrorCode::InvalidArgument,
                      text("the mask of label ", label, " in frame ", frame, " has ", mask.width, "x",
                           mask.height, " pixels of ", mask.channels, " channels; the picture has ",
                           key.known.picture.width, "x", key.known.picture.height));
      key.said = masks->second;
      key.known.labels = with_masks(std::move(key.known.labels), key.said);
    }
    key.known.descent = LabelDescent(width_, height_);
    if (!strokes_.contains(frame)) return key;
    const Result<Image> stroked = stroke(frame, key.known.picture, key.known.labels);
    if (!stroked) return forward(stroked);
    for (int l = 1; l < count_; ++l)
      if (Image now = mask_of(*stroked, l); now != mask_of(key.known.labels, l)) key.said[l] = std::move(now);
    key.known.labels = *stroked;
    return key;
  }

  static Image mask_of(const Image& labels, int label) {
    Image mask(labels.width, labels.height, 1);
    for (std::size_t p = 0; p < mask.pixels.size(); ++p) mask.pixels[p] = labels.pixels[p] == label ? 255 : 0;
    return mask;
  }

  // The labels of a frame with strokes as those say.
  Result<Image> stroke(int frame, const Image& picture, const Image& labels) {
    Result<StrokedLabels> stroked = stroke_labels(picture, labels, strokes_.at(frame));
    if (!stroked) return forward(stroked);
    Image out = std::move(stroked->labels);
    out_.heard[frame] = {{}, std::move(stroked->effects), std::move(stroked->turned)};
    return out;
  }

  // A key frame where strokes change the labels of a frame; none where they say what is so.
  Result<std::optional<Key>> corrected(int frame, const Image& picture, const Image& labels) {
    Result<Image> stroked = stroke(frame, picture, labels);
    if (!stroked) return forward(stroked);
    if (*stroked == labels) return std::optional<Key>();
    Key key{frame, {picture, std::move(*stroked), LabelDescent(width_, height_)}, {}};
    for (int l = 1; l < count_; ++l) key.said[l] = mask_of(key.known.labels, l);
    return std::optional<Key>(std::move(key));
  }

  // Labels to learn colours from: what came to light lately teaches nothing of the label that took it.
  Image proven(const Known& known) const {
    Image out = known.labels;
    const Image fresh = known.descent.fresh(known.labels, count_);
    for (std::size_t p = 0; p < out.pixels.size(); ++p)
      if (fresh.pixels[p]) out.pixels[p] = static_cast<std::uint8_t>(count_);
    return out;
  }

  // The frame `to` from its neighbour.
  Result<Known> step(const Known& from, int to) const {
    Result<Image> rgb = picture(to);
    if (!rgb) return forward(rgb);
    const int reach = static_cast<int>(options_.band * std::min(width_, height_) / 2) + 1;
    CarriedLabels carried = carry_labels(from.picture, from.labels, count_, reach, *rgb);
    LabelDescent descent = from.descent;
    descent.follow(carried.back);
    Image fresh = descent.fresh(carried.labels, count_);
    as_mat(fresh) |= as_mat(descent.fresh(carried.dense, count_));
    const std::vector<LabelHint> hints = {{std::move(carried.labels), carried.doubtful, {}, fresh},
                                          {std::move(carried.dense), std::move(carried.doubtful), {}, fresh}};
    Image labels = label_frame(*rgb, hints, {from.picture, proven(from)}, count_, options_);
    return Known{std::move(*rgb), std::move(labels), std::move(descent), std::move(carried.unfound)};
  }

  // From a key frame to the clip's end, and back; from the last frame on that way that strokes change, if
  // any.
  Result<void> outward(Key key, int direction) {
    const int end = direction < 0 ? 0 : clip_.frames - 1;
    if (key.frame == end) return {};
    int strokes_end = key.frame;  // the last frame on the way that has any
    for (const auto& [frame, said] : strokes_)
      if ((frame - strokes_end) * direction > 0 && (end - frame) * direction >= 0) strokes_end = frame;
    LabelReturn there_and_back{key.frame, end, std::vector<double>(static_cast<std::size_t>(count_), 0),
                               std::vector<LabelReturn::Jump>(static_cast<std::size_t>(count_))};
    Known known = key.known;
    std::vector<Image> held;  // until no strokes come any more
    for (int frame = key.frame; frame != end;) {
      Result<Known> next = step(known, frame += direction);
      if (!next) return forward(next);
      known = std::move(*next);
      for (std::size_t l = 0; l < known.unfound.size(); ++l)
        if (LabelReturn::Jump& jump = there_and_back.jumps[l]; known.unfound[l] > jump.share)
          jump = {known.unfound[l], frame};
      if (strokes_.contains(frame)) {
        Result<std::optional<Key>> now = corrected(frame, known.picture, known.labels);
        if (!now) return forward(now);
        if (*now) {
          if (Result<void> ok = between(key, frame, &**now); !ok) return ok;
          return outward(std::move(key), direction);
        }
      }
      if ((strokes_end - frame) * direction > 0) {
        held.push_back(known.labels);
        continue;
      }
      for (std::size_t i = 0; i < held.size(); ++i) {
        const int f = key.frame + direction * static_cast<int>(i + 1);
        const Result<Image> rgb = picture(f);
        if (!rgb) return forward(rgb);
        if (Result<void> ok = done_(f, *rgb, held[i]); !ok) return ok;
      }
      held.clear();
      if (Result<void> ok = done_(frame, known.picture, known.labels); !ok) return ok;
    }
    for (int frame = end; frame != key.frame;) {
      Result<Known> next = step(known, frame -= direction);
      if (!next) return forward(next);
      known = std::move(*next);
    }
    for (int l = 1; l < count_; ++l)
      there_and_back.lost[static_cast<std::size_t>(l)] =
          1 - iou(l, known.labels, [&](std::size_t p) { return key.known.labels.pixels[p] == l; });
    out_.returns.push_back(std::move(there_and_back));
    return {};
  }

  // Of a label, with what `is` says of each pixel; 1 where neither has any.
  template <class Is>
  static double iou(int label, const Image& labels, const Is& is) {
    long both = 0, either = 0;
    for (std::size_t p = 0; p < labels.pixels.size(); ++p) {
      const bool said = labels.pixels[p] == label, really = is(p);
      both += said && really, either += said || really;
    }
    return either ? static_cast<double>(both) / static_cast<double>(either) : 1;
  }

  // The frames between two key frames, and the second of them, which `key` is afterwards: `there`, or, where
  // that is null, the frame `last` with its masks over what is carried there.
  Result<void> between(Key& key, int last, const Key* there) {
    const int first = key.frame, by = last < first ? -1 : 1;
    const auto frames = static_cast<std::size_t>(std::abs(last - first) - 1);
    std::vector<Image> onward, backward(frames);  // the frames between, in order of the way
    Known known = key.known;
    for (int f = first + by;; f += by) {
      Result<Known> next = step(known, f);
      if (!next) return forward(next);
      known = std::move(*next);
      if (f == last) break;
      onward.push_back(known.labels);
    }
    Result<Key> end = there ? Result<Key>(*there) : key_of(last, known);
    if (!end) return forward(end);
    const std::vector<double> lost_onward = lost(known.labels, end->said);
    known = end->known;
    for (int f = last - by;; f -= by) {
      Result<Known> next = step(known, f);
      if (!next) return forward(next);
      known = std::move(*next);
      if (f == first) break;
      backward[static_cast<std::size_t>(std::abs(f - first) - 1)] = known.labels;
    }
    const std::vector<double> lost_backward = lost(known.labels, key.said);
    std::vector<Image> joined;
    for (int f = first + by; f != last; f += by) {
      Result<Image> rgb = picture(f);
      if (!rgb) return forward(rgb);
      const double way = static_cast<double>(f - first) / (last - first);
      const auto i = static_cast<std::size_t>(std::abs(f - first) - 1);
      joined.push_back(join_labels(*rgb, {onward[i], lost_onward, way}, {backward[i], lost_backward, 1 - way},
                                   count_, options_));
      onward[i] = backward[i] = {};
      if (!strokes_.contains(f)) continue;
      Result<std::optional<Key>> middle = corrected(f, *rgb, joined.back());
      if (!middle) return forward(middle);
      if (!*middle) continue;
      if (Result<void> ok = between(key, f, &**middle); !ok) return ok;
      return between(key, last, there);
    }
    for (int f = first + by; f != last; f += by) {
      Result<Image> rgb = picture(f);
      if (!rgb) return forward(rgb);
      if (Result<void> ok = done_(f, *rgb, joined[static_cast<std::size_t>(std::abs(f - first) - 1)]); !ok)
        return ok;
    }
    key = std::move(*end);
    return done_(last, key.known.picture, key.known.labels);
  }

  // What of each label was lost on the way to a key frame, 1 where nobody says: 1 - IoU with its mask.
  std::vector<double> lost(const Image& carried, const LabelMasks& said) const {
    std::vector<double> out(static_cast<std::size_t>(count_), 1);
    for (const auto& [label, mask] : said)
      out[static_cast<std::size_t>(label)] =
          1 - iou(label, carried, [&](std::size_t p) { return mask.pixels[p] > 127; });
    return out;
  }

  const LabelClip& clip_;
  const std::map<int, LabelMasks>& keys_;
  const LabelStrokes& strokes_;
  const int count_;
  const LabelDone& done_;
  const LabelClipOptions& options_;
  int width_ = 0, height_ = 0;
  LabelsFollowed out_;
};

}  // namespace

Result<void> LabelClipOptions::check() const {
  if (!(band > 0 && band <= 0.5 && slack > 0 && uncovered >= 0 && color >= 0 && smooth >= 0))
    return fail(ErrorCode::InvalidArgument,
                "following labels: a band of 0 to 0.5, slack above 0, weights from 0");
  return {};
}

Result<std::vector<LabelReturn>> follow_labels(const LabelClip& clip, const std::map<int, LabelMasks>& keys,
                                               int labels, const LabelDone& done,
                                               const LabelClipOptions& options) {
  Result<LabelsFollowed> followed = follow_labels(clip, keys, {}, labels, done, options);
  if (!followed) return forward(followed);
  return std::move(followed->returns);
}

Result<LabelsFollowed> follow_labels(const LabelClip& clip, const std::map<int, LabelMasks>& keys,
                                     const LabelStrokes& strokes, int labels, const LabelDone& done,
                                     const LabelClipOptions& options) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (labels < 1 || labels > kMostLabels)
    return fail(ErrorCode::InvalidArgument, text(labels, " labels; there are 1 to ", kMostLabels));
  const auto check = [&](int frame, int label, int least, const char* what) -> Result<void> {
    if (frame < 0 || frame >= clip.frames)
      return fail(ErrorCode::InvalidArgument,
                  text(what, " of frame ", frame, "; the clip has ", clip.frames, " frames, counted from 0"));
    if (label < least || label > labels)
      return fail(ErrorCode::InvalidArgument, text("label ", label, " of ", labels));
    return {};
  };
  for (const auto& [frame, of] : keys) {
    if (Result<void> ok = check(frame, 1, 1, "a mask"); !ok) return forward(ok);
    for (const auto& [label, mask] : of)
      if (Result<void> ok = check(frame, label, 1, "a mask"); !ok) return forward(ok);
  }
  bool any = false;
  for (const auto& [frame, of] : keys) any |= !of.empty();
  for (const auto& [frame, of] : strokes)
    for (const LabelStroke& stroke : of) {
      if (Result<void> ok = check(frame, stroke.label, 0, "a stroke"); !ok) return forward(ok);
      any |= stroke.stroke.label == MatteLabel::Foreground;
    }
  if (!any) return fail(ErrorCode::InvalidArgument, "no frame's mask is given; one is needed to follow it");
  return Follower(clip, keys, strokes, labels, done, options).run();
}

Result<std::vector<Image>> label_mattes(const Image& picture, const Image& labels, int count) {
  std::vector<Image> mattes;
  for (int l = 1; l <= count; ++l) {
    Image mask(labels.width, labels.height, 1);
    for (std::size_t p = 0; p < mask.pixels.size(); ++p) mask.pixels[p] = labels.pixels[p] == l ? 255 : 0;
    Result<Image> matte = refine_matte(picture, mask);
    if (!matte) return forward(matte);
    mattes.push_back(std::move(*matte));
  }
  for (std::size_t p = 0; p < labels.pixels.size(); ++p) {
    int sum = 0;
    for (const Image& m : mattes) sum += m.pixels[p];
    if (sum > 255)
      for (Image& m : mattes) m.pixels[p] = static_cast<std::uint8_t>(m.pixels[p] * 255 / sum);
  }
  return mattes;
}

}  // namespace floatstage::matting
