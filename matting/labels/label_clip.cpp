// Method:  labels of a clip from key frames: carried forward, backward, and joined between them
// Paper:   X. Bai, J. Wang, D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using Localized
//          Classifiers", SIGGRAPH 2009
// Differs: both neighbouring key frames speak, each by how near it is and how well its labels reach the other
// ADR:     0274

#include "matting/labels/label_clip.h"

#include <algorithm>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/labels/label_carry.h"
#include "matting/labels/label_join.h"
#include "matting/labels/label_step.h"

namespace floatstage::matting {
namespace {

constexpr int kMostLabels = 254;
constexpr int kSmallest = 32;  // px: dense flow needs a few of its patches

struct Known {
  Image picture, labels;
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

class Follower {
 public:
  Follower(const LabelClip& clip, const std::map<int, LabelMasks>& keys, int labels, const LabelDone& done,
           const LabelClipOptions& options)
      : clip_(clip), keys_(keys), count_(labels + 1), done_(done), options_(options) {}

  Result<std::vector<LabelReturn>> run() {
    Result<Image> first = picture(keys_.begin()->first);
    if (!first) return forward(first);
    width_ = first->width;
    height_ = first->height;
    Known key{std::move(*first), Image(width_, height_, 1)};
    if (Result<void> ok = apply(keys_.begin()->first, key); !ok) return forward(ok);
    if (Result<void> ok = done_(keys_.begin()->first, key.picture, key.labels); !ok) return forward(ok);
    if (Result<void> ok = outward(key, keys_.begin()->first, -1); !ok) return forward(ok);
    int at = keys_.begin()->first;
    for (auto next = std::next(keys_.begin()); next != keys_.end(); ++next) {
      if (Result<void> ok = between(key, at, next->first); !ok) return forward(ok);
      at = next->first;
    }
    if (Result<void> ok = outward(key, at, 1); !ok) return forward(ok);
    return std::move(returns_);
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

  Result<void> apply(int frame, Known& known) const {
    for (const auto& [label, mask] : keys_.at(frame))
      if (mask.channels != 1 || mask.width != known.picture.width || mask.height != known.picture.height)
        return fail(ErrorCode::InvalidArgument,
                    text("the mask of label ", label, " in frame ", frame, " has ", mask.width, "x",
                         mask.height, " pixels of ", mask.channels, " channels; the picture has ",
                         known.picture.width, "x", known.picture.height));
    known.labels = with_masks(std::move(known.labels), keys_.at(frame));
    return {};
  }

  // The frame `to` from its neighbour.
  Result<Known> step(const Known& from, int to) const {
    Result<Image> rgb = picture(to);
    if (!rgb) return forward(rgb);
    const int reach = static_cast<int>(options_.band * std::min(width_, height_) / 2) + 1;
    CarriedLabels carried = carry_labels(from.picture, from.labels, count_, reach, *rgb);
    const std::vector<LabelHint> hints = {{std::move(carried.labels), carried.doubtful, {}},
                                          {std::move(carried.dense), std::move(carried.doubtful), {}}};
    Image labels = label_frame(*rgb, hints, {from.picture, from.labels}, count_, options_);
    return Known{std::move(*rgb), std::move(labels)};
  }

  // From a key frame to the clip's end, and back.
  Result<void> outward(const Known& key, int first, int direction) {
    const int end = direction < 0 ? 0 : clip_.frames - 1;
    if (first == end) return {};
    Known known = key;
    for (int frame = first; frame != end;) {
      Result<Known> next = step(known, frame += direction);
      if (!next) return forward(next);
      known = std::move(*next);
      if (Result<void> ok = done_(frame, known.picture, known.labels); !ok) return ok;
    }
    for (int frame = end; frame != first;) {
      Result<Known> next = step(known, frame -= direction);
      if (!next) return forward(next);
      known = std::move(*next);
    }
    LabelReturn there_and_back{first, end, std::vector<double>(static_cast<std::size_t>(count_), 0)};
    for (int l = 1; l < count_; ++l)
      there_and_back.lost[static_cast<std::size_t>(l)] =
          1 - iou(l, known.labels, [&](std::size_t p) { return key.labels.pixels[p] == l; });
    returns_.push_back(std::move(there_and_back));
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

  // The frames between two key frames, and the second of them, which `key` is afterwards.
  Result<void> between(Known& key, int first, int last) const {
    Known back;
    std::vector<Image> onward, backward;  // the frames between, in order
    for (int f = first + 1; f <= last; ++f) {
      Result<Known> next = step(key, f);
      if (!next) return forward(next);
      key = std::move(*next);
      if (f < last) onward.push_back(key.labels);
    }
    const std::vector<double> lost_onward = lost(key.labels, last);
    if (Result<void> ok = apply(last, key); !ok) return ok;
    if (Result<void> ok = done_(last, key.picture, key.labels); !ok) return ok;
    back = key;
    for (int f = last - 1; f >= first; --f) {
      Result<Known> next = step(back, f);
      if (!next) return forward(next);
      back = std::move(*next);
      if (f > first) backward.insert(backward.begin(), back.labels);
    }
    const std::vector<double> lost_backward = lost(back.labels, first);
    for (int f = first + 1; f < last; ++f) {
      Result<Image> rgb = picture(f);
      if (!rgb) return forward(rgb);
      const double way = static_cast<double>(f - first) / (last - first);
      const auto i = static_cast<std::size_t>(f - first - 1);
      const Image labels = join_labels(*rgb, {onward[i], lost_onward, way},
                                       {backward[i], lost_backward, 1 - way}, count_, options_);
      if (Result<void> ok = done_(f, *rgb, labels); !ok) return ok;
    }
    return {};
  }

  // What of each label was lost on the way to a key frame, 1 where nobody says: 1 - IoU with its mask.
  std::vector<double> lost(const Image& carried, int frame) const {
    std::vector<double> out(static_cast<std::size_t>(count_), 1);
    for (const auto& [label, mask] : keys_.at(frame))
      out[static_cast<std::size_t>(label)] =
          1 - iou(label, carried, [&](std::size_t p) { return mask.pixels[p] > 127; });
    return out;
  }

  const LabelClip& clip_;
  const std::map<int, LabelMasks>& keys_;
  const int count_;
  const LabelDone& done_;
  const LabelClipOptions& options_;
  int width_ = 0, height_ = 0;
  std::vector<LabelReturn> returns_;
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
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (labels < 1 || labels > kMostLabels)
    return fail(ErrorCode::InvalidArgument, text(labels, " labels; there are 1 to ", kMostLabels));
  bool any = false;
  for (const auto& [frame, masks] : keys) {
    if (frame < 0 || frame >= clip.frames)
      return fail(ErrorCode::InvalidArgument,
                  text("a mask of frame ", frame, "; the clip has ", clip.frames, " frames, counted from 0"));
    for (const auto& [label, mask] : masks)
      if (label < 1 || label > labels)
        return fail(ErrorCode::InvalidArgument, text("label ", label, " of ", labels));
    any |= !masks.empty();
  }
  if (!any) return fail(ErrorCode::InvalidArgument, "no frame's mask is given; one is needed to follow it");
  return Follower(clip, keys, labels, done, options).run();
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
