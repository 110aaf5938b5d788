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

#include "core/check.h"
#include "core/parallel.h"
#include "matting/view_cut.h"

namespace floatstage::matting {
namespace {

constexpr int kOffset = 2;       // 8-bit steps: black is divided by that
constexpr float kAlike = 0.1F;   // logs of two cameras' shares: colours of the floor by direction, blur
constexpr float kUnsure = 0.3F;  // of a share, what noise does to it where nothing can be told
constexpr int kNoisyPixels = 3;  // deviations
constexpr int kFewestAgree = 2;  // other cameras
constexpr double kFar = 2;       // of where cameras look: beyond stand walls, whose floor nobody sees

using Share = std::array<float, 3>;

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

// Where the ray through a pixel meets the floor, no further off than `farthest`.
std::optional<Eigen::Vector3d> on_floor(const RigCamera& camera, const Eigen::Vector2d& pixel,
                                        double farthest) {
  const std::optional<Eigen::Vector3d> ray = unproject(camera.model, pixel);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d from = camera.cam_from_world.center(),
                        along = camera.cam_from_world.rotation.conjugate() * *ray;
  const double far = -from.z() / along.z();
  if (!(far > 0 && far * along.norm() < farthest)) return std::nullopt;
  return from + far * along;
}

}  // namespace

void FloorShadows::look_at(const BeforeStage& camera, std::size_t number) {
  FloorShade& shade = shades_[number];
  shade.width = shade.height = 0;
  shade.shadows = 0;
  if (camera.picture == nullptr || camera.picture->empty()) return;
  const Image &picture = *camera.picture, &stage = *camera.stage;
  FLOATSTAGE_CHECK(picture.channels == 3 && stage.channels == 3 && picture.width == stage.width &&
                       picture.height == stage.height,
                   "a picture and its stage are RGB and of one size");
  shade.width = picture.width;
  shade.height = picture.height;
  const std::size_t pixels = picture.pixels.size() / 3;
  shade.mask.assign(pixels, 0);
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

// The nearest of nine pixels counts, for shadows have edges and calibrations errors.
bool FloorShadows::agrees(std::size_t camera, int x, int y, const Share& left, float noise) const {
  const FloorShade& shade = shades_[camera];
  for (int v = std::max(0, y - 1); v <= std::min(shade.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(shade.width - 1, x + 1); ++u) {
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

void FloorShadows::search(std::size_t camera) {
  FloorShade& shade = shades_[camera];
  const RigCamera& own = rig_.cameras[camera];
  const double farthest = kFar * (focus_point(rig_) - own.cam_from_world.center()).norm();
  std::size_t p = 0;
  for (int y = 0; y < shade.height; ++y)
    for (int x = 0; x < shade.width; ++x, ++p) {
      const Share& left = shade.left[p];
      if (*std::max_element(left.begin(), left.end()) >= lightest_ || noise_[camera][p] >= kUnsure) continue;
      const std::optional<Eigen::Vector3d> place = on_floor(
          own, {(x + 0.5) / shade.width * own.model.width, (y + 0.5) / shade.height * own.model.height},
          farthest);
      if (!place) continue;
      int seeing = 0, agreeing = 0;
      for (std::size_t i = 0; i < shades_.size(); ++i) {
        const FloorShade& other = shades_[i];
        if (i == camera || other.width == 0) continue;
        const RigCamera& c = rig_.cameras[i];
        const std::optional<Eigen::Vector2d> at = project(c.model, c.cam_from_world * *place);
        if (!at || !inside(c.model, *at)) continue;
        ++seeing;
        agreeing +=
            agrees(i, static_cast<int>(at->x() / c.model.width * other.width),
                   static_cast<int>(at->y() / c.model.height * other.height), left, noise_[camera][p]);
      }
      if (agreeing < kFewestAgree || 2 * agreeing <= seeing) continue;
      shade.mask[p] = 255;
      ++shade.shadows;
    }
}

const std::vector<FloorShade>& FloorShadows::find(std::span<const BeforeStage> cameras, int threads) {
  FLOATSTAGE_CHECK(cameras.size() == rig_.cameras.size(), "a picture of each camera");
  shades_.resize(cameras.size());
  noise_.resize(cameras.size());
  rows_.resize(cameras.size());
  parallel_for(cameras.size(), threads, [&](std::size_t i) { look_at(cameras[i], i); });
  parallel_for(cameras.size(), threads, [&](std::size_t i) {
    if (shades_[i].width > 0) search(i);
  });
  return shades_;
}

}  // namespace floatstage::matting
