// Method:  a coarse visual hull whose voxels are given labels by one energy
// Paper:   the hull: A. Laurentini, "The Visual Hull Concept", PAMI 1994; distances: G. Borgefors, "Distance
//          transformations in digital images", 1986; labels: core/label_energy.h
// Differs: a voxel is in the hull where its footprint, not its middle, meets the silhouettes, and a tenth of
//          the cameras may deny it
// ADR:     0298

#include "recon/label_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "core/label_energy.h"
#include "core/parallel.h"
#include "core/text.h"
#include "recon/hull_input.h"
#include "recon/stage_volume.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kMostVoxels = 64e6;
constexpr int kMayDeny = 10;     // one camera in so many
constexpr float kUnit = 1000;    // steps of the energy, a nat
constexpr float kBehind = 1.5F;  // voxels: what is no further behind the nearest one is in front, too

// How many pixels of any rectangle are subject.
class SubjectSums {
 public:
  explicit SubjectSums(const Matte& matte) : width_(matte.width), height_(matte.height) {
    if (matte.empty()) return;
    const auto w = static_cast<std::size_t>(width_) + 1;
    sums_.assign(w * (static_cast<std::size_t>(height_) + 1), 0);
    for (int y = 0; y < height_; ++y) {
      const std::uint8_t* row = matte.row(y);
      std::uint32_t sum = 0;
      for (int x = 0; x < width_; ++x) {
        sum += row[x] >= 128;
        sums_[(static_cast<std::size_t>(y) + 1) * w + static_cast<std::size_t>(x) + 1] =
            sums_[static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x) + 1] + sum;
      }
    }
  }
  bool empty() const { return sums_.empty(); }
  // Whether any is within half a footprint of a place.
  bool any(const Eigen::Vector2d& at, double footprint) const {
    const auto clamped = [](double v, int limit) {
      return std::clamp(static_cast<int>(std::floor(v)), 0, limit - 1);
    };
    const int x0 = clamped(at.x() - footprint / 2, width_), x1 = clamped(at.x() + footprint / 2, width_) + 1,
              y0 = clamped(at.y() - footprint / 2, height_),
              y1 = clamped(at.y() + footprint / 2, height_) + 1;
    const auto sum = [&](int x, int y) {
      return sums_[static_cast<std::size_t>(y) * (static_cast<std::size_t>(width_) + 1) +
                   static_cast<std::size_t>(x)];
    };
    return sum(x1, y1) + sum(x0, y0) > sum(x0, y1) + sum(x1, y0);
  }

 private:
  int width_, height_;
  std::vector<std::uint32_t> sums_;
};

// Where the hull is sought, and how many cameras see every point of it; nothing where it is not bounded.
std::optional<StageVolume> stage_of(const Rig& rig, std::span<const Matte> mattes) {
  StageFinder finder;
  StageVolume stage;
  if (!finder.find(rig, HullInput(rig, mattes, 1), stage)) return std::nullopt;
  return stage;
}

double focal(const CameraModel& m) { return std::max(m.fx, m.fy); }

struct Step {
  Vector3i by;
  float length;
};

std::vector<Step> steps() {
  std::vector<Step> all;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (const int axes = std::abs(x) + std::abs(y) + std::abs(z); axes > 0)
          all.push_back({{x, y, z}, axes == 1 ? 1.F : axes == 2 ? 4 / 3.F : 5 / 3.F});
  return all;
}

}  // namespace

std::size_t LabelVolume::at(const Vector3i& place) const {
  const Vector3i p = place - low_;
  return (static_cast<std::size_t>(p.z()) * static_cast<std::size_t>(count_.y()) +
          static_cast<std::size_t>(p.y())) *
             static_cast<std::size_t>(count_.x()) +
         static_cast<std::size_t>(p.x());
}

bool LabelVolume::inside(const Vector3i& place) const {
  const Vector3i p = place - low_;
  return (p.array() >= 0).all() && (p.array() < count_.array()).all();
}

double LabelVolume::edge_for(const Rig& rig, std::span<const Matte> mattes, int voxels) {
  const std::optional<StageVolume> stage = stage_of(rig, mattes);
  if (!stage || stage->box.isEmpty()) return 0;
  return std::cbrt(stage->box.sizes().prod() / voxels);
}

Result<LabelVolume> LabelVolume::carve(const Rig& rig, std::span<const Matte> mattes, double voxel,
                                       int labels, int threads) {
  const std::optional<StageVolume> stage = stage_of(rig, mattes);
  if (!stage) return fail(ErrorCode::BadData, "the silhouettes bound nothing");
  LabelVolume volume(rig, voxel, labels);
  const Eigen::AlignedBox3d& box = stage->box;
  if (box.isEmpty()) return volume;
  const int least = std::max(2, stage->cameras);
  if (const double many = (box.sizes() / voxel).prod(); !(many < kMostVoxels))
    return fail(ErrorCode::BadData, text("the silhouettes bound ", many, " voxels, which are too many"));
  volume.low_ = (box.min() / voxel).array().floor().cast<int>();
  volume.count_ = (box.max() / voxel).array().floor().cast<int>().matrix() - volume.low_ + Vector3i::Ones();
  std::vector<SubjectSums> sums;
  for (const Matte& m : mattes) sums.emplace_back(m);
  std::vector<std::vector<Vector3i>> slices(static_cast<std::size_t>(volume.count_.z()));
  parallel_for(slices.size(), threads, [&](std::size_t z) {
    for (int y = 0; y < volume.count_.y(); ++y)
      for (int x = 0; x < volume.count_.x(); ++x) {
        const Vector3i place = volume.low_ + Vector3i(x, y, static_cast<int>(z));
        const Vector3d world = voxel * (place.cast<double>() + Vector3d::Constant(0.5));
        int seen = 0, denied = 0;
        const int most = static_cast<int>(rig.cameras.size()) / kMayDeny;
        for (std::size_t c = 0; c < rig.cameras.size() && denied <= most; ++c) {
          if (sums[c].empty()) continue;
          const RigCamera& camera = rig.cameras[c];
          const Vector3d there = camera.cam_from_world * world;
          const std::optional<Eigen::Vector2d> at = project(camera.model, there);
          if (!at || !floatstage::inside(camera.model, *at)) continue;
          ++seen;
          denied += !sums[c].any(*at, voxel / there.z() * focal(camera.model));
        }
        if (seen - denied >= least && denied * kMayDeny <= seen) slices[z].push_back(place);
      }
  });
  for (const std::vector<Vector3i>& slice : slices)
    volume.places_.insert(volume.places_.end(), slice.begin(), slice.end());
  volume.link();
  volume.look(rig, threads);
  return volume;
}

void LabelVolume::link() {
  index_.assign(static_cast<std::size_t>(count_.cast<std::int64_t>().prod()), -1);
  for (std::size_t v = 0; v < places_.size(); ++v) index_[at(places_[v])] = static_cast<std::int32_t>(v);
}

// Which cells of its pictures a voxel covers. A cell is as wide as the nearest voxel.
void LabelVolume::look(const Rig& rig, int threads) {
  parallel_for(views_.size(), threads, [&](std::size_t c) {
    const RigCamera& camera = rig.cameras[c];
    View& view = views_[c];
    view.width = camera.model.width, view.height = camera.model.height;
    view.seen.resize(places_.size());
    std::vector<Eigen::Vector2f> places(places_.size());
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t v = 0; v < places_.size(); ++v) {
      const Vector3d there =
          camera.cam_from_world * Vector3d(voxel_ * (places_[v].cast<double>() + Vector3d::Constant(0.5)));
      const std::optional<Eigen::Vector2d> at = project(camera.model, there);
      if (!at || !floatstage::inside(camera.model, *at)) continue;
      view.seen[v].depth = static_cast<float>(there.z());
      places[v] = at->cast<float>();
      nearest = std::min(nearest, view.seen[v].depth);
    }
    const auto size = static_cast<float>(voxel_ * focal(camera.model));
    view.cell = std::clamp(static_cast<int>(std::ceil(size / nearest)), 1, std::max(view.width, view.height));
    view.columns = (view.width + view.cell - 1) / view.cell;
    view.rows = (view.height + view.cell - 1) / view.cell;
    for (std::size_t v = 0; v < places_.size(); ++v) {
      Seen& s = view.seen[v];
      if (s.depth < 0) continue;
      const float half = size / s.depth / 2;
      const auto cell = [&](float px, int limit) {
        return static_cast<std::uint16_t>(
            std::clamp(static_cast<int>(std::floor(px / static_cast<float>(view.cell))), 0, limit - 1));
      };
      s.x0 = cell(places[v].x() - half, view.columns), s.x1 = cell(places[v].x() + half, view.columns);
      s.y0 = cell(places[v].y() - half, view.rows), s.y1 = cell(places[v].y() + half, view.rows);
    }
  });
}

std::vector<float> LabelVolume::distance_to(std::span<const Vector3i> places) const {
  // On the box, with a rim from which no way leads, and what lies around it by its own distance to the box.
  const std::ptrdiff_t row = count_.x() + 2, slice = row * (count_.y() + 2);
  const auto cell = [&](const Vector3i& place) {
    const Vector3i p = place - low_;
    return static_cast<std::size_t>((p.z() + 1) * slice + (p.y() + 1) * row + p.x() + 1);
  };
  std::vector<float> away(static_cast<std::size_t>(slice) * static_cast<std::size_t>(count_.z() + 2), kFar);
  for (const Vector3i& p : places) {
    const Vector3i in = p.cwiseMax(low_).cwiseMin(low_ + count_ - Vector3i::Ones());
    float& there = away[cell(in)];
    there = std::min(there, (p - in).cast<float>().norm());
  }
  std::vector<std::pair<std::ptrdiff_t, float>> before;  // neighbours that come first, and how far they are
  for (const Step& step : steps()) {
    const std::ptrdiff_t offset = step.by.z() * slice + step.by.y() * row + step.by.x();
    if (offset < 0) before.emplace_back(offset, step.length);
  }
  const auto pass = [&](std::ptrdiff_t way) {  // onward 1, back -1
    for (int k = 0; k < count_.z(); ++k)
      for (int j = 0; j < count_.y(); ++j) {
        const std::ptrdiff_t z = way > 0 ? k : count_.z() - 1 - k, y = way > 0 ? j : count_.y() - 1 - j;
        float* here = away.data() + (z + 1) * slice + (y + 1) * row + (way > 0 ? 1 : count_.x());
        for (int i = 0; i < count_.x(); ++i, here += way)
          for (const auto& [offset, length] : before) *here = std::min(*here, here[way * offset] + length);
      }
  };
  pass(1);
  pass(-1);
  std::vector<float> out(places_.size());
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = std::min(away[cell(places_[v])], kFar);
  return out;
}

std::vector<float> LabelVolume::way_from(std::span<const std::size_t> start) const {
  std::vector<float> way(places_.size(), kFar);
  using Next = std::pair<float, std::size_t>;
  std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;
  for (const std::size_t v : start) {
    way[v] = 0;
    queue.emplace(0.F, v);
  }
  const std::vector<Step> all = steps();
  while (!queue.empty()) {
    const auto [length, v] = queue.top();
    queue.pop();
    if (length > way[v]) continue;
    for (const Step& step : all) {
      const Vector3i to = places_[v] + step.by;
      if (!inside(to) || index_[at(to)] < 0) continue;
      const auto n = static_cast<std::size_t>(index_[at(to)]);
      if (way[v] + step.length >= way[n]) continue;
      way[n] = way[v] + step.length;
      queue.emplace(way[n], n);
    }
  }
  return way;
}

// Of each cell, the depth of the nearest voxel that hides others.
std::vector<float> LabelVolume::nearest(const View& view, std::span<const std::uint8_t> labels) const {
  std::vector<float> depth(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows),
                           std::numeric_limits<float>::infinity());
  for (std::size_t v = 0; v < places_.size(); ++v) {
    const Seen& s = view.seen[v];
    if (s.depth < 0 || (!labels.empty() && labels[v] == 0)) continue;
    for (int y = s.y0; y <= s.y1; ++y)
      for (int x = s.x0; x <= s.x1; ++x) {
        float& d = depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.columns) +
                         static_cast<std::size_t>(x)];
        d = std::min(d, s.depth);
      }
  }
  return depth;
}

std::vector<std::size_t> LabelVolume::visible(int camera, std::span<const std::uint8_t> labels) const {
  const View& view = views_[static_cast<std::size_t>(camera)];
  const std::vector<float> depth = nearest(view, labels);
  const auto slack = kBehind * static_cast<float>(voxel_);
  std::vector<std::size_t> out;
  for (std::size_t v = 0; v < places_.size(); ++v) {
    const Seen& s = view.seen[v];
    if (s.depth < 0) continue;
    bool front = false;
    for (int y = s.y0; y <= s.y1 && !front; ++y)
      for (int x = s.x0; x <= s.x1 && !front; ++x)
        front = s.depth <= depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.columns) +
                                 static_cast<std::size_t>(x)] +
                               slack;
    if (front) out.push_back(v);
  }
  return out;
}

void LabelVolume::hear(int camera, std::span<const std::uint8_t> labels, std::span<const float> says,
                       float weight, Costs& costs) const {
  const View& view = views_[static_cast<std::size_t>(camera)];
  const auto many = static_cast<std::size_t>(labels_);
  std::vector<float> mean(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows) * many,
                          0.F);
  std::vector<float> heard(mean.size() / many, 0.F);
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const float* said = says.data() + (static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) +
                                         static_cast<std::size_t>(x)) *
                                            many;
      if (std::all_of(said, said + many, [](float s) { return s == 0; })) continue;
      const std::size_t cell =
          static_cast<std::size_t>(y / view.cell) * static_cast<std::size_t>(view.columns) +
          static_cast<std::size_t>(x / view.cell);
      heard[cell] += 1;
      for (std::size_t l = 0; l < many; ++l) mean[cell * many + l] += said[l];
    }
  for (const std::size_t v : visible(camera, labels)) {
    const Seen& s = view.seen[v];
    float pixels = 0;
    std::vector<float> sum(many, 0.F);
    for (int y = s.y0; y <= s.y1; ++y)
      for (int x = s.x0; x <= s.x1; ++x) {
        const std::size_t cell = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.columns) +
                                 static_cast<std::size_t>(x);
        pixels += heard[cell];
        for (std::size_t l = 0; l < many; ++l) sum[l] += mean[cell * many + l];
      }
    if (pixels == 0) continue;
    for (std::size_t l = 0; l < many; ++l) costs[v * (many + 1) + l + 1] -= weight * sum[l] / pixels;
  }
}

std::vector<std::uint8_t> LabelVolume::label(const Costs& costs, double smooth) const {
  LabelEnergy energy{labels_ + 1, {}, {}};
  energy.costs.reserve(costs.size());
  for (const float c : costs) energy.costs.push_back(std::lround(kUnit * c));
  const auto weight = static_cast<std::int32_t>(std::lround(kUnit * smooth));
  for (std::size_t v = 0; v < places_.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      Vector3i to = places_[v];
      ++to[axis];
      if (inside(to) && index_[at(to)] >= 0)
        energy.pairs.push_back({static_cast<int>(v), index_[at(to)], weight});
    }
  std::vector<std::uint8_t> labels(places_.size());
  const auto many = static_cast<std::size_t>(labels_) + 1;
  for (std::size_t v = 0; v < labels.size(); ++v) {
    const auto of = energy.costs.begin() + static_cast<std::ptrdiff_t>(v * many);
    labels[v] = static_cast<std::uint8_t>(std::min_element(of, of + static_cast<std::ptrdiff_t>(many)) - of);
  }
  minimize(energy, labels);
  return labels;
}

Image LabelVolume::picture(int camera, std::span<const std::uint8_t> labels) const {
  const View& view = views_[static_cast<std::size_t>(camera)];
  const std::vector<float> depth = nearest(view, labels);
  std::vector<std::uint8_t> cells(depth.size(), 0);
  for (std::size_t v = 0; v < places_.size(); ++v) {
    const Seen& s = view.seen[v];
    if (s.depth < 0 || labels[v] == 0) continue;
    for (int y = s.y0; y <= s.y1; ++y)
      for (int x = s.x0; x <= s.x1; ++x) {
        const std::size_t cell = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.columns) +
                                 static_cast<std::size_t>(x);
        if (s.depth == depth[cell]) cells[cell] = labels[v];
      }
  }
  Image out(view.width, view.height, 1);
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x)
      *out.at(x, y) = cells[static_cast<std::size_t>(y / view.cell) * static_cast<std::size_t>(view.columns) +
                            static_cast<std::size_t>(x / view.cell)];
  return out;
}

std::vector<std::size_t> LabelVolume::piece_of(std::size_t voxel,
                                               std::span<const std::uint8_t> labels) const {
  std::vector<std::size_t> piece{voxel};
  std::vector<bool> met(places_.size());
  met[voxel] = true;
  const std::vector<Step> all = steps();
  for (std::size_t i = 0; i < piece.size(); ++i)
    for (const Step& step : all) {
      const Vector3i to = places_[piece[i]] + step.by;
      if (!inside(to) || index_[at(to)] < 0) continue;
      const auto n = static_cast<std::size_t>(index_[at(to)]);
      if (met[n] || labels[n] != labels[voxel]) continue;
      met[n] = true;
      piece.push_back(n);
    }
  return piece;
}

std::size_t LabelVolume::seen_at(int camera, int x, int y, std::span<const std::uint8_t> labels) const {
  const View& view = views_[static_cast<std::size_t>(camera)];
  std::size_t best = size();
  for (std::size_t v = 0; v < places_.size(); ++v) {
    const Seen& s = view.seen[v];
    const int cx = x / view.cell, cy = y / view.cell;
    if (s.depth < 0 || cx < s.x0 || cx > s.x1 || cy < s.y0 || cy > s.y1) continue;
    if (!labels.empty() && labels[v] == 0) continue;
    if (best == size() || s.depth < view.seen[best].depth) best = v;
  }
  return best;
}

std::vector<double> LabelVolume::merged(std::span<const std::uint8_t> labels, int reach) const {
  std::vector<double> share(static_cast<std::size_t>(labels_) + 1, 0);
  std::vector<double> total(share.size(), 0);
  std::vector<std::vector<Vector3i>> of(share.size());
  for (std::size_t v = 0; v < places_.size(); ++v) of[labels[v]].push_back(places_[v]);
  std::vector<std::vector<float>> away(share.size());
  for (std::size_t l = 1; l < of.size(); ++l) away[l] = distance_to(of[l]);
  for (std::size_t v = 0; v < places_.size(); ++v) {
    if (labels[v] == 0) continue;
    ++total[labels[v]];
    bool near = false;
    for (std::size_t l = 1; l < of.size(); ++l)
      near |= l != labels[v] && away[l][v] <= static_cast<float>(reach);
    share[labels[v]] += near;
  }
  for (std::size_t l = 0; l < share.size(); ++l)
    if (total[l] > 0) share[l] /= total[l];
  return share;
}

}  // namespace floatstage::recon
