// Method:  cast shadows by what several cameras see of one place of the floor
// Paper:   the plane's homography as in S. M. Khan, M. Shah, "A multiview approach to tracking people in
// crowded scenes using a planar homography constraint", ECCV 2006, there of people's feet
// Differs: votes of ratios to the empty stage, each camera's own pixel by pixel
// ADR:     0349

#include "matting/floor_shadows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/check.h"
#include "core/parallel.h"
#include "matting/view_cut.h"

namespace floatstage::matting {
namespace {

constexpr int kOffset = 2;            // 8-bit steps: black is divided by that
constexpr float kAlike = 0.1F;        // logs of two cameras' shares: colours of the floor by direction, blur
constexpr float kUnsure = 0.3F;       // of a share, what noise does to it where nothing can be told
constexpr int kNoisyPixels = 3;       // deviations
constexpr int kFewestAgree = 2;       // other cameras
constexpr double kFar = 2;            // of where cameras look: beyond stand walls, whose floor nobody sees
constexpr std::size_t kAsked = 480;   // pixels in all, where the floor is sought
constexpr float kDeep = 0.8F;         // of the stage: what is lighter is alike on any floor
constexpr double kEnough = 0.35;      // of what is deep, at z = 0: the floor is there
constexpr double kBetterThere = 1.5;  // times what is at z = 0
constexpr double kFound = 0.18;       // of the same, on a floor elsewhere
constexpr double kTilt = 0.07;        // radians: steps of its tilt,
constexpr int kTilts = 3;             // to each side,
constexpr double kMostTilt = 0.3;
constexpr double kStep = 0.03;                       // and of its height, of how far cameras look,
constexpr double kDeepest = -0.9, kHighest = -0.05;  // from where they look
constexpr int kWide = 4;                             // px that steps as wide are blurred by

// The sums of 3x3 values of each channel around the pixels of row y; what lies outside is as its border.
void add_around(const Image& picture, int y, std::vector<int>& columns, std::vector<int>& sums) {
  const auto values = static_cast<std::size_t>(3 * picture.width);
  const std::uint8_t *above = picture.at(0, std::max(0, y - 1)), *here = picture.at(0, y),
                     *below = picture.at(0, std::min(picture.height - 1, y + 1));
  columns.resize(values + 6);
  sums.resize(values);
  for (std::size_t i = 0; i < values; ++i) columns[i + 3] = above[i] + here[i] + below[i];
  for (std::size_t c = 0; c < 3; ++c) {
    columns[c] = columns[3 + c];
    columns[values + 3 + c] = columns[values + c];
  }
  for (std::size_t i = 0; i < values; ++i) sums[i] = columns[i] + columns[i + 3] + columns[i + 6];
}

}  // namespace

void FloorShadows::look_at(const BeforeStage& camera, std::size_t number) {
  FloorShade& shade = shades_[number];
  shade.width = shade.height = 0;
  shade.mask.clear();
  if (camera.picture == nullptr || camera.picture->empty()) return;
  const Image &picture = *camera.picture, &stage = *camera.stage;
  FLOATSTAGE_CHECK(picture.channels == 3 && stage.channels == 3 && picture.width == stage.width &&
                       picture.height == stage.height,
                   "a picture and its stage are RGB and of one size");
  shade.width = picture.width;
  shade.height = picture.height;
  const std::size_t pixels = picture.pixels.size() / 3;
  shade.mask.resize(pixels);
  shade.left.resize(pixels);
  noise_[number].resize(pixels);
  // Of one channel, of a mean of nine pixels.
  const auto deviation = static_cast<float>(noise_of(picture) / 3 / 3);
  Rows& rows = rows_[number];
  std::size_t p = 0;
  for (int y = 0; y < shade.height; ++y) {
    add_around(picture, y, rows.columns, rows.now);
    add_around(stage, y, rows.columns, rows.empty);
    for (std::size_t i = 0; i < rows.now.size(); i += 3, ++p) {
      int least = std::numeric_limits<int>::max();
      for (std::size_t c = 0; c < 3; ++c) {
        const int now = rows.now[i + c] + 9 * kOffset, empty = rows.empty[i + c] + 9 * kOffset;
        shade.left[p][c] = static_cast<float>(now) / static_cast<float>(empty);
        least = std::min({least, now, empty});
      }
      noise_[number][p] = 9 * deviation / static_cast<float>(least);
    }
  }
}

void FloorShadows::list_dark(std::size_t camera) {
  const FloorShade& shade = shades_[camera];
  const RigCamera& own = rig_.cameras[camera];
  const Eigen::Vector3d from = own.cam_from_world.center();
  const double farthest = kFar * (focus_point(rig_) - from).norm();
  std::vector<Dark>& dark = dark_[camera];
  dark.clear();
  std::size_t p = 0;
  for (int y = 0; y < shade.height; ++y)
    for (int x = 0; x < shade.width; ++x, ++p) {
      const Share& left = shade.left[p];
      if (*std::max_element(left.begin(), left.end()) >= lightest_ || noise_[camera][p] >= kUnsure) continue;
      const std::optional<Eigen::Vector3d> ray =
          unproject(own.model,
                    {(x + 0.5) / shade.width * own.model.width, (y + 0.5) / shade.height * own.model.height});
      if (!ray) continue;
      dark.push_back(
          {camera, p, from, own.cam_from_world.rotation.conjugate() * *ray, farthest / ray->norm()});
    }
}

// The nearest of nine pixels counts, or of more, for shadows have edges and calibrations errors.
bool FloorShadows::agrees(std::size_t camera, int x, int y, int reach, const Share& left, float noise) const {
  const FloorShade& shade = shades_[camera];
  for (int v = std::max(0, y - reach); v <= std::min(shade.height - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(shade.width - 1, x + reach); ++u) {
      const std::size_t p =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(shade.width) + static_cast<std::size_t>(u);
      const float own = noise_[camera][p];
      if (own >= kUnsure) continue;
      float apart = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        const float ratio = shade.left[p][c] / left[c];
        apart = std::max({apart, ratio, 1 / ratio});
      }
      if (apart < std::exp(kAlike + kNoisyPixels * (noise + own))) return true;
    }
  return false;
}

bool FloorShadows::is_shadow(const Dark& dark, const Floor& floor, int reach) const {
  const double far = (floor.height - floor.up.dot(dark.from)) / floor.up.dot(dark.along);
  if (!(far > 0 && far < dark.farthest)) return false;
  const Eigen::Vector3d place = dark.from + far * dark.along;
  int seeing = 0, agreeing = 0;
  for (std::size_t i = 0; i < shades_.size(); ++i) {
    const FloorShade& other = shades_[i];
    if (i == dark.camera || other.width == 0) continue;
    const RigCamera& c = rig_.cameras[i];
    const std::optional<Eigen::Vector2d> at = project(c.model, c.cam_from_world * place);
    if (!at || !inside(c.model, *at)) continue;
    ++seeing;
    agreeing += agrees(i, static_cast<int>(at->x() / c.model.width * other.width),
                       static_cast<int>(at->y() / c.model.height * other.height), reach,
                       shades_[dark.camera].left[dark.pixel], noise_[dark.camera][dark.pixel]);
  }
  return agreeing >= kFewestAgree && 2 * agreeing > seeing;
}

void FloorShadows::darken(std::size_t camera) {
  FloorShade& shade = shades_[camera];
  std::fill(shade.mask.begin(), shade.mask.end(), std::uint8_t{0});
  shade.shadows = 0;
  for (const Dark& dark : dark_[camera]) {
    if (!is_shadow(dark, floor_, 1)) continue;
    shade.mask[dark.pixel] = 255;
    ++shade.shadows;
  }
}

double FloorShadows::share_on(const Floor& floor, int reach, int threads) {
  yes_.assign(asked_.size(), 0);
  parallel_for(asked_.size(), threads, [&](std::size_t i) { yes_[i] = is_shadow(asked_[i], floor, reach); });
  return static_cast<double>(std::count(yes_.begin(), yes_.end(), 1)) / static_cast<double>(asked_.size());
}

// Over all tilts and heights in steps that wide windows bridge, then around the best in finer ones.
void FloorShadows::seek(int threads) {
  asked_.clear();
  for (const std::vector<Dark>& dark : dark_)
    for (const Dark& d : dark) {
      const Share& left = shades_[d.camera].left[d.pixel];
      if (*std::max_element(left.begin(), left.end()) < kDeep) asked_.push_back(d);
    }
  if (asked_.size() < kAsked) return;
  for (std::size_t k = 0; k < kAsked; ++k) asked_[k] = asked_[k * asked_.size() / kAsked];
  asked_.resize(kAsked);
  const double usual = share_on(floor_, 1, threads);
  if (usual >= kEnough) return;
  const Eigen::Vector3d focus = focus_point(rig_);
  double distance = 0;
  for (const RigCamera& c : rig_.cameras) distance += (focus - c.cam_from_world.center()).norm();
  distance /= static_cast<double>(rig_.cameras.size());
  double most = 0;
  Floor best;
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(Eigen::Vector3d::UnitZ()), mean_up(rig_)}) {
    const Eigen::Vector3d across = up.unitOrthogonal(), along = up.cross(across);
    const auto floor_at = [&](const Eigen::Vector3d& v) {  // tilts, height
      const Eigen::Vector3d n = (up + v.x() * across + v.y() * along).normalized();
      return Floor{n, n.dot(focus) + v.z() * distance};
    };
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    double here = -1;
    const auto take_better = [&](const Eigen::Vector3d& v, int reach) {
      if (v.head<2>().norm() > kMostTilt || v.z() > kHighest) return;
      const double share = share_on(floor_at(v), reach, threads);
      if (share > here) here = share, at = v;
    };
    for (int a = -kTilts; a <= kTilts; ++a)
      for (int b = -kTilts; b <= kTilts; ++b)
        for (double h = kDeepest; h <= kHighest; h += kStep) take_better({a * kTilt, b * kTilt, h}, kWide);
    for (int reach = kWide / 2, finer = 2; finer <= 16; finer *= 2, reach = 1) {
      here = -1;
      for (double had = -2; here > had;) {
        had = here;
        const Eigen::Vector3d middle = at;
        for (int k = 0; k < 27; ++k) {
          const Eigen::Vector3d step((k % 3 - 1) * kTilt, (k / 3 % 3 - 1) * kTilt, (k / 9 - 1) * kStep);
          take_better(middle + step / finer, reach);
        }
      }
    }
    if (here > most) most = here, best = floor_at(at);
  }
  found_ = most >= kFound && most >= kBetterThere * usual;
  if (found_) floor_ = best;
}

const std::vector<FloorShade>& FloorShadows::find(std::span<const BeforeStage> cameras, int threads) {
  FLOATSTAGE_CHECK(cameras.size() == rig_.cameras.size(), "a picture of each camera");
  shades_.resize(cameras.size());
  noise_.resize(cameras.size());
  rows_.resize(cameras.size());
  dark_.resize(cameras.size());
  parallel_for(cameras.size(), threads, [&](std::size_t i) {
    look_at(cameras[i], i);
    list_dark(i);
  });
  if (std::exchange(seeks_, false)) seek(threads);
  parallel_for(cameras.size(), threads, [&](std::size_t i) { darken(i); });
  return shades_;
}

}  // namespace floatstage::matting
