#pragma once

#include <chrono>
#include <future>
#include <list>
#include <memory>
#include <optional>

#include "pipeline/scene_loader.h"

namespace floatstage::apps {

/// Loads instants of a take in the background and keeps the last few. Used on one thread.
class SceneCache {
 public:
  explicit SceneCache(capture::TakeReader& take, std::size_t capacity = 8)
      : loader_(take, true), capacity_(capacity) {}

  /// The scene if it is there, else null while it is being loaded (ask again), or the error that loading met.
  Result<std::shared_ptr<const SceneFrame>> get(int frame);
  /// The newest scene that is there of the frames after `shown` up to `frame`, and its number; absent where
  /// there is none. After the take has begun again `shown` is the larger.
  std::optional<int> newest(int shown, int frame);
  /// What loading takes, s: of the last few.
  double load_seconds() const { return load_seconds_; }
  /// Begins to load `frame` if nothing is being loaded.
  void prefetch(int frame);
  /// What was loaded is loaded again when it is asked for.
  void clear();

 private:
  struct Entry {
    int frame;
    Result<std::shared_ptr<const SceneFrame>> scene;
  };
  const Entry* find(int frame);
  void collect();

  pipeline::SceneLoader loader_;
  const std::size_t capacity_;
  std::list<Entry> entries_;  // most recently used first
  int loading_frame_ = -1;
  double load_seconds_ = 0;
  std::chrono::steady_clock::time_point loading_since_;
  std::future<Result<SceneFrame>> loading_;
};

}  // namespace floatstage::apps
