#include "render/pairwise_flows.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "render/image_fill.h"

namespace floatstage::render {
namespace {

constexpr float kNoise = 0.15F,
                kCertain = 0.45F;  // px: displacements the flow invents, and those to be followed

struct Pair {
  std::size_t from, to;
};

Pair pair_at(std::size_t index, std::size_t images) {
  const std::size_t from = index / (images - 1), rest = index % (images - 1);
  return {from, rest < from ? rest : rest + 1};
}

std::size_t index_of(Pair pair, std::size_t images) {
  return pair.from * (images - 1) + (pair.to < pair.from ? pair.to : pair.to - 1);
}

/// Where the projections already meet, the flow still jitters by a fraction of a pixel (resampling noise):
/// following it would only blur. Such displacements become zero, larger ones stay as they are.
void drop_jitter(FlowField& field) {
  for (std::size_t i = 0; i < field.uv.size(); i += 2) {
    const float length = std::hypot(field.uv[i], field.uv[i + 1]);
    const float keep = std::clamp((length - kNoise) / (kCertain - kNoise), 0.F, 1.F);
    field.uv[i] *= keep;
    field.uv[i + 1] *= keep;
  }
}

}  // namespace

Result<void> PairwiseFlows::estimate(const ProjectedImages& images, const std::vector<bool>& wanted,
                                     const FlowOptions& options, int threads) {
  const std::size_t count = images.gray.size(), pairs = count * (count - 1);
  if (options.backend == "none") {
    fields_.resize(pairs);
    for (FlowField& field : fields_) {
      field.width = images.width;
      field.height = images.height;
      field.uv.assign(2 * images.gray.front().size(), 0);
    }
    return {};
  }
  if (options_ != options) estimator_.reset();
  options_ = options;
  if (!estimator_) {
    auto made = make_flow_estimator(options);
    if (!made) return forward(made);
    estimator_ = std::move(*made);
  }
  std::vector<FlowImage> pictures;
  for (std::size_t i = 0; i < count; ++i)
    pictures.push_back({images.width, images.height, images.gray[i].data(), images.state[i].data()});
  std::vector<FlowPair> asked;
  std::vector<std::size_t> place(pairs, pairs);  // of a pair among those that are asked for
  for (std::size_t index = 0; index < pairs; ++index) {
    const Pair pair = pair_at(index, count);
    if (!wanted[pair.to]) continue;
    place[index] = asked.size();
    asked.push_back({pair.from, pair.to});
  }
  raw_.resize(std::max(raw_.size(), asked.size()));
  if (Result<void> ok = estimator_->estimate(pictures, asked, {}, threads, {raw_.data(), asked.size()}); !ok)
    return ok;

  fields_.resize(pairs);
  parallel_for(pairs, threads, [&](std::size_t index) {
    const Pair pair = pair_at(index, count);
    FlowField& field = fields_[index];
    if (!wanted[pair.to]) {
      field.width = images.width;
      field.height = images.height;
      field.uv.assign(2 * images.gray[pair.from].size(), 0);
      return;
    }
    field = raw_[place[index]];
    const FlowField* back = wanted[pair.from] ? &raw_[place[index_of({pair.to, pair.from}, count)]] : nullptr;
    fill_unknown(images.width, images.height, 2, trusted(images, pair.from, pair.to, field, back),
                 field.uv.data());
    drop_jitter(field);
  });
  return {};
}

}  // namespace floatstage::render
