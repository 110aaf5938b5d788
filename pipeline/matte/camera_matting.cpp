#include "pipeline/matte/camera_matting.h"

#include <algorithm>
#include <span>

#include "core/png.h"
#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/method_selection.h"
#include "matting/select_connected_components.h"

namespace floatstage::pipeline {
namespace {

constexpr int kAutoSpots = 4;    // places in the take where auto compares, two photographs each
constexpr double kReach = 0.04;  // of the picture's longer side: how far parts move from frame to frame

// Writes what is known over a matte.
void overrule(const Image& known, Image& matte) {
  for (std::size_t p = 0; p < known.pixels.size(); ++p)
    if (known.pixels[p] != 128) matte.pixels[p] = known.pixels[p];
}

bool nothing_known(const Image& map) {
  return std::all_of(map.pixels.begin(), map.pixels.end(), [](int v) { return v == 128; });
}

}  // namespace

CameraMatting::CameraMatting(capture::TakeReader& take, int camera, CameraKey key, CameraEdits edits,
                             std::string method)
    : take_(&take),
      camera_(camera),
      key_(std::move(key)),
      edits_(std::move(edits)),
      method_(std::move(method)) {}

bool CameraMatting::follows() const {
  return key_.kind() != CameraKey::Kind::Cut &&
         std::any_of(edits_.keyframes.begin(), edits_.keyframes.end(),
                     [](const MatteKeyframe& k) { return !k.strokes.empty(); });
}

void CameraMatting::follow(const std::function<bool()>& go_on,
                           const std::function<Link(int frame, const Link& previous)>& visit) const {
  const int count = take_->frame_count();
  // Later keyframes choose anew among the parts, but what nobody touches there goes on as it was.
  const int first = std::clamp(follows() ? first_keyframe() : 0, 0, std::max(0, count - 1));
  Link previous, at_first;
  const auto step = [&](int frame) {
    Link made = visit(frame, previous);
    if (frame == first) at_first = made;
    if (!made.matte.empty())
      previous = std::move(made);
    else
      previous.changed = previous.changed || made.changed;
  };
  for (int f = first; f < count && go_on(); ++f) step(f);
  previous = std::move(at_first);
  for (int f = first - 1; f >= 0 && go_on(); --f) step(f);
}

int CameraMatting::first_keyframe() const {
  for (const MatteKeyframe& k : edits_.keyframes)
    if (!k.strokes.empty()) return k.frame;
  return 0;
}

Image CameraMatting::said(int frame, int width, int height, bool strokes, bool masks) const {
  Image map(width, height, 1, 128);
  for (const MatteKeyframe& k : edits_.keyframes)
    if (strokes && k.frame == frame) paint_strokes(k.strokes, 1, map);
  if (masks) paint_masks(edits_.masks, frame, 1, map);
  return map;
}

Result<Image> CameraMatting::finished(const std::string& method, const Image& rgb, const Image& key,
                                      const Image& known) const {
  Image matte = key;
  if (method == "closed-form") {
    matting::RefineOptions options = matting::key_refinement();
    options.band.margin = std::max(3, std::max(rgb.width, rgb.height) / 400);
    Result<Image> refined = matting::refine_matte(rgb, key, options, known);
    if (!refined) return refined;
    matte = std::move(*refined);
  }
  overrule(known, matte);
  return matte;
}

Result<Image> CameraMatting::matte(int frame, const Image& previous) const {
  if (const auto made = compared_.find(frame); made != compared_.end() && edits_ == CameraEdits())
    return decode_png(std::as_bytes(std::span(made->second)), text("frame ", frame));
  Result<Frame> photograph = take_->frame(camera_, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Image();
  Result<Image> rgb = to_rgb(*photograph);
  if (!rgb) return forward(rgb);
  Result<Image> key = key_.key(*photograph, frame);
  if (!key) return forward(key);
  if (key->empty()) return Image();
  overrule(said(frame, rgb->width, rgb->height, false, true), *key);
  if (follows()) {
    Image strokes = said(frame, rgb->width, rgb->height, true, false);
    if (nothing_known(strokes)) strokes = {};
    const bool fits = previous.width == key->width && previous.height == key->height;
    *key = matting::select_connected_components(*key, fits ? previous : Image(), strokes,
                                                static_cast<int>(kReach * std::max(key->width, key->height)));
  }
  return finished(method_, *rgb, *key, said(frame, rgb->width, rgb->height, true, true));
}

void CameraMatting::mask(int frame, Image& matte) const {
  overrule(said(frame, matte.width, matte.height, true, true), matte);
}

Result<std::string> CameraMatting::chosen_method() {
  if (method_ == "spectral" || (method_ == "auto" && key_.kind() == CameraKey::Kind::None))
    return std::string("spectral");
  if (method_ != "auto") return std::string(method_ == "closed-form" ? "closed-form" : "key");
  const std::vector<std::string> methods = {"key", "closed-form"};
  constexpr std::size_t kUsual = 1;
  // What each method makes of a frame; nothing where there is no photograph or key.
  const auto candidates_of = [&](int frame, Image& rgb) -> Result<std::vector<Image>> {
    std::vector<Image> candidates;
    Result<Frame> photograph = take_->frame(camera_, frame);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) return candidates;
    Result<Image> picture = to_rgb(*photograph), key = key_.key(*photograph, frame);
    if (!picture) return forward(picture);
    if (!key) return forward(key);
    if (key->empty()) return candidates;
    for (const std::string& method : methods) {
      Result<Image> matte = finished(method, *picture, *key, Image(picture->width, picture->height, 1, 128));
      if (!matte) return forward(matte);
      candidates.push_back(std::move(*matte));
    }
    rgb = std::move(*picture);
    return candidates;
  };
  matting::MethodComparison comparison(methods.size());
  std::map<int, std::vector<std::string>> made;  // packed: a hundredth of their size
  const auto keep = [&](int frame, const std::vector<Image>& candidates) {
    if (made.contains(frame)) return;
    for (const Image& candidate : candidates)
      if (const Result<std::string> packed = encode_png_of_runs(candidate)) made[frame].push_back(*packed);
  };
  const int count = take_->frame_count(), spots = std::min(kAutoSpots, count);
  for (int i = 0; i < spots; ++i) {
    const int frame = static_cast<int>((2L * i + 1) * count / (2L * spots));
    Image rgb, rgb_before;
    Result<std::vector<Image>> now = candidates_of(frame, rgb);
    if (!now) return forward(now);
    if (now->empty()) continue;
    keep(frame, *now);
    comparison.add(rgb, *now, key_.known_plate());
    Result<std::vector<Image>> before =
        frame > 0 ? candidates_of(frame - 1, rgb_before) : Result<std::vector<Image>>(std::vector<Image>());
    if (!before) return forward(before);
    keep(frame - 1, *before);
    if (!before->empty()) comparison.add_pair(rgb_before, *before, rgb, *now);
  }
  const std::size_t best = comparison.best(kUsual);
  for (const auto& [frame, packed] : made)
    if (packed.size() == methods.size()) compared_[frame] = packed[best];
  return methods[best];
}

}  // namespace floatstage::pipeline
