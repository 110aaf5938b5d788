#include "pipeline/matte/affected_frames.h"

#include <algorithm>
#include <map>

namespace floatstage::pipeline {
namespace {

using Strokes = std::map<int, std::vector<MatteStroke>>;

// Whose a stroke is says nothing of opacity.
Strokes strokes_of(const CameraEdits& edits) {
  Strokes all;
  for (const MatteKeyframe& k : without_subjects(edits).keyframes)
    if (!k.strokes.empty()) all[k.frame] = k.strokes;
  return all;
}

std::vector<MatteMask> masks_in(const CameraEdits& edits, int frame) {
  std::vector<MatteMask> out;
  for (MatteMask m : edits.masks)
    if (holds_in(m, frame)) {
      m.first = 0, m.last = {};  // what counts is that it holds, not for how long
      out.push_back(std::move(m));
    }
  return out;
}

bool same_strokes(const Strokes& a, const Strokes& b, int frame) {
  const auto x = a.find(frame), y = b.find(frame);
  return (x == a.end()) == (y == b.end()) && (x == a.end() || x->second == y->second);
}

void mark(std::vector<bool>& frames, int first, int last) {
  for (int f = std::max(0, first); f <= std::min(last, static_cast<int>(frames.size()) - 1); ++f)
    frames[static_cast<std::size_t>(f)] = true;
}

}  // namespace

bool same_strokes(const CameraEdits& a, const CameraEdits& b) { return strokes_of(a) == strokes_of(b); }

MatteKeyframe seed_of(const CameraEdits& edits) {
  for (const MatteKeyframe& k : without_subjects(edits).keyframes)
    for (const MatteStroke& s : k.strokes)
      if (s.label == MatteLabel::Foreground) return {k.frame, {s}};
  return {};
}

std::vector<bool> edited_frames(const CameraEdits& before, const CameraEdits& after, int frames) {
  const Strokes a = strokes_of(before), b = strokes_of(after);
  std::vector<bool> out(static_cast<std::size_t>(frames));
  for (int f = 0; f < frames; ++f)
    out[static_cast<std::size_t>(f)] = !same_strokes(a, b, f) || masks_in(before, f) != masks_in(after, f);
  return out;
}

std::vector<bool> frames_between_keyframes(const CameraEdits& before, const CameraEdits& after, int frames) {
  const Strokes a = strokes_of(before), b = strokes_of(after);
  std::vector<bool> out(static_cast<std::size_t>(frames));
  if (a.empty() != b.empty()) mark(out, 0, frames - 1);  // from its own first guess, or to it
  Strokes unchanged;                                     // where both have the same strokes, nothing passes
  for (const auto& [frame, strokes] : a)
    if (same_strokes(a, b, frame)) unchanged[frame];
  for (const Strokes* one : {&a, &b})
    for (const auto& [frame, strokes] : *one) {
      if (unchanged.contains(frame)) continue;
      const auto next = unchanged.upper_bound(frame);
      mark(out, next == unchanged.begin() ? 0 : std::prev(next)->first + 1,
           next == unchanged.end() ? frames - 1 : next->first - 1);
    }
  for (int f = 0; f < frames; ++f)
    if (masks_in(before, f) != masks_in(after, f)) mark(out, f, f);
  return out;
}

std::vector<bool> frames_chosen_otherwise(const CameraEdits& before, const CameraEdits& after, int frames) {
  const Strokes a = strokes_of(before), b = strokes_of(after);
  std::vector<bool> out = edited_frames(before, after, frames);
  // What is carried on from a frame is what strokes have made of what its masks leave.
  if (!b.empty())
    for (int f = 0; f < frames; ++f)
      if (masks_in(before, f) != masks_in(after, f)) mark(out, f - 1, f + 1);
  if (a.empty() != b.empty()) mark(out, 0, frames - 1);
  // Between the two first keyframes the direction turns.
  if (!a.empty() && !b.empty() && a.begin()->first != b.begin()->first)
    mark(out, std::min(a.begin()->first, b.begin()->first), std::max(a.begin()->first, b.begin()->first));
  return out;
}

std::vector<bool> frames_made_otherwise(const std::string& method, const std::string& key,
                                        const CameraEdits& before, const CameraEdits& after, int frames) {
  // What was cut out from a stroke as a whole, another one cuts out as a whole.
  if (key == "cut" && seed_of(before) != seed_of(after))
    return std::vector<bool>(static_cast<std::size_t>(frames), true);
  if (method == "spectral") return frames_between_keyframes(before, after, frames);
  return method == "consistent" ? edited_frames(before, after, frames)
                                : frames_chosen_otherwise(before, after, frames);
}

std::vector<bool> downstream_of(std::vector<bool> frames, const CameraEdits& edits) {
  const Strokes strokes = strokes_of(edits);
  if (strokes.empty() || frames.empty()) return frames;
  const std::size_t turn =
      static_cast<std::size_t>(std::clamp(strokes.begin()->first, 0, static_cast<int>(frames.size()) - 1));
  for (std::size_t f = turn + 1; f < frames.size(); ++f) frames[f] = frames[f] || frames[f - 1];
  for (std::size_t f = turn; f-- > 0;) frames[f] = frames[f] || frames[f + 1];
  return frames;
}

}  // namespace floatstage::pipeline
