#pragma once

#include "pipeline/camera_path.h"

namespace floatstage::apps {

/// Key frames while they are being set. Keys stay in order of time; two keys never share one.
class PathEditor {
 public:
  const pipeline::CameraPath& path() const { return path_; }
  bool empty() const { return path_.keys.empty(); }
  void set(pipeline::CameraPath path) { path_ = std::move(path); }
  void clear() { path_.keys.clear(); }

  /// Sets a key at a time; one that is there (within a millisecond) is replaced.
  void put(pipeline::PathKey key, double time);
  /// A key one step after the last, for walking and pressing K.
  void append(pipeline::PathKey key, double step = 1);
  void remove(std::size_t index);

 private:
  pipeline::CameraPath path_;
};

}  // namespace floatstage::apps
