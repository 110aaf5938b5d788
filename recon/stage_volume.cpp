// Method:  an octree of the space around where the cameras look, over silhouettes in blocks of pixels
// Paper:   R. Szeliski, "Rapid octree construction from image sequences", 1993
// Differs: outside a picture is unknown and never carves; a cube stays when enough cameras can see it and
// none
//          denies it; the space grows until the rest is inside
// ADR:     0175

#include "recon/stage_volume.h"

#include <algorithm>
#include <cmath>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr double kCubesAcross = 24;  // of the volume's longest side
constexpr int kCore = -1, kNoPart = -2;
constexpr int kPlaceBits = 21;
constexpr double kMostGrowth = 100;   // times the cameras' distance: what reaches further is unbounded
const double kBall = std::sqrt(3.0);  // around a cube of half side 1
const Vector3d kOctants[] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                             {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};

}  // namespace

/// In whatever order cameras are asked, the answer is one. Who denied the last cube often denies the next.
bool StageFinder::keeps(const Vector3d& center, double radius, bool small, int cameras) {
  int seen = 0, denied = 0, left = static_cast<int>(asked_.size());
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (seen + left < cameras) return false;
    --left;
    const BlockPictures::Answer answer = pictures_.ask(asked_[i], center, radius, small);
    if (answer == BlockPictures::Answer::Background && ++denied > outvoted_) {
      if (i > 0) std::swap(asked_[i], asked_[i / 2]);
      return false;
    }
    seen += answer == BlockPictures::Answer::Subject;
  }
  return seen >= cameras;
}

Eigen::AlignedBox3d StageFinder::box_of_cubes() const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& cube : cubes_) box.extend(cube);
  if (!box.isEmpty()) box = {box.min() - Vector3d::Constant(half_), box.max() + Vector3d::Constant(half_)};
  return box;
}

/// Whether what is left lies inside what was searched.
bool StageFinder::is_bounded(double reach) const {
  const Eigen::AlignedBox3d box = box_of_cubes();
  const double most = reach - half_ / 2;
  return !cubes_.empty() && ((box.min() - focus_).array() > -most).all() &&
         ((box.max() - focus_).array() < most).all();
}

/// Carves cubes around where the cameras look, twice as large ones until what is left lies inside. False
/// when it never does.
bool StageFinder::carve(int cameras) {
  for (double reach = reach_; reach < kMostGrowth * reach_; reach *= 2) {
    cubes_.assign(1, focus_);
    half_ = reach;
    refine(cameras, reach, 0);
    if (!is_bounded(reach)) continue;
    reach_ = reach;
    return true;
  }
  return cubes_.empty();
}

/// Puts those of the eight parts of each cube in its place that are kept; `half` is theirs.
template <class Keep>
void StageFinder::halve(std::vector<Vector3d>& cubes, double half, const Keep& keep) {
  next_.clear();
  for (const Vector3d& cube : cubes)
    for (const Vector3d& octant : kOctants)
      if (const Vector3d center = cube + half * octant; keep(center)) next_.push_back(center);
  cubes.swap(next_);
}

/// Halves the cubes and carves. `finest`: the half of a cube to go down to; 0: as the volume asks for.
void StageFinder::refine(int cameras, double reach, double finest) {
  const auto fine_enough = [&] {
    return finest > 0 ? half_ <= finest : 2 * half_ * kCubesAcross <= box_of_cubes().sizes().maxCoeff();
  };
  while (!cubes_.empty() && cubes_.size() <= kMostCubes && !fine_enough()) {
    half_ /= 2;
    const bool small = half_ * kSmall <= reach;
    halve(cubes_, half_, [&](const Vector3d& c) { return keeps(c, kBall * half_, small, cameras); });
  }
}

void StageFinder::count_unexplained() {
  missing_ = 0;
  unexplained_.resize(pictures_.size());
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    const BlockPicture& picture = pictures_[c];
    unexplained_[c].clear();
    if (!picture.known) continue;
    // Corners of rectangles, summed up along rows and columns: how many cubes cover a block.
    const int stride = picture.columns + 1;
    covered_.assign(static_cast<std::size_t>(stride) * (picture.rows + 1), 0);
    const auto at = [&](int x, int y) -> int& { return covered_[static_cast<std::size_t>(y) * stride + x]; };
    for (const Vector3d& cube : cubes_) {
      int x0, y0, x1, y1;
      if (!pictures_.blocks_of(c, cube, kBall * half_, x0, y0, x1, y1)) continue;
      ++at(x0, y0);
      --at(x1 + 1, y0);
      --at(x0, y1 + 1);
      ++at(x1 + 1, y1 + 1);
    }
    unexplained_[c].assign(picture.subject.size(), 0);
    for (int y = 0; y < picture.rows; ++y) {
      int row = 0;
      for (int x = 0; x < picture.columns; ++x) {
        row += at(x, y);
        at(x, y) = row + (y > 0 ? at(x, y - 1) : 0);
        const bool lacks = picture.subject[picture.index(x, y)] != 0 && at(x, y) == 0;
        unexplained_[c][picture.index(x, y)] = lacks;
        missing_ += lacks;
      }
    }
  }
}

/// A cube's place among all of its size: 21 bits an axis, so that a step along an axis is one addition.
std::int64_t StageFinder::place(const Vector3d& point) const {
  constexpr std::int64_t kMiddle = std::int64_t{1} << (kPlaceBits - 1);
  std::int64_t key = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const auto step = static_cast<std::int64_t>(std::floor((point[axis] - focus_[axis]) / (2 * half_)));
    key = (key << kPlaceBits) + step + kMiddle;
  }
  return key;
}

void StageFinder::sort_places(const std::vector<Vector3d>& cubes) {
  places_.clear();
  for (std::size_t i = 0; i < cubes.size(); ++i) places_.emplace_back(place(cubes[i]), static_cast<int>(i));
  std::sort(places_.begin(), places_.end());
}

bool StageFinder::holds(const Vector3d& point) const {
  const std::int64_t key = place(point);
  const auto at = std::lower_bound(places_.begin(), places_.end(), std::pair{key, 0});
  return at != places_.end() && at->first == key;
}

/// Shares the cubes out to parts that hang together side by side, without those of `core`; part_of_[i] is
/// kCore for the latter.
int StageFinder::find_parts(const std::vector<Vector3d>& core) {
  sort_places(cubes_);
  part_of_.assign(cubes_.size(), kNoPart);
  const auto index_of = [&](std::int64_t key) {
    const auto at = std::lower_bound(places_.begin(), places_.end(), std::pair{key, 0});
    return at != places_.end() && at->first == key ? at->second : -1;
  };
  for (const Vector3d& cube : core)
    if (const int i = index_of(place(cube)); i >= 0) part_of_[static_cast<std::size_t>(i)] = kCore;
  int parts = 0;
  for (std::size_t seed = 0; seed < cubes_.size(); ++seed) {
    if (part_of_[seed] != kNoPart) continue;
    queue_.assign(1, static_cast<int>(seed));
    part_of_[seed] = parts;
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const std::int64_t key = place(cubes_[static_cast<std::size_t>(queue_[next])]);
      for (int step = 0; step < 6; ++step) {
        const std::int64_t stride = std::int64_t{1} << (step / 2 * kPlaceBits);
        const int i = index_of(step % 2 ? key + stride : key - stride);
        if (i < 0 || part_of_[static_cast<std::size_t>(i)] != kNoPart) continue;
        part_of_[static_cast<std::size_t>(i)] = parts;
        queue_.push_back(i);
      }
    }
    ++parts;
  }
  return parts;
}

/// Adds the blocks that a cube's centre falls on.
void StageFinder::weigh(std::size_t cube, Part& part) const {
  part.ends = part.ends && ((cubes_[cube] - focus_).array().abs() < reach_ - 1.5 * half_).all();
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    int x0, y0, x1, y1;
    if (!pictures_[c].known || !pictures_.blocks_of(c, cubes_[cube], 0, x0, y0, x1, y1)) continue;
    const std::size_t at = pictures_[c].index(x0, y0);
    part.shown += pictures_[c].subject[at] != 0;
    if (unexplained_[c][at] == 0) continue;
    ++part.lacking;
    const int camera = static_cast<int>(c);
    part.of_several = part.of_several || (part.lacking > 1 && camera != part.camera);
    part.camera = camera;
  }
}

/// Takes the parts that explain more than what the core explains already, those that explain most first.
/// Where few cameras look, each point of one silhouette has some of another behind it: a body is believed for
/// what nothing else explains. False when there are none.
bool StageFinder::take_parts(const std::vector<Vector3d>& core) {
  parts_.resize(static_cast<std::size_t>(find_parts(core)));
  for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p] = {.number = static_cast<int>(p)};
  for (std::size_t i = 0; i < cubes_.size(); ++i)
    if (part_of_[i] >= 0) weigh(i, parts_[static_cast<std::size_t>(part_of_[i])]);
  std::erase_if(parts_, [](const Part& part) { return !part.believed(); });
  std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
    return std::pair(-a.lacking, a.number) < std::pair(-b.lacking, b.number);
  });
  bool any = false;
  next_.assign(core.begin(), core.end());
  for (const Part& candidate : parts_) {
    Part part{.number = candidate.number};  // what is left for it to explain
    for (std::size_t i = 0; i < cubes_.size(); ++i)
      if (part_of_[i] == part.number) weigh(i, part);
    if (!part.believed()) continue;
    any = true;
    for (std::size_t i = 0; i < cubes_.size(); ++i) {
      if (part_of_[i] != part.number) continue;
      next_.push_back(cubes_[i]);
      explain(cubes_[i]);
    }
  }
  if (any) cubes_.swap(next_);
  return any;
}

void StageFinder::explain(const Vector3d& cube) {
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    int x0, y0, x1, y1;
    if (!pictures_[c].known || !pictures_.blocks_of(c, cube, kBall * half_, x0, y0, x1, y1)) continue;
    for (int y = y0; y <= y1; ++y)
      std::fill_n(unexplained_[c].begin() + static_cast<std::ptrdiff_t>(pictures_[c].index(x0, y)),
                  x1 - x0 + 1, std::uint8_t{0});
  }
}

/// Whether any camera may see a block that nothing explains in a ball.
bool StageFinder::may_see_missing(const Vector3d& center, double radius) const {
  for (std::size_t c = 0; c < unexplained_sums_.size(); ++c) {
    if (unexplained_sums_[c].empty()) continue;
    int x0, y0, x1, y1;
    if (pictures_.blocks_of(c, center, radius, x0, y0, x1, y1)
            ? pictures_[c].count(unexplained_sums_[c], x0, y0, x1, y1) > 0
            : pictures_.extent(c, center, radius).near)
      return true;
  }
  return false;
}

/// Whether a cube falls, for the most part, on subject that nothing explains.
bool StageFinder::lacks_most(const Vector3d& cube) const {
  int shown = 0, lacking = 0;
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    int x0, y0, x1, y1;
    if (!pictures_[c].known || !pictures_.blocks_of(c, cube, 0, x0, y0, x1, y1)) continue;
    shown += pictures_[c].subject[pictures_[c].index(x0, y0)] != 0;
    lacking += unexplained_[c][pictures_[c].index(x0, y0)];
  }
  return 2 * lacking > shown;
}

/// Whether grow() can find anything, which is seldom: most of what stays unexplained are a few blocks at
/// outlines. A part that is believed lacks in several cameras and has a cube that lacks_most(); those around
/// that cube may all see something missing, and are searched alone. False is certain.
bool StageFinder::may_grow(int cameras, double finest) {
  unexplained_sums_.resize(pictures_.size());
  int lacking = 0;
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    const std::vector<std::uint8_t>& blocks = unexplained_[c];
    unexplained_sums_[c].clear();
    if (std::find(blocks.begin(), blocks.end(), 1) == blocks.end()) continue;
    pictures_[c].sum_up(blocks, unexplained_sums_[c]);
    ++lacking;
  }
  if (lacking < 2) return false;
  core_.assign(1, focus_);
  double half = reach_;
  while (half > finest) {
    half /= 2;
    const bool small = half * kSmall <= reach_;
    halve(core_, half, [&](const Vector3d& c) {
      return may_see_missing(c, kBall * half) && keeps(c, kBall * half, small, cameras);
    });
    if (core_.size() > kMostCubes) return true;  // too many to tell: grow() bounds its own search
  }
  return std::any_of(core_.begin(), core_.end(), [&](const Vector3d& cube) { return lacks_most(cube); });
}

/// Adds bodies that stand outside pictures whose own subject touches no border, and parts that `cameras` see.
bool StageFinder::grow(int cameras) {
  for (std::size_t c = 0; c < pictures_.size(); ++c) pictures_.set_whole(c, false);
  if (!cubes_.empty() && !may_grow(cameras, half_)) return false;
  core_.swap(cubes_);
  const double half = half_;
  cubes_.assign(1, focus_);
  half_ = reach_;
  refine(cameras, reach_, core_.empty() ? 0 : half);
  const bool comparable = core_.empty() || half_ == half;
  if (comparable && take_parts(core_)) {
    if (core_.empty()) refine(cameras, reach_, 0);
    count_unexplained();
    return true;
  }
  cubes_.swap(core_);
  half_ = half;
  return false;
}

/// After growing: who does not see a part, and who may be believed to show the whole subject after all.
void StageFinder::find_partial(StageVolume& out) {
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    if (!pictures_[c].known) continue;
    out.partial[c] = std::any_of(cubes_.begin(), cubes_.end(), [&](const Vector3d& cube) {
      return pictures_.ask(c, cube, half_, true) == BlockPictures::Answer::NotSeen;
    });
  }
}

void StageFinder::grow_while_unexplained(StageVolume& out) {
  bool grown = grow(out.cameras);
  while (missing_ > 0 && out.cameras > 2) {
    const int fewer = std::max(2, out.cameras / 2);
    if (!grow(fewer)) break;
    grown = true;
    out.cameras = fewer;
  }
  if (grown) find_partial(out);
  for (std::size_t c = 0; c < pictures_.size(); ++c) pictures_.set_whole(c, out.partial[c] == 0);
}

bool StageFinder::find(const Rig& rig, const HullInput& input, StageVolume& out, int outvoted) {
  outvoted_ = outvoted;
  pictures_.fill(rig, input);
  focus_ = focus_point(rig);
  reach_ = 1e-3;
  for (const RigCamera& camera : rig.cameras)
    reach_ = std::max(reach_, (camera.cam_from_world.center() - focus_).norm());
  asked_.clear();
  for (std::size_t c = 0; c < pictures_.size(); ++c)
    if (pictures_[c].known) asked_.push_back(c);
  out.cameras = cameras_of(pictures_.known());
  if (!carve(out.cameras)) return false;
  out.partial.assign(pictures_.size(), 0);
  count_unexplained();
  if (missing_ > 0) grow_while_unexplained(out);
  sort_places(cubes_);
  out.box = box_of_cubes();
  out.unexplained.assign(pictures_.size(), 0);
  for (std::size_t c = 0; c < pictures_.size(); ++c) {
    const auto blocks = [](const std::vector<std::uint8_t>& of) {
      return static_cast<double>(std::count(of.begin(), of.end(), 1));
    };
    if (pictures_[c].known)
      out.unexplained[c] = blocks(unexplained_[c]) / std::max(1.0, blocks(pictures_[c].subject));
  }
  return true;
}

}  // namespace floatstage::recon
