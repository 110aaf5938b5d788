#include "pipeline/matte/camera_matting.h"

#include <algorithm>
#include <set>
#include <span>

#include "core/png.h"
#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/method_selection.h"
#include "pipeline/matte/affected_frames.h"

namespace floatstage::pipeline {
namespace {

constexpr int kAutoSpots = 4;  // places in the take where auto compares, two photographs each

// Writes what is known over a matte.
void overrule(const Image& known, Image& matte) {
  for (std::size_t p = 0; p < known.pixels.size(); ++p)
    if (known.pixels[p] != 128) matte.pixels[p] = known.pixels[p];
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
  return std::any_of(edits_.keyframes.begin(), edits_.keyframes.end(),
                     [](const MatteKeyframe& k) { return !k.strokes.empty(); });
}

bool CameraMatting::leads_to(int frame, int first, int last) const {
  const int turn = first_keyframe();
  return frame == turn || (frame > turn ? frame <= last : frame >= first);
}

void CameraMatting::follow(const std::function<bool()>& go_on,
                           const std::function<Link(int frame, const Link& previous)>& visit) const {
  const int count = take_->frame_count();
  // What is said in later keyframes is added to what comes from the first.
  const int first = std::clamp(first_keyframe(), 0, std::max(0, count - 1));
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

Image CameraMatting::masks(int frame, const Image& rgb) const {
  Image map(rgb.width, rgb.height, 1, 128);
  paint_masks(edits_.masks, frame, 1, map);
  return map;
}

std::vector<MatteStroke> CameraMatting::strokes(int frame) const {
  for (const MatteKeyframe& k : edits_.keyframes)
    if (k.frame == frame) return k.strokes;
  return {};
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

std::optional<Result<Image>> CameraMatting::compared(int frame) const {
  const auto made = compared_.find(frame);
  if (made == compared_.end() || !edits_.masks.empty()) return std::nullopt;
  return decode_png(std::as_bytes(std::span(made->second)), text("frame ", frame));
}

Result<CameraMatting::Shot> CameraMatting::shot(int frame) const {
  Result<Frame> photograph = take_->frame(camera_, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Shot();
  Result<Image> rgb = to_rgb(*photograph);
  if (!rgb) return forward(rgb);
  if (std::optional<Result<Image>> base = compared(frame)) {
    if (!*base) return forward(*base);
    return Shot{std::move(*rgb), std::move(**base)};
  }
  Result<Image> key = key_.key(*photograph, frame);
  if (!key) return forward(key);
  if (key->empty()) return Shot();
  const Image known = masks(frame, *rgb);
  overrule(known, *key);
  Result<Image> base = finished(method_, *rgb, *key, known);
  if (!base) return forward(base);
  return Shot{std::move(*rgb), std::move(*base)};
}

Result<CameraMatting::Link> CameraMatting::matte(int frame, const Link& previous) const {
  if (!follows())  // the photograph says nothing that was not said when it was compared
    if (std::optional<Result<Image>> base = compared(frame)) {
      if (!*base) return forward(*base);
      return Link{frame, std::move(**base)};
    }
  Result<Shot> now = shot(frame);
  if (!now) return forward(now);
  if (now->base.empty() || !follows()) return Link{frame, std::move(now->base)};
  matting::CarriedGuidance carried;
  const Image& base = now->base;
  const bool fits = previous.matte.width == base.width && previous.matte.height == base.height;
  if (fits && (previous.base.empty() || previous.base != previous.matte)) {
    Result<Shot> neighbour = shot(previous.frame);
    if (!neighbour) return forward(neighbour);
    if (!neighbour->base.empty())
      carried = matting::carried_guidance(neighbour->rgb, neighbour->base, previous.matte, now->rgb, base);
  }
  Result<Link> made = guided(frame, now->rgb, base, masks(frame, now->rgb), carried);
  if (made) made->ended = ended(carried, previous.frame, *made);
  return made;
}

Result<CameraMatting::Link> CameraMatting::guided(int frame, const Image& rgb, Image base) const {
  return guided(frame, rgb, std::move(base), {}, {});
}

Result<CameraMatting::Link> CameraMatting::guided(int frame, const Image& rgb, Image base, const Image& fixed,
                                                  const matting::CarriedGuidance& carried) const {
  const std::vector<MatteStroke> said = strokes(frame);
  if (said.empty() && carried.said.empty()) return Link{frame, base, base};
  Result<matting::GuidedMatte> made = matting::guided_matte(rgb, base, said, fixed, carried);
  if (!made) return forward(made);
  Link link{frame, std::move(made->matte), std::move(base)};
  for (std::size_t i = 0; i < said.size(); ++i)
    if (made->effects[i] != matting::StrokeEffect::Acted)
      link.idle.push_back(idle(frame, i, made->effects[i]));
  std::erase(link.idle, "");
  link.guided = link.matte != link.base;
  return link;
}

void CameraMatting::mask(int frame, Image& matte) const { overrule(masks(frame, matte), matte); }

// The stroke that a key was made from has acted before.
std::string CameraMatting::idle(int frame, std::size_t stroke, matting::StrokeEffect effect) const {
  const std::vector<MatteStroke> all = strokes(frame);
  const MatteStroke& said = all[stroke];
  if (!said.subject.empty() && effect != matting::StrokeEffect::Outside) return {};  // it says who is who
  const MatteKeyframe seed = seed_of({{{frame, all}}, {}});
  const bool seeds = key_.kind() == CameraKey::Kind::None ||
                     (key_.kind() == CameraKey::Kind::Cut && frame == seed_of(edits_).frame);
  if (seeds && !seed.strokes.empty() && said == seed.strokes.front()) return {};
  const char* side = said.label == MatteLabel::Foreground ? "subject" : "background";
  return text("frame ", frame, ": stroke ", stroke + 1, ", ", side, ", changes nothing: ",
              effect == matting::StrokeEffect::Outside
                  ? "it lies outside of the photograph"
                  : text("all that it marks is ", side, " already, or under a mask"));
}

// One sentence a side, of its largest piece.
std::vector<std::string> CameraMatting::ended(const matting::CarriedGuidance& carried, int from,
                                              const Link& made) const {
  std::vector<std::string> sentences;
  if (carried.followed.empty()) return sentences;
  Image said(made.base.width, made.base.height, 1, 128);
  paint_strokes(strokes(made.frame), 1, said);
  paint_masks(edits_.masks, made.frame, 1, said);
  std::set<MatteLabel> named;
  for (const matting::EndedChange& change : matting::ended_changes(carried, made.base, made.matte, said)) {
    if (!named.insert(change.said).second) continue;
    const bool subject = change.said == MatteLabel::Foreground;
    sentences.push_back(
        text("what a stroke made ", subject ? "subject" : "background", " is followed no further than frame ",
             from, ": at ", static_cast<int>(change.at.x()), ",", static_cast<int>(change.at.y()),
             " something hides it or cannot be told from it; click there again in this frame"));
  }
  return sentences;
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
    if (!key && key.error().code == ErrorCode::Unsupported) return candidates;  // and says so when it is made
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
