#pragma once

#include <optional>
#include <vector>

#include "pipeline/camera_path.h"

namespace floatstage::apps {

/// Key frames while they are being set, with what they were before. Keys stay in order of time; two keys
/// never share one. Indices are of the present path.
class PathEditor {
 public:
  const pipeline::CameraPath& path() const { return path_; }
  bool empty() const { return path_.keys.empty(); }
  void set(pipeline::CameraPath path);
  void clear() { set({}); }

  /// Sets a key at a time; one that is there (within a millisecond) is replaced. Returns its index.
  std::size_t put(pipeline::PathKey key, double time);
  /// A key after the last, for walking and pressing K: as much later as the take is, or one second.
  std::size_t append(pipeline::PathKey key);
  void remove(std::size_t index);
  /// Changes all of a key but its time.
  void change(std::size_t index, pipeline::PathKey key);
  /// Moves a key in the film's time, up to its neighbours, a millisecond short of them.
  void move(std::size_t index, double time);
  /// Lets a key follow the subject or stand, where it is at its time.
  void set_follow(std::size_t index, bool follow, const pipeline::SubjectTrack& subject);

  /// What changes between the two is undone in one step: a drag.
  void begin_gesture() { gesture_ = Gesture::Begun; }
  void end_gesture() { gesture_ = Gesture::None; }
  bool can_undo() const { return !before_.empty(); }
  bool can_redo() const { return !after_.empty(); }
  void undo();
  void redo();

  /// The key that the panels show.
  std::optional<std::size_t> selected() const;
  void select(std::optional<std::size_t> index) { selected_ = index; }

 private:
  enum class Gesture { None, Begun, Kept };
  void keep();  // before a change

  pipeline::CameraPath path_;
  std::vector<pipeline::CameraPath> before_, after_;
  std::optional<std::size_t> selected_;
  Gesture gesture_ = Gesture::None;
};

}  // namespace floatstage::apps
