#pragma once

#include <future>
#include <list>
#include <memory>

#include "pipeline/scene_loader.h"

namespace floatstage::apps {

/// Loads instants of a take in the background and keeps the last few. Used on one thread.
class SceneCache {
 public:
  explicit SceneCache(capture::TakeReader& take, std::size_t capacity = 8)
      : loader_(take, true), capacity_(capacity) {}

  /// The scene if it is there, else null while it is being loaded (ask again), or the error that loading met.
  Result<std::shared_ptr<const SceneFrame>> get(int frame);
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
  std::future<Result<SceneFrame>> loading_;
};

}  // namespace floatstage::apps
