#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "detail/synthesis/color_grid.h"
#include "detail/synthesis/exemplars.h"
#include "detail/synthesis/provenance.h"
#include "detail/synthesis/strengths.h"
#include "detail/watch.h"

namespace floatstage::detail {

struct SynthesisOptions {
  int levels = 4;                ///< the root is enlarged 2^levels times, linear; 1 to 6
  int iterations = 4;            ///< of the optimisation at each level (thesis 4.5)
  float slack = 2;               ///< of the search for neighbours: NearestPoints::find()
  std::size_t most = 1'500'000;  ///< pixels of the close photographs that details are taken from
  int threads = 0;
};

struct SynthesisTile {
  Region region;
  ColorGrid colors;
  Grid<std::uint8_t> provenance;
  Grid<Exemplars::Place> places;  ///< of its details among the exemplars of the finest level; kNowhere: none
};

/// A root enlarged, with details that no photograph shows at their place taken from those that show their
/// like (M. Eisemann, "Error-Concealed Image-Based Rendering", 4.4). Any part of the result can be asked for,
/// from any thread; it does not depend on what else is asked.
class Synthesis {
 public:
  /// `root`: 3 channels, the coarsest level. `layers`: in the order in which they cover one another.
  /// InvalidArgument: an empty root, levels out of range, a layer that does not touch the picture or has not
  /// 4 channels.
  static Result<Synthesis> make(const Image& root, const std::vector<DetailLayer>& layers,
                                const SynthesisOptions& options);

  int width() const { return root_.region.width() << options_.levels; }
  int height() const { return root_.region.height() << options_.levels; }
  /// Pixels of `region`, which lies inside the picture, at `level` (options.levels: the finest).
  SynthesisTile tile(const Region& region, int level) const;
  SynthesisTile tile(const Region& region) const { return tile(region, options_.levels); }
  const Exemplars& exemplars() const { return *exemplars_; }

 private:
  Synthesis() = default;
  Region whole(int level) const {
    return {0, 0, root_.region.width() << level, root_.region.height() << level};
  }
  friend class SynthesisLevel;

  SynthesisOptions options_;
  ColorGrid root_;
  std::vector<LayerPyramid> layers_;
  std::shared_ptr<const Exemplars> exemplars_;
  std::shared_ptr<const Strengths> strengths_;
};

}  // namespace floatstage::detail
