#include "studio/live/tile_join.h"

#include <algorithm>

namespace floatstage::studio {
namespace {

constexpr std::size_t kMostScenes = 16, kMostTiles = 32;

}  // namespace

TileJoin::TileJoin(std::vector<std::string> serials, const JoinOptions& options)
    : serials_(std::move(serials)), options_(options), tiles_(serials_.size()) {}

int TileJoin::place_of(const std::string& serial) const {
  const auto found = std::find(serials_.begin(), serials_.end(), serial);
  return found == serials_.end() ? -1 : static_cast<int>(found - serials_.begin());
}

void TileJoin::push(std::shared_ptr<const StudioScene> scene, Timestamp now) {
  ++counters_.scenes;
  // One that came out of order, or from a reconstruction whose clock went back, replaces what was there.
  if (!scenes_.empty() && scene->instant <= scenes_.back().scene->instant) scenes_.clear();
  scenes_.push_back({std::move(scene), now});
  if (scenes_.size() > kMostScenes) {
    scenes_.pop_front();
    ++counters_.overtaken;
  }
}

void TileJoin::push(std::shared_ptr<const CameraView> tile) {
  const int camera = place_of(tile->serial);
  if (camera < 0 || !tile->tile) return;
  ++counters_.tiles;
  auto& tiles = tiles_[static_cast<std::size_t>(camera)];
  tiles.push_back(std::move(tile));
  if (tiles.size() > kMostTiles) tiles.pop_front();
}

const CameraView* TileJoin::tile_of(int camera, Timestamp exposed) const {
  const auto& tiles = tiles_[static_cast<std::size_t>(camera)];
  const auto found =
      std::find_if(tiles.rbegin(), tiles.rend(), [&](const auto& tile) { return tile->exposed == exposed; });
  return found == tiles.rend() ? nullptr : found->get();
}

bool TileJoin::is_ready(const Waiting& waiting, Timestamp now) const {
  if (now - waiting.came >= options_.patience) return true;
  for (const StudioScene::Camera& camera : waiting.scene->cameras) {
    const int place = place_of(camera.serial);
    if (place < 0 || !wanted_.contains(place)) continue;
    const auto& tiles = tiles_[static_cast<std::size_t>(place)];
    const bool speaks = !tiles.empty() && camera.exposed - tiles.back()->exposed < options_.silence &&
                        tiles.front()->exposed <= camera.exposed;
    if (speaks && !tile_of(place, camera.exposed)) return false;
  }
  return true;
}

std::shared_ptr<LiveScene> TileJoin::joined(const StudioScene& scene, Timestamp now) {
  auto live = std::make_shared<LiveScene>();
  live->scene = scene;
  live->views.resize(serials_.size());
  live->ready = now;
  bool whole = true;
  for (const StudioScene::Camera& camera : scene.cameras) {
    const int place = place_of(camera.serial);
    if (place < 0) continue;
    const auto& tiles = tiles_[static_cast<std::size_t>(place)];
    const auto tile = std::find_if(tiles.rbegin(), tiles.rend(),
                                   [&](const auto& t) { return t->exposed == camera.exposed; });
    if (tile != tiles.rend())
      live->views[static_cast<std::size_t>(place)] = *tile;
    else if (wanted_.contains(place))
      whole = false;
  }
  ++counters_.shown;
  if (!whole) ++counters_.incomplete;
  return live;
}

std::shared_ptr<LiveScene> TileJoin::newest(Timestamp now) {
  const auto ready =
      std::find_if(scenes_.rbegin(), scenes_.rend(), [&](const Waiting& w) { return is_ready(w, now); });
  if (ready == scenes_.rend()) return nullptr;
  std::shared_ptr<LiveScene> live = joined(*ready->scene, now);
  const auto end = ready.base();
  counters_.overtaken += static_cast<std::uint64_t>(std::distance(scenes_.begin(), end)) - 1;
  scenes_.erase(scenes_.begin(), end);
  return live;
}

}  // namespace floatstage::studio
