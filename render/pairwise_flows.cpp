#include "render/pairwise_flows.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/parallel.h"

namespace floatstage::render {
namespace {

constexpr float kNoise = 0.15F,
                kCertain = 0.45F;  // px: displacements the flow invents, and those to be followed
constexpr std::size_t kNotAsked = static_cast<std::size_t>(-1);

/// Where the projections already meet, the flow still jitters by a fraction of a pixel (resampling noise):
/// following it would only blur. Such displacements become zero, larger ones stay as they are.
void drop_jitter(FlowField& field) {
  for (std::size_t i = 0; i < field.uv.size(); i += 2) {
    float &u = field.uv[i], &v = field.uv[i + 1];
    const float square = u * u + v * v;
    if (square >= kCertain * kCertain) continue;
    const float keep =
        square <= kNoise * kNoise ? 0 : std::min((std::sqrt(square) - kNoise) / (kCertain - kNoise), 1.F);
    u *= keep;
    v *= keep;
  }
}

void make_zero(FlowField& field, const ProjectedImages& images) {
  field.width = images.width;
  field.height = images.height;
  field.uv.assign(2 * images.gray[0].size(), 0);
}

}  // namespace

FlowPair flow_pair_at(std::size_t index, std::size_t images) {
  const std::size_t from = index / (images - 1), rest = index % (images - 1);
  return {from, rest < from ? rest : rest + 1};
}

std::size_t flow_index_of(FlowPair pair, std::size_t images) {
  return pair.first * (images - 1) + (pair.second < pair.first ? pair.second : pair.second - 1);
}

Result<void> PairwiseFlows::estimate(const ProjectedImages& images, const std::vector<bool>& wanted,
                                     const FlowOptions& options, int threads, Interruption* interruption) {
  const std::size_t count = images.gray.size(), pairs = count * (count - 1);
  pairs_ = pairs;
  fields_.resize(std::max(fields_.size(), pairs));
  confidence_.assign(keeps_confidence_ ? pairs : 0, {});
  if (options.backend == "none") {
    for (std::size_t index = 0; index < pairs; ++index) make_zero(fields_[index], images);
    return {};
  }
  if (options_ != options) estimator_.reset();
  options_ = options;
  if (!estimator_) {
    auto made = make_flow_estimator(options);
    if (!made) return forward(made);
    estimator_ = std::move(*made);
  }
  estimator_->watch(interruption);
  pictures_.clear();
  for (std::size_t i = 0; i < count; ++i)
    pictures_.push_back({images.width, images.height, images.gray[i].data(), images.state[i].data()});
  asked_.clear();
  place_.assign(pairs, kNotAsked);
  for (std::size_t index = 0; index < pairs; ++index) {
    const FlowPair pair = flow_pair_at(index, count);
    if (!wanted[pair.second]) continue;
    place_[index] = asked_.size();
    asked_.push_back(pair);
  }
  raw_.resize(std::max(raw_.size(), asked_.size()));
  if (Result<void> ok = estimator_->estimate(pictures_, asked_, {}, threads, {raw_.data(), asked_.size()});
      !ok)
    return ok;

  const std::size_t workers =
      std::min(pairs, static_cast<std::size_t>(threads > 0 ? threads : default_threads()));
  workers_.resize(std::max(workers_.size(), workers));
  const auto ended = [&] { return interruption != nullptr && interruption->given_up(); };
  std::atomic<std::size_t> next = 0;
  parallel_for(workers, threads, [&](std::size_t worker) {
    for (std::size_t index; (index = next.fetch_add(1)) < pairs && !ended();)
      make_dependable(images, index, workers_[worker]);
  });
  if (ended()) return given_up();
  return {};
}

void PairwiseFlows::make_dependable(const ProjectedImages& images, std::size_t index, Worker& worker) {
  FlowField& field = fields_[index];
  if (place_[index] == kNotAsked) return make_zero(field, images);
  const std::size_t count = images.gray.size();
  const FlowPair pair = flow_pair_at(index, count);
  field = raw_[place_[index]];
  const std::size_t home = place_[flow_index_of({pair.second, pair.first}, count)];
  const FlowField* back = home == kNotAsked ? nullptr : &raw_[home];
  const std::vector<std::uint8_t>& believed = worker.trust.run(images, pair.first, pair.second, field, back);
  if (keeps_confidence_) confidence_[index] = believed;
  worker.fill.run(images.width, images.height, 2, believed.data(), field.uv.data());
  drop_jitter(field);
}

}  // namespace floatstage::render
