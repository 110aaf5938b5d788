#include "apps/viewer/play/scene_cache.h"

#include "core/give_way.h"

namespace floatstage::apps {
namespace {

constexpr int kNice = 10;  // a hand is answered before the next instant is there

}  // namespace

const SceneCache::Entry* SceneCache::find(int frame) {
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (it->frame != frame) continue;
    entries_.splice(entries_.begin(), entries_, it);
    return &entries_.front();
  }
  return nullptr;
}

void SceneCache::collect() {
  if (!loading_.valid() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  Result<SceneFrame> scene = loading_.get();
  if (scene)
    entries_.push_front({loading_frame_, std::make_shared<const SceneFrame>(std::move(*scene))});
  else
    entries_.push_front({loading_frame_, forward(scene)});
  if (entries_.size() > capacity_) entries_.pop_back();
  constexpr double kLast = 0.3;
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - loading_since_).count();
  load_seconds_ += (load_seconds_ > 0 ? kLast : 1) * (took - load_seconds_);
}

void SceneCache::prefetch(int frame) {
  collect();
  if (loading_.valid() || find(frame)) return;
  loading_frame_ = frame;
  loading_since_ = std::chrono::steady_clock::now();
  loading_ = std::async(std::launch::async, [this, frame] {
    give_way(kNice);
    return loader_.load(frame);
  });
}

Result<std::shared_ptr<const SceneFrame>> SceneCache::get(int frame) {
  collect();
  if (const Entry* entry = find(frame)) return entry->scene;
  prefetch(frame);
  return std::shared_ptr<const SceneFrame>();
}

std::optional<int> SceneCache::newest(int shown, int frame) {
  collect();
  std::optional<int> best;
  for (const Entry& entry : entries_)
    if (entry.frame <= frame && (shown > frame || entry.frame > shown) && (!best || entry.frame > *best))
      best = entry.frame;
  return best;
}

void SceneCache::clear() {
  if (loading_.valid()) loading_.wait();
  collect();
  entries_.clear();
}

}  // namespace floatstage::apps
