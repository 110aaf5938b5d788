// Method:  strokes about one of several labels, each as a stroke about a matte of its own
// ADR:     0302, 0338

#include "matting/labels/label_strokes.h"

#include <algorithm>
#include <set>

#include "matting/labels/label_distance.h"

namespace floatstage::matting {
namespace {

constexpr std::uint8_t kUnsaid = 255;  // of a pixel: nobody said whose it is

Image print_of(const MatteStroke& stroke, int width, int height) {
  Image map(width, height, 1, 128);
  paint_strokes({stroke}, 1, map);
  for (std::uint8_t& m : map.pixels) m = m == 128 ? 0 : 255;
  return map;
}

Image is(const Image& labels, int label) {
  Image out(labels.width, labels.height, 1);
  for (std::size_t p = 0; p < out.pixels.size(); ++p) out.pixels[p] = labels.pixels[p] == label ? 255 : 0;
  return out;
}

// The label that a stroke of nobody in particular lies on with most of its pixels, else the nearest one.
int label_at(const Image& labels, const Image& print) {
  std::vector<long> on(256, 0);
  for (std::size_t p = 0; p < labels.pixels.size(); ++p) on[labels.pixels[p]] += print.pixels[p] != 0;
  if (const auto most = std::max_element(on.begin() + 1, on.end()); *most > 0)
    return static_cast<int>(most - on.begin());
  const std::vector<float> away =
      distance_to(labels.width, labels.height, [&](int x, int y) { return *print.at(x, y) != 0; });
  std::size_t best = labels.pixels.size();
  for (std::size_t p = 0; p < labels.pixels.size(); ++p)
    if (labels.pixels[p] && (best == labels.pixels.size() || away[p] < away[best])) best = p;
  return best == labels.pixels.size() ? 1 : labels.pixels[best];
}

class Stroker {
 public:
  Stroker(const Image& picture, const Image& labels)
      : picture_(picture), said_(labels.width, labels.height, 1, kUnsaid) {
    out_.labels = labels;
  }

  Result<void> apply(const LabelStroke& said) {
    const Image print = print_of(said.stroke, picture_.width, picture_.height);
    const Image before = out_.labels;
    if (said.stroke.label == MatteLabel::Background) {
      std::set<int> under;
      for (std::size_t p = 0; p < print.pixels.size(); ++p)
        if (print.pixels[p] && out_.labels.pixels[p]) under.insert(out_.labels.pixels[p]);
      for (const int label : under)
        if (Result<void> ok = turn(said.stroke, label, 0); !ok) return ok;
      finish(print, before, 0);
      return {};
    }
    const int label = said.label > 0 ? said.label : label_at(out_.labels, print);
    if (Result<void> ok = turn(said.stroke, label, label); !ok) return ok;
    finish(print, before, label);
    return {};
  }

  StrokedLabels take() { return std::move(out_); }

 private:
  // Pixels that turn to the stroke's side in the matte of `of` become `to`.
  Result<void> turn(const MatteStroke& stroke, int of, int to) {
    Image fixed(picture_.width, picture_.height, 1, 128);
    for (std::size_t p = 0; p < fixed.pixels.size(); ++p)
      if (said_.pixels[p] != kUnsaid) fixed.pixels[p] = said_.pixels[p] == of ? 255 : 0;
    const Image print = print_of(stroke, picture_.width, picture_.height);
    for (std::size_t p = 0; p < fixed.pixels.size(); ++p)
      if (print.pixels[p]) fixed.pixels[p] = 128;  // the later one counts
    const Image mask = is(out_.labels, of);
    const Result<GuidedMatte> guided = guided_matte(picture_, mask, {stroke}, fixed);
    if (!guided) return forward(guided);
    const bool comes = stroke.label == MatteLabel::Foreground;
    for (std::size_t p = 0; p < mask.pixels.size(); ++p) {
      const bool now = guided->matte.pixels[p] >= 128;
      if (fixed.pixels[p] == 128 && now == comes && (mask.pixels[p] != 0) != comes)
        out_.labels.pixels[p] = static_cast<std::uint8_t>(to);
    }
    return {};
  }

  void finish(const Image& print, const Image& before, int label) {
    bool outside = true, acted = false;
    long beside = 0;
    for (std::size_t p = 0; p < print.pixels.size(); ++p) {
      outside = outside && !print.pixels[p];
      if (print.pixels[p]) out_.labels.pixels[p] = said_.pixels[p] = static_cast<std::uint8_t>(label);
      const bool turned = out_.labels.pixels[p] != before.pixels[p];
      acted = acted || turned;
      beside += turned && !print.pixels[p];
    }
    out_.effects.push_back(outside ? StrokeEffect::Outside
                           : acted ? StrokeEffect::Acted
                                   : StrokeEffect::Already);
    out_.turned.push_back(beside);
  }

  const Image& picture_;
  Image said_;  // of each pixel the label that earlier strokes say, 0 nobody's
  StrokedLabels out_;
};

}  // namespace

Result<StrokedLabels> stroke_labels(const Image& picture, const Image& labels,
                                    const std::vector<LabelStroke>& strokes) {
  Stroker stroker(picture, labels);
  for (const LabelStroke& stroke : strokes)
    if (Result<void> ok = stroker.apply(stroke); !ok) return forward(ok);
  return stroker.take();
}

}  // namespace floatstage::matting
