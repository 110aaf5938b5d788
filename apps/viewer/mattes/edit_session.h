#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/matte_edits.h"

namespace floatstage::apps {

enum class EditTool {
  Stroke,   ///< clicks and scribbles in a keyframe: left is subject, right is background
  Garbage,  ///< a brush for garbage masks: left paints background, right removes the mask below
  HoldOut,  ///< a brush for hold-outs: left paints subject, right removes the mask below
};

enum class MaskReach { WholeClip, FromHere, ThisFrame };

/// One camera's edits while a person makes them: what is drawn, undo and redo, keyframes to jump to. Knows no
/// window, no file and no mattes. Points are px of the photograph.
class EditSession {
 public:
  EditSession(CameraEdits edits, int frames, int width, int height);

  const CameraEdits& edits() const { return edits_; }

  EditTool tool = EditTool::Stroke;
  MaskReach mask_reach = MaskReach::WholeClip;
  double radius = 4;  ///< of the strokes to come, px; kept within 0.5 … 500 by grow()
  void grow(double factor);
  std::string subject = {};  ///< whom strokes of the subject to come mark, a label's name; empty: not said

  /// A stroke or brush mask begins, goes on and is finished; only then does it belong to the edits. One that
  /// never touched the photograph is dropped. `second` is the right button. True when the edits have changed
  /// (a mask was removed; a stroke is finished).
  bool press(int frame, const Eigen::Vector2d& point, bool second);
  void drag(const Eigen::Vector2d& point);
  bool release();
  void give_up();  ///< what is being drawn

  /// What is being drawn, as a stroke; null when nothing is.
  const MatteStroke* drawing() const { return drawing_ ? &*drawing_ : nullptr; }

  /// Each is one step to undo; false when there is nothing to do.
  bool remove_keyframe(int frame);
  bool remove_mask(std::size_t index);
  bool clear();

  bool undo();
  bool redo();
  bool can_undo() const { return !past_.empty(); }
  bool can_redo() const { return !future_.empty(); }

  const MatteKeyframe* keyframe(int frame) const;
  std::optional<int> keyframe_after(int frame) const;
  std::optional<int> keyframe_before(int frame) const;

 private:
  void change(CameraEdits edits);
  bool touches_photograph(const MatteStroke& stroke) const;
  std::optional<std::size_t> mask_at(int frame, const Eigen::Vector2d& point) const;

  CameraEdits edits_;
  const int frames_, width_, height_;
  std::vector<CameraEdits> past_, future_;
  std::optional<MatteStroke> drawing_;
  int drawing_frame_ = 0;
  bool drawing_mask_ = false;
};

/// Frames by how much their mattes flicker, largest first; of neighbouring frames, which share a cause, only
/// the worst. Unknown frames (no value) are left out, as are those under a twentieth of the worst.
std::vector<int> worst_frames(const std::vector<std::optional<double>>& flicker);

/// What to jump to from `frame`: the worst, or the next worse one after it when `frame` is among them. Absent
/// without any.
std::optional<int> next_worst(const std::vector<int>& worst, int frame);

}  // namespace floatstage::apps
