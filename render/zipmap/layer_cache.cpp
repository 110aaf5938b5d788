#include "render/zipmap/layer_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace floatstage::render {

LayerCache::LayerCache(const Zipmap& zipmap, int layers)
    : zipmap_(zipmap),
      slots_(static_cast<std::size_t>(std::max(0, layers))),
      layer_of_(zipmap.pictures().size(), -1) {}

std::vector<std::vector<PatchNeed>> LayerCache::passes(const std::vector<PatchNeed>& needs) const {
  std::vector<std::vector<PatchNeed>> out;
  std::set<std::size_t> pictures;
  for (const PatchNeed& need : needs) {
    pictures.insert(zipmap_.patches()[need.patch].picture);
    if (out.empty() || pictures.size() > slots_.size()) {
      out.emplace_back();
      pictures = {zipmap_.patches()[need.patch].picture};
    }
    out.back().push_back(need);
  }
  return out;
}

std::size_t LayerCache::finest(std::size_t picture) const {
  const int layer = layer_of_[picture];
  return layer < 0 ? zipmap_.pictures()[picture].levels().size()
                   : slots_[static_cast<std::size_t>(layer)].finest;
}

void LayerCache::give_layer(std::size_t picture) {
  if (layer_of_[picture] < 0) {
    const auto oldest = std::min_element(slots_.begin(), slots_.end(),
                                         [](const Slot& a, const Slot& b) { return a.used < b.used; });
    if (oldest->picture >= 0) layer_of_[static_cast<std::size_t>(oldest->picture)] = -1;
    *oldest = {static_cast<int>(picture), zipmap_.pictures()[picture].levels().size(), now_};
    layer_of_[picture] = static_cast<int>(oldest - slots_.begin());
  }
  slots_[static_cast<std::size_t>(layer_of_[picture])].used = now_;
}

std::vector<LayerLoad> LayerCache::load(const std::vector<PatchNeed>& pass, std::size_t most,
                                        std::size_t& waiting) {
  ++now_;
  struct Want {
    std::size_t level = std::numeric_limits<std::size_t>::max();
    double pixels = 0;
  };
  std::map<std::size_t, Want> wants;
  for (const PatchNeed& need : pass) {
    Want& want = wants[zipmap_.patches()[need.patch].picture];
    want.level = std::min(want.level, need.level);
    want.pixels += need.pixels;
  }
  // Those that have a layer keep it: only then may others take the oldest.
  for (const auto& [picture, want] : wants)
    if (layer_of_[picture] >= 0) give_layer(picture);
  for (const auto& [picture, want] : wants) give_layer(picture);

  struct Step {
    LayerLoad load;
    double urgency;  // pixels of the view whose blur one level more would halve, each twice as urgent a level
  };
  std::vector<Step> steps;
  for (const auto& [picture, want] : wants)
    for (std::size_t level = finest(picture); level-- > want.level;)
      steps.push_back({{picture, level, layer_of_[picture]},
                       std::ldexp(want.pixels, 2 * static_cast<int>(level - want.level))});
  // A picture's coarse levels are more urgent than its finer ones, so each comes after those it stands on.
  std::stable_sort(steps.begin(), steps.end(),
                   [](const Step& a, const Step& b) { return a.urgency > b.urgency; });
  std::vector<LayerLoad> loads;
  std::size_t bytes = 0;
  bool full = false;
  for (const Step& step : steps) {
    const std::size_t size = zipmap_.pictures()[step.load.picture].levels()[step.load.level].pixels.size();
    full = full || (!loads.empty() && bytes + size > most);
    if (full) {
      waiting += size;
      continue;
    }
    bytes += size;
    loads.push_back(step.load);
    slots_[static_cast<std::size_t>(step.load.layer)].finest = step.load.level;
  }
  return loads;
}

}  // namespace floatstage::render
