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

Result<void> PairwiseFlows::estimate_with_depth(const ProjectedImages& images, const Parallaxes& parallaxes,
                                                double share, const std::vector<bool>& wanted,
                                                const FlowOptions& options, int threads,
                                                Interruption* interruption) {
  const std::size_t count = images.gray.size();
  const bool alone = share >= 1;
  if (!alone) halve_images(images, half_);
  confidence_.clear();  // of the picture before
  Result<void> depth, flows;
  // Two halves of about the same work.
  parallel_for(alone ? 1 : 2, threads, [&](std::size_t half) {
    if (half == 0)
      depth = depth_.estimate(images, parallaxes, interruption);
    else
      flows = estimate(half_, wanted, options, threads, interruption);
  });
  for (const Result<void>* ok : {&depth, &flows})
    if (!*ok) return *ok;
  pairs_ = count * (count - 1);
  fields_.resize(std::max(fields_.size(), pairs_));
  mixed_.resize(std::max(mixed_.size(), pairs_));
  for (std::size_t index = 0; index < pairs_; ++index) make_zero(mixed_[index], images);
  const auto rows = static_cast<std::size_t>(images.height);
  const auto weight = static_cast<float>(std::min(share, 1.0));
  parallel_for(count * rows, threads, [&](std::size_t item) {
    mix(parallaxes, item / rows, static_cast<int>(item % rows), weight, wanted);
  });
  fields_.swap(mixed_);
  if (keeps_confidence_) mix_confidence(images, weight, wanted);
  return {};
}

// Row `row` of the fields from image `image`.
void PairwiseFlows::mix(const Parallaxes& parallaxes, std::size_t image, int row, float share,
                        const std::vector<bool>& wanted) {
  const std::size_t count = wanted.size();
  const int width = parallaxes.width;
  const std::size_t line = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
  for (int x = 0; x < width; ++x) {
    const DepthFlow::Home home = depth_.home(parallaxes, image, x, row);
    for (std::size_t j = 0; j < count; ++j) {
      if (j == image || !wanted[j]) continue;
      const std::size_t index = flow_index_of({image, j}, count);
      float* uv = mixed_[index].uv.data() + 2 * (line + static_cast<std::size_t>(x));
      uv[0] = share * home.e * (parallaxes.x[j][home.at] - parallaxes.x[image][home.at]);
      uv[1] = share * home.e * (parallaxes.y[j][home.at] - parallaxes.y[image][home.at]);
    }
  }
  if (share >= 1) return;
  // What pairs say, enlarged: each pixel lies three quarters in one of theirs.
  const int half_width = half_.width, near = row / 2,
            far = std::clamp(row % 2 == 0 ? near - 1 : near + 1, 0, half_.height - 1);
  const float scale = 2 * (1 - share);
  for (std::size_t j = 0; j < count; ++j) {
    if (j == image || !wanted[j]) continue;
    const std::size_t index = flow_index_of({image, j}, count);
    const auto at = [&](int y) {
      return fields_[index].uv.data() +
             2 * static_cast<std::size_t>(y) * static_cast<std::size_t>(half_width);
    };
    const float *a = at(near), *b = at(far);
    float* uv = mixed_[index].uv.data() + 2 * line;
    for (int x = 0; x < width; ++x) {
      const int here = x / 2, beside = std::clamp(x % 2 == 0 ? here - 1 : here + 1, 0, half_width - 1);
      for (int c = 0; c < 2; ++c)
        uv[2 * x + c] += scale * (0.75F * (0.75F * a[2 * here + c] + 0.25F * a[2 * beside + c]) +
                                  0.25F * (0.75F * b[2 * here + c] + 0.25F * b[2 * beside + c]));
    }
  }
}

void PairwiseFlows::mix_confidence(const ProjectedImages& images, float share,
                                   const std::vector<bool>& wanted) {
  const auto width = static_cast<std::size_t>(images.width), height = static_cast<std::size_t>(images.height),
             half_width = (width + 1) / 2;
  confidence_.resize(pairs_);
  for (std::size_t index = 0; index < pairs_; ++index) {
    if (!wanted[flow_pair_at(index, wanted.size()).second]) continue;
    std::vector<std::uint8_t>& of_pair = confidence_[index];
    const std::vector<std::uint8_t> half = std::move(of_pair);
    of_pair.assign(width * height, 0);
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        const auto depth = static_cast<float>(depth_.believed()[y * width + x]);
        const float pair = half.empty() ? depth : static_cast<float>(half[y / 2 * half_width + x / 2]);
        of_pair[y * width + x] = static_cast<std::uint8_t>(share * depth + (1 - share) * pair + 0.5F);
      }
  }
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
