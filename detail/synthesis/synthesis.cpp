#include "detail/synthesis/synthesis.h"

#include "core/text.h"
#include "detail/synthesis/synthesis_level.h"

namespace floatstage::detail {

Result<Synthesis> Synthesis::make(const Image& root, const std::vector<DetailLayer>& layers,
                                  const SynthesisOptions& options) {
  if (root.empty() || root.channels != 3)
    return fail(ErrorCode::InvalidArgument, "the root of a synthesis is a picture of three channels");
  if (options.levels < 1 || options.levels > 6)
    return fail(ErrorCode::InvalidArgument, text("a synthesis has 1 to 6 levels, not ", options.levels));
  Synthesis out;
  out.options_ = options;
  out.root_ = to_colors(root);
  const Region whole = out.whole(options.levels);
  for (const DetailLayer& layer : layers) {
    if (layer.picture.channels != 4 || layer.picture.empty())
      return fail(ErrorCode::InvalidArgument, "a layer of a synthesis has four channels");
    if (layer.x < 0 || layer.y < 0 || layer.x + layer.picture.width > whole.x1 ||
        layer.y + layer.picture.height > whole.y1)
      return fail(ErrorCode::InvalidArgument, "a layer of a synthesis lies inside the picture");
    out.layers_.emplace_back(layer, options.levels);
  }
  out.exemplars_ =
      std::make_shared<const Exemplars>(out.layers_, options.levels, options.most, options.threads);
  out.strengths_ = std::make_shared<const Strengths>(out.root_, out.layers_, *out.exemplars_, options.levels);
  return out;
}

SynthesisTile Synthesis::tile(const Region& region, int level) const {
  if (level == 0) {
    SynthesisTile out{region, ColorGrid(region), Grid<std::uint8_t>(region),
                      Grid<Exemplars::Place>(region, Exemplars::kNowhere)};
    for (int y = region.y0; y < region.y1; ++y)
      for (int x = region.x0; x < region.x1; ++x) out.colors.at(x, y) = root_.at(x, y);
    return out;
  }
  const SynthesisLevel step(*this, level);
  return step.make(region, tile(step.needed(region), level - 1));
}

}  // namespace floatstage::detail
