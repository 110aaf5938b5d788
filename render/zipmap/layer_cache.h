#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/zipmap/zipmap_needs.h"

namespace floatstage::render {

/// One level of one picture that is to be copied into its layer.
struct LayerLoad {
  std::size_t picture = 0, level = 0;
  int layer = 0;
};

/// Which pictures of a zipmap are in which layers of an array texture, and down to which level. Arithmetic
/// only: who uses it copies.
class LayerCache {
 public:
  LayerCache(const Zipmap& zipmap, int layers);

  int layers() const { return static_cast<int>(slots_.size()); }
  /// Parts of `needs` that have at most layers() different pictures each, in their order.
  std::vector<std::vector<PatchNeed>> passes(const std::vector<PatchNeed>& needs) const;
  /// Gives every picture of a pass a layer, those that were not needed for longest make room, and says what
  /// is to be copied there: coarse levels first, then those that most of the view waits for. From now on
  /// these count as loaded, up to `most` bytes (at least one level); the rest is added to `waiting`.
  std::vector<LayerLoad> load(const std::vector<PatchNeed>& pass, std::size_t most, std::size_t& waiting);

  /// Its layer, -1: none.
  int layer_of(std::size_t picture) const { return layer_of_[picture]; }
  /// The finest level that is loaded; the number of levels: none is.
  std::size_t finest(std::size_t picture) const;

 private:
  struct Slot {
    int picture = -1;
    std::size_t finest = 0;
    std::uint64_t used = 0;
  };
  void give_layer(std::size_t picture);

  const Zipmap& zipmap_;
  std::vector<Slot> slots_;
  std::vector<int> layer_of_;  // by picture
  std::uint64_t now_ = 0;
};

}  // namespace floatstage::render
