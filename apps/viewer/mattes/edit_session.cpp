#include "apps/viewer/mattes/edit_session.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {
namespace {

constexpr double kStep = 1;             // px between the points of a scribble
constexpr double kLeastFlicker = 0.05;  // of the worst

// A quarter of a pixel is finer than a hand, and short in the file.
Eigen::Vector2d rounded(const Eigen::Vector2d& p) { return (p * 4).array().round() / 4; }

}  // namespace

EditSession::EditSession(CameraEdits edits, int frames, int width, int height)
    : edits_(std::move(edits)), frames_(frames), width_(width), height_(height) {
  radius = std::max(1.5, std::round(std::max(width, height) / 50.0) / 4);
}

void EditSession::grow(double factor) {
  radius = std::clamp(std::round(radius * factor * 4) / 4, 0.5, 500.0);
}

void EditSession::change(CameraEdits edits) {
  past_.push_back(std::exchange(edits_, std::move(edits)));
  future_.clear();
}

std::optional<std::size_t> EditSession::mask_at(int frame, const Eigen::Vector2d& point) const {
  const Eigen::Vector2i at(static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y())));
  if (at.x() < 0 || at.y() < 0 || at.x() >= width_ || at.y() >= height_) return std::nullopt;
  for (std::size_t i = edits_.masks.size(); i-- > 0;) {
    Image map(width_, height_, 1, 128);
    paint_masks({edits_.masks[i]}, frame, 1, map);
    if (*map.at(at.x(), at.y()) != 128) return i;
  }
  return std::nullopt;
}

bool EditSession::touches_photograph(const MatteStroke& stroke) const {
  Image map(width_, height_, 1, 128);
  paint_strokes({stroke}, 1, map);
  return std::any_of(map.pixels.begin(), map.pixels.end(), [](int v) { return v != 128; });
}

bool EditSession::press(int frame, const Eigen::Vector2d& point, bool second) {
  give_up();
  if (tool != EditTool::Stroke && second) {
    const std::optional<std::size_t> mask = mask_at(frame, point);
    return mask && remove_mask(*mask);
  }
  const bool foreground = tool == EditTool::Stroke ? !second : tool == EditTool::HoldOut;
  drawing_ =
      MatteStroke{foreground ? MatteLabel::Foreground : MatteLabel::Background, radius, {rounded(point)}};
  if (tool == EditTool::Stroke && foreground) drawing_->subject = subject;
  drawing_frame_ = frame;
  drawing_mask_ = tool != EditTool::Stroke;
  return false;
}

void EditSession::drag(const Eigen::Vector2d& point) {
  if (drawing_ && (point - drawing_->points.back()).norm() >= kStep)
    drawing_->points.push_back(rounded(point));
}

bool EditSession::release() {
  if (!drawing_) return false;
  const MatteStroke stroke = std::move(*drawing_);
  drawing_.reset();
  if (!touches_photograph(stroke)) return false;
  CameraEdits edits = edits_;
  if (drawing_mask_) {
    MatteMask mask{stroke.label, stroke.points, 0, {}, stroke.radius};
    if (mask_reach != MaskReach::WholeClip) mask.first = drawing_frame_;
    if (mask_reach == MaskReach::ThisFrame) mask.last = drawing_frame_;
    edits.masks.push_back(std::move(mask));
  } else {
    const auto at = std::lower_bound(edits.keyframes.begin(), edits.keyframes.end(), drawing_frame_,
                                     [](const MatteKeyframe& k, int frame) { return k.frame < frame; });
    if (at != edits.keyframes.end() && at->frame == drawing_frame_)
      at->strokes.push_back(stroke);
    else
      edits.keyframes.insert(at, {drawing_frame_, {stroke}});
  }
  change(std::move(edits));
  return true;
}

void EditSession::give_up() { drawing_.reset(); }

bool EditSession::remove_keyframe(int frame) {
  CameraEdits edits = edits_;
  if (std::erase_if(edits.keyframes, [&](const MatteKeyframe& k) { return k.frame == frame; }) == 0)
    return false;
  change(std::move(edits));
  return true;
}

bool EditSession::remove_mask(std::size_t index) {
  if (index >= edits_.masks.size()) return false;
  CameraEdits edits = edits_;
  edits.masks.erase(edits.masks.begin() + static_cast<std::ptrdiff_t>(index));
  change(std::move(edits));
  return true;
}

bool EditSession::clear() {
  if (edits_ == CameraEdits()) return false;
  change({});
  return true;
}

bool EditSession::undo() {
  give_up();
  if (past_.empty()) return false;
  future_.push_back(std::exchange(edits_, std::move(past_.back())));
  past_.pop_back();
  return true;
}

bool EditSession::redo() {
  give_up();
  if (future_.empty()) return false;
  past_.push_back(std::exchange(edits_, std::move(future_.back())));
  future_.pop_back();
  return true;
}

const MatteKeyframe* EditSession::keyframe(int frame) const {
  for (const MatteKeyframe& k : edits_.keyframes)
    if (k.frame == frame) return &k;
  return nullptr;
}

std::optional<int> EditSession::keyframe_after(int frame) const {
  for (const MatteKeyframe& k : edits_.keyframes)
    if (k.frame > frame && k.frame < frames_) return k.frame;
  return std::nullopt;
}

std::optional<int> EditSession::keyframe_before(int frame) const {
  std::optional<int> found;
  for (const MatteKeyframe& k : edits_.keyframes)
    if (k.frame < frame) found = k.frame;
  return found;
}

std::vector<int> worst_frames(const std::vector<std::optional<double>>& flicker) {
  const auto at = [&](std::size_t f) { return f < flicker.size() ? flicker[f].value_or(-1) : -1; };
  std::vector<int> frames;
  double worst = 0;
  for (std::size_t f = 0; f < flicker.size(); ++f) worst = std::max(worst, at(f));
  for (std::size_t f = 0; f < flicker.size(); ++f)  // of equal neighbours the first
    if (at(f) > 0 && at(f) >= kLeastFlicker * worst && (f == 0 || at(f) > at(f - 1)) && at(f) >= at(f + 1))
      frames.push_back(static_cast<int>(f));
  std::stable_sort(frames.begin(), frames.end(), [&](int a, int b) {
    return at(static_cast<std::size_t>(a)) > at(static_cast<std::size_t>(b));
  });
  return frames;
}

std::optional<int> next_worst(const std::vector<int>& worst, int frame) {
  if (worst.empty()) return std::nullopt;
  const auto here = std::find(worst.begin(), worst.end(), frame);
  return here == worst.end() || here + 1 == worst.end() ? worst.front() : *(here + 1);
}

}  // namespace floatstage::apps
