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

void continue_beyond_proxy(int width, int height, const std::vector<std::uint8_t>& state,
                           std::vector<std::uint8_t>& gray) {
  std::vector<bool> known(state.size());
  std::vector<float> values(gray.begin(), gray.end());
  for (std::size_t i = 0; i < state.size(); ++i) known[i] = state[i] != ProjectedImages::kNoProxy;
  fill_unknown(width, height, 1, known, values.data());
  for (std::size_t i = 0; i < gray.size(); ++i)
    if (!known[i]) gray[i] = static_cast<std::uint8_t>(std::clamp(std::lround(values[i]), 0L, 255L));
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

Result<void> PairwiseFlows::estimate(ProjectedImages images, const std::vector<bool>& wanted,
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
  if (options_ != options) estimators_.clear();
  options_ = options;
  while (estimators_.size() < pairs) {
    auto estimator = make_flow_estimator(options);
    if (!estimator) return forward(estimator);
    estimators_.push_back(std::move(*estimator));
  }
  parallel_for(count, threads, [&](std::size_t i) {
    continue_beyond_proxy(images.width, images.height, images.state[i], images.gray[i]);
  });

  std::vector<Result<FlowField>> raw(pairs, Result<FlowField>(FlowField{}));
  parallel_for(pairs, threads, [&](std::size_t index) {
    const Pair pair = pair_at(index, count);
    if (!wanted[pair.to]) return;
    raw[index] = estimators_[index]->estimate({images.width, images.height, images.gray[pair.from].data()},
                                              {images.width, images.height, images.gray[pair.to].data()});
  });
  for (const Result<FlowField>& field : raw)
    if (!field) return forward(field);

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
    field = *raw[index];
    const FlowField* back = wanted[pair.from] ? &*raw[index_of({pair.to, pair.from}, count)] : nullptr;
    fill_unknown(images.width, images.height, 2, trusted(images, pair.from, pair.to, *raw[index], back),
                 field.uv.data());
    drop_jitter(field);
  });
  return {};
}

}  // namespace floatstage::render
