#include "render/depth_flow.h"

#include <algorithm>

#include "core/check.h"
#include "core/parallel.h"
#include "render/flow/variational_preset.h"

namespace floatstage::render {
namespace {

// Of the smoothness against all pairs' data: chosen on the light field, temple, sparse ring, dino, green
// dome, studio (with 4 px of calibration error, too) and a rendered gym (docs/constants.md).
constexpr float kStiffness = 12;
constexpr float kLeastShare = 1e-4F;  // pairs that count less are left out

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The mean over those of the four finer pixels that are inside.
void halve(const SplitPlane& fine, const SplitPlane& inside, SplitPlane& coarse, std::vector<float>& row) {
  const int width = coarse.width();
  row.resize(at(width));
  for (int y = 0; y < coarse.height(); ++y) {
    const int top = 2 * y, bottom = std::min(top + 1, fine.height() - 1);
    const float once = bottom > top ? 1.F : 0.F;  // the last of an odd number of rows counts once
    const ConstSplitRow a = fine.row(top), b = fine.row(bottom), in = inside.row(top),
                        in_below = inside.row(bottom);
    for (int x = 0; x < width; ++x) {
      const float sum = (a.even[x] + a.odd[x]) + once * (b.even[x] + b.odd[x]),
                  count = (in.even[x] + in.odd[x]) + once * (in_below.even[x] + in_below.odd[x]);
      row[at(x)] = count > 0 ? sum / count : 0.F;
    }
    split_row(row.data(), width, 1, coarse.row(y));
  }
}

// Calls body(y, band) for all rows, on so many threads as there are bands.
template <class Body>
void for_rows_in_bands(int height, int threads, const Body& body) {
  const int bands = std::max(1, std::min(height, threads));
  parallel_for(at(bands), threads, [&](std::size_t band) {
    const int k = static_cast<int>(band);
    for (int y = height * k / bands; y < height * (k + 1) / bands; ++y) body(y, band);
  });
}

}  // namespace

void DepthFlow::find_pairs(const Parallaxes& parallaxes) {
  pairs_.clear();
  float all = 0;
  for (std::size_t i = 0; i < parallaxes.share.size(); ++i)
    for (std::size_t j = i + 1; j < parallaxes.share.size(); ++j) {
      const float both = parallaxes.share[i] * parallaxes.share[j];
      if (both < kLeastShare) continue;
      pairs_.push_back({i, j, both});
      all += both;
    }
  for (DepthPairShare& pair : pairs_) pair.share /= all;
}

// Where there is something, and how stiff it is: as all pictures say.
void DepthFlow::lay_out_surface(int l, int threads) {
  Level& level = levels_[at(l)];
  const std::size_t count = level.pictures.size();
  const PictureLevel& first = *level.pictures[0];
  level.inside.resize(first.width, first.height);
  level.stiffness.resize(first.width, first.height);
  const float even = 1 / static_cast<float>(count);
  for_rows_in_bands(first.height, threads, [&](int y, std::size_t band) {
    std::vector<float>& row = rows_[band];
    row.resize(at(first.width));
    const std::uint8_t* zone = first.zone.data() + first.at(0, y);
    for (int x = 0; x < first.width; ++x) row[at(x)] = zone[x] == PictureLevel::kDomain ? 1.F : 0.F;
    split_row(row.data(), first.width, 1, level.inside.row(y));
    const SplitRow out = level.stiffness.row(y);
    for (int i = 0; i < level.stiffness.whole_row().end; ++i) {
      float sum_even = 0, sum_odd = 0;
      for (const PictureLevel* picture : level.pictures) {
        const ConstSplitRow from = picture->stiffness.row(y);
        sum_even += from.even[i];
        sum_odd += from.odd[i];
      }
      out.even[i] = even * sum_even;
      out.odd[i] = even * sum_odd;
    }
  });
}

void DepthFlow::lay_out_directions(const Parallaxes& parallaxes, std::size_t image, int levels) {
  std::vector<float>& row = rows_[image];
  for (int l = 0; l < levels; ++l) {
    const PictureLevel& picture = *levels_[at(l)].pictures[0];
    DepthLevel::Direction& to = levels_[at(l)].directions[image];
    to.x.resize(picture.width, picture.height);
    to.y.resize(picture.width, picture.height);
    if (l > 0) {
      const Level& fine = levels_[at(l - 1)];
      halve(fine.directions[image].x, fine.inside, to.x, row);
      halve(fine.directions[image].y, fine.inside, to.y, row);
      continue;
    }
    for (int y = 0; y < picture.height; ++y) {
      const std::size_t line = picture.at(0, y);
      split_row(parallaxes.x[image].data() + line, picture.width, 1, to.x.row(y));
      split_row(parallaxes.y[image].data() + line, picture.width, 1, to.y.row(y));
    }
  }
}

void DepthFlow::lay_out(const ProjectedImages& images, const Parallaxes& parallaxes, int levels,
                        int threads) {
  const std::size_t count = images.gray.size();
  pyramids_.resize(std::max(pyramids_.size(), count));
  rows_.resize(std::max({rows_.size(), count, at(threads)}));
  levels_.resize(std::max(levels_.size(), at(levels)));
  PyramidOptions options;
  options.stiffness = kStiffness;
  parallel_for(count, threads, [&](std::size_t i) {
    pyramids_[i].shrink({images.width, images.height, images.gray[i].data(), images.state[i].data()}, levels);
  });
  // The large levels first: they are shared out evenly.
  parallel_for(count * at(levels), threads,
               [&](std::size_t k) { pyramids_[k % count].finish(static_cast<int>(k / count), options); });
  for (int l = 0; l < levels; ++l) {
    Level& level = levels_[at(l)];
    level.pictures.resize(count);
    level.directions.resize(std::max(level.directions.size(), count));
    for (std::size_t i = 0; i < count; ++i) level.pictures[i] = &pyramids_[i].level(l);
    lay_out_surface(l, threads);
  }
  parallel_for(count, threads, [&](std::size_t i) { lay_out_directions(parallaxes, i, levels); });
}

DepthSweep::Problem DepthFlow::problem(const SolverOptions& options, int level) {
  return {&native_flow_kernels(), &options.energy, options.cubic,
          &levels_[at(level)],    pairs_,          &levels_[at(level)].e};
}

// A warp follows the one before it on another thread, a few rows behind.
void DepthFlow::warp(const SolverOptions& options, int l, int threads) {
  const PictureLevel& first = *levels_[at(l)].pictures[0];
  const std::size_t warps = at(options.warps_at(l)), at_once = std::min(sweeps_.size(), warps);
  FLOATSTAGE_CHECK(warps <= kMostWarps, "a level has no more warps than presets allow");
  for (std::size_t i = 0; i < at_once; ++i)
    sweeps_[i].reset(first.width, first.height, options.sweeps_at(l), levels_[at(l)].pictures.size(),
                     pairs_.size());
  for (std::size_t k = 0; k < warps; ++k) progress_[k].begin();
  const DepthSweep::Problem problem = this->problem(options, l);
  parallel_for(warps, threads, [&](std::size_t k) {
    sweeps_[k % at_once].run(problem, k > 0 ? &progress_[k - 1] : nullptr, progress_[k]);
  });
}

void DepthFlow::hand_out(int threads) {
  // Nothing is known off the proxy, where the filling goes on by itself.
  const SplitPlane& e = levels_[0].e;
  e_.resize(known_.size());
  for_rows_in_bands(e.height(), threads, [&](int y, std::size_t) {
    join_row(e.row(y), e.width(), e_.data() + at(y) * at(e.width()));
  });
}

Result<void> DepthFlow::estimate(const ProjectedImages& images, const Parallaxes& parallaxes,
                                 const FlowOptions& flow, int wanted_threads, Interruption* interruption) {
  const Result<VariationalPreset> preset = variational_preset(flow);
  if (!preset) return forward(preset);
  const auto ended = [&] { return interruption != nullptr && interruption->given_up(); };
  const SolverOptions& options = preset->solver;
  const int threads = wanted_threads > 0 ? wanted_threads : default_threads();
  sweeps_.resize(std::max(sweeps_.size(), at(threads)));
  find_pairs(parallaxes);
  const int levels = variational_levels(images.width, images.height, options.finest);
  lay_out(images, parallaxes, levels, threads);
  if (ended()) return given_up();
  for (int l = levels - 1; l >= 0; --l) {
    Level& level = levels_[at(l)];
    if (l + 1 < levels)
      enlargement_.bilinear(*level.pictures[0], levels_[at(l) + 1].e, level.e);
    else
      level.e.reset(level.pictures[0]->width, level.pictures[0]->height);
    if (l >= options.finest && !pairs_.empty()) warp(options, l, threads);
  }
  if (ended()) return given_up();
  judge_.run(problem(options, 0), threads, known_);
  hand_out(threads);
  fill_.run(images.width, images.height, 1, known_.data(), e_.data());
  return {};
}

}  // namespace floatstage::render
