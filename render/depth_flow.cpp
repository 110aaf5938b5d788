#include "render/depth_flow.h"

#include <algorithm>
#include <cmath>

#include "render/flow/gray_samples.h"

namespace floatstage::render {
namespace {

constexpr int kLeastSide = 20;  // px of the coarsest level, as the variational flow's
constexpr int kFinestWarps = 2, kMostWarps = 8, kFinestSweeps = 5, kMostDoublings = 2;
// Of the smoothness against all pairs' data: chosen on the light field, temple, sparse ring, dino, green
// dome, studio (with 4 px of calibration error, too) and a rendered gym (docs/constants.md).
constexpr float kStiffness = 12;
constexpr float kLeastShare = 1e-4F;  // pairs that count less are left out
constexpr float kUsualResidual = 10;  // 8-bit steps, mean over a neighbourhood: believed half
constexpr int kNeighborhood = 2;      // px to each side
constexpr int kAcross = 2 * kNeighborhood + 1;
constexpr int kReturns = 3;  // steps from an image's pixel back to the view's

FlowEnergy energy() {
  FlowEnergy energy;
  energy.smooth_epsilon2 = 0.05F;
  return energy;
}

/// The mean over those of the four finer pixels that are inside.
void halve(const SplitPlane& fine, const SplitPlane& inside, SplitPlane& coarse, std::vector<float>& row) {
  const int width = coarse.width();
  row.resize(static_cast<std::size_t>(width));
  for (int y = 0; y < coarse.height(); ++y) {
    const int top = 2 * y, bottom = std::min(top + 1, fine.height() - 1);
    const float once = bottom > top ? 1.F : 0.F;  // the last of an odd number of rows counts once
    const ConstSplitRow a = fine.row(top), b = fine.row(bottom), in = inside.row(top),
                        in_below = inside.row(bottom);
    for (int x = 0; x < width; ++x) {
      const float sum = (a.even[x] + a.odd[x]) + once * (b.even[x] + b.odd[x]),
                  count = (in.even[x] + in.odd[x]) + once * (in_below.even[x] + in_below.odd[x]);
      row[static_cast<std::size_t>(x)] = count > 0 ? sum / count : 0.F;
    }
    split_row(row.data(), width, 1, coarse.row(y));
  }
}

}  // namespace

void DepthFlow::lay_out(const ProjectedImages& images, const Parallaxes& parallaxes, int levels) {
  const std::size_t count = images.gray.size();
  pyramids_.resize(std::max(pyramids_.size(), count));
  PyramidOptions options;
  options.stiffness = kStiffness;
  for (std::size_t i = 0; i < count; ++i)
    pyramids_[i].build({width_, height_, images.gray[i].data(), images.state[i].data()}, levels, options);
  pairs_.clear();
  float all = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j) {
      const float both = parallaxes.share[i] * parallaxes.share[j];
      if (both < kLeastShare) continue;
      pairs_.push_back({i, j, both});
      all += both;
    }
  for (DepthPairShare& pair : pairs_) pair.share /= all;
  levels_.resize(std::max(levels_.size(), static_cast<std::size_t>(levels)));
  for (int l = 0; l < levels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.pictures.resize(count);
    level.directions.resize(std::max(level.directions.size(), count));
    for (std::size_t i = 0; i < count; ++i) level.pictures[i] = &pyramids_[i].level(l);
    const PictureLevel& first = *level.pictures[0];
    const int width = first.width, height = first.height;
    level.inside.resize(width, height);
    level.stiffness.resize(width, height);
    row_.resize(static_cast<std::size_t>(width));
    const float even = 1 / static_cast<float>(count);
    for (int y = 0; y < height; ++y) {
      const std::uint8_t* zone = first.zone.data() + first.at(0, y);
      for (int x = 0; x < width; ++x)
        row_[static_cast<std::size_t>(x)] = zone[x] == PictureLevel::kDomain ? 1.F : 0.F;
      split_row(row_.data(), width, 1, level.inside.row(y));
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
    }
    for (std::size_t i = 0; i < count; ++i) {
      DepthLevel::Direction& to = level.directions[i];
      to.x.resize(width, height);
      to.y.resize(width, height);
      if (l > 0) {
        const Level& fine = levels_[static_cast<std::size_t>(l - 1)];
        halve(fine.directions[i].x, fine.inside, to.x, row_);
        halve(fine.directions[i].y, fine.inside, to.y, row_);
        continue;
      }
      for (int y = 0; y < height; ++y) {
        const std::size_t line = first.at(0, y);
        split_row(parallaxes.x[i].data() + line, width, 1, to.x.row(y));
        split_row(parallaxes.y[i].data() + line, width, 1, to.y.row(y));
      }
    }
  }
}

void DepthFlow::solve(int levels) {
  const FlowEnergy e = energy();
  const FlowKernels& kernels = native_flow_kernels();
  for (int l = levels - 1; l >= 0; --l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const PictureLevel& first = *level.pictures[0];
    if (l + 1 < levels)
      enlargement_.bilinear(first, levels_[static_cast<std::size_t>(l) + 1].e, level.e);
    else
      level.e.reset(first.width, first.height);
    sweep_.reset(first.width, first.height, kFinestSweeps << std::min(l, kMostDoublings),
                 level.pictures.size(), pairs_.size());
    for (int k = 0; k < std::min(kFinestWarps + l, kMostWarps); ++k)
      sweep_.run(kernels, e, level, pairs_, level.e);
  }
}

// How far the images differ along row y, as they are and as they are read: sums over a neighbourhood along
// the row, and by how much of the pairs.
void DepthFlow::differ(const ProjectedImages& images, const Parallaxes& parallaxes, int y) {
  const auto width = static_cast<std::size_t>(width_);
  float *before = before_.data() + static_cast<std::size_t>((y + kAcross) % kAcross) * width,
        *after = after_.data() + static_cast<std::size_t>((y + kAcross) % kAcross) * width,
        *said = said_.data() + static_cast<std::size_t>((y + kAcross) % kAcross) * width;
  for (float* sum : {before, after, said}) std::fill_n(sum, width, 0.F);
  if (y < 0 || y >= height_) return;
  const std::size_t line = static_cast<std::size_t>(y) * width;
  for (std::vector<float>& apart : apart_) std::fill(apart.begin(), apart.end(), 0.F);
  float *still = apart_[0].data() + kNeighborhood, *moved = apart_[1].data() + kNeighborhood,
        *both = apart_[2].data() + kNeighborhood;
  for (std::size_t i = 0; i < images.gray.size(); ++i) {
    const float *ux = parallaxes.x[i].data() + line, *uy = parallaxes.y[i].data() + line;
    const std::uint8_t *gray = images.gray[i].data(), *state = images.state[i].data();
    for (std::size_t x = 0; x < width; ++x) {
      own_[i][x] = 0;
      if (state[line + x] == ProjectedImages::kNoProxy) continue;
      const float px = static_cast<float>(x) + e_[line + x] * ux[x],
                  py = static_cast<float>(y) + e_[line + x] * uy[x];
      read_[i][x] = bilinear_sample(gray, width_, height_, px, py);
      const int at_x = static_cast<int>(std::floor(px + 0.5F)),
                at_y = static_cast<int>(std::floor(py + 0.5F));
      const bool within = at_x >= 0 && at_y >= 0 && at_x < width_ && at_y < height_;
      own_[i][x] = state[line + x] == ProjectedImages::kOwn && within &&
                   state[static_cast<std::size_t>(at_y) * width + static_cast<std::size_t>(at_x)] ==
                       ProjectedImages::kOwn;
    }
  }
  for (const DepthPairShare& pair : pairs_) {
    const std::uint8_t *a = images.gray[pair.first].data() + line,
                       *b = images.gray[pair.second].data() + line;
    const float *read_a = read_[pair.first].data(), *read_b = read_[pair.second].data();
    const std::uint8_t *own_a = own_[pair.first].data(), *own_b = own_[pair.second].data();
    for (std::size_t x = 0; x < width; ++x) {
      if (own_a[x] == 0 || own_b[x] == 0) continue;
      still[x] += pair.share * static_cast<float>(std::abs(a[x] - b[x]));
      moved[x] += pair.share * std::abs(read_a[x] - read_b[x]);
      both[x] += pair.share;
    }
  }
  for (std::ptrdiff_t x = 0; x < width_; ++x) {
    const auto sum = [x](const float* v) { return (v[x - 2] + v[x - 1]) + v[x] + (v[x + 1] + v[x + 2]); };
    before[x] = sum(still);
    after[x] = sum(moved);
    said[x] = sum(both);
  }
}

// Displacements are kept as far as images are alike where they lead, and more so than without.
void DepthFlow::judge(const ProjectedImages& images, const Parallaxes& parallaxes) {
  const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
  const std::size_t count = images.gray.size();
  before_.resize(kAcross * width);
  after_.resize(kAcross * width);
  for (std::vector<float>& apart : apart_) apart.resize(width + 2 * kNeighborhood);
  read_.resize(std::max(read_.size(), count));
  own_.resize(std::max(own_.size(), count));
  for (std::size_t i = 0; i < count; ++i) {
    read_[i].resize(width);
    own_[i].resize(width);
  }
  said_.resize(kAcross * width);
  known_.assign(width * height, 0);
  for (int y = -kNeighborhood; y < kNeighborhood; ++y) differ(images, parallaxes, y);
  for (int y = 0; y < height_; ++y) {
    differ(images, parallaxes, y + kNeighborhood);
    const std::size_t line = static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) {
      float still = 0, moved = 0, said = 0;
      for (std::size_t k = 0; k < kAcross; ++k) {
        still += before_[k * width + x];
        moved += after_[k * width + x];
        said += said_[k * width + x];
      }
      if (said <= 0 || images.state[0][line + x] == ProjectedImages::kNoProxy) continue;
      known_[line + x] = static_cast<std::uint8_t>(
          255 * confidence_left(moved, kUsualResidual * said) * confidence_left(moved, still) + 0.5F);
    }
  }
}

Result<void> DepthFlow::estimate(const ProjectedImages& images, const Parallaxes& parallaxes,
                                 Interruption* interruption) {
  width_ = images.width;
  height_ = images.height;
  const int levels = pyramid_levels(width_, height_, kLeastSide);
  lay_out(images, parallaxes, levels);
  if (interruption != nullptr && interruption->given_up()) return given_up();
  const auto width = static_cast<std::size_t>(width_);
  e_.assign(width * static_cast<std::size_t>(height_), 0.F);
  known_.assign(e_.size(), 0);
  if (pairs_.empty()) return {};
  solve(levels);
  const Level& finest = levels_[0];
  for (int y = 0; y < height_; ++y) {
    const ConstSplitRow from = finest.e.row(y), inside = finest.inside.row(y);
    float* to = e_.data() + static_cast<std::size_t>(y) * width;
    for (int i = 0; i < (width_ + 1) / 2; ++i) to[2 * i] = from.even[i] * inside.even[i];
    for (int i = 0; i < width_ / 2; ++i) to[2 * i + 1] = from.odd[i] * inside.odd[i];
  }
  if (interruption != nullptr && interruption->given_up()) return given_up();
  judge(images, parallaxes);
  fill_.run(width_, height_, 1, known_.data(), e_.data());
  return {};
}

DepthFlow::Home DepthFlow::home(const Parallaxes& parallaxes, std::size_t image, int x, int y) const {
  const auto px = static_cast<float>(x), py = static_cast<float>(y);
  Home home{0, static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)};
  float at_x = px, at_y = py;
  for (int k = 0; k < kReturns; ++k) {
    const int a = std::clamp(static_cast<int>(at_x + 0.5F), 0, width_ - 1),
              b = std::clamp(static_cast<int>(at_y + 0.5F), 0, height_ - 1);
    home.e = bilinear_sample(e_.data(), width_, height_, at_x, at_y);
    home.at = static_cast<std::size_t>(b) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(a);
    at_x = px - home.e * parallaxes.x[image][home.at];
    at_y = py - home.e * parallaxes.y[image][home.at];
  }
  return home;
}

}  // namespace floatstage::render
