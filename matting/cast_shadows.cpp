// Method:  cast shadows by what several cameras see of one place of the floor
// Paper:   the plane's homography as in S. M. Khan, M. Shah, "A multiview approach to tracking people in
// crowded scenes using a planar homography constraint", ECCV 2006, there of people's feet
// Differs: votes of ratios to the empty stage, each camera's own pixel by pixel
// ADR:     0349, 0354

#include "matting/cast_shadows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/parallel.h"
#include "matting/view_cut.h"

namespace floatstage::matting {
namespace {

constexpr int kOffset = 2;       // 8-bit steps: black is divided by that
constexpr float kAlike = 0.1F;   // logs of two cameras' shares: colours of the floor by direction, blur
constexpr int kNoisyPixels = 3;  // deviations
constexpr int kFewestAgree = 2;  // other cameras

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

void CastShadows::look_at(const BeforeStage& camera, std::size_t number) {
  CastShade& shade = shades_[number];
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

void CastShadows::list_dark(std::size_t camera) {
  const CastShade& shade = shades_[camera];
  const RigCamera& own = rig_.cameras[camera];
  const Eigen::Vector3d from = own.cam_from_world.center();
  const double looks_at = (focus_point(rig_) - from).norm();
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
          {camera, p, from, own.cam_from_world.rotation.conjugate() * *ray, looks_at / ray->norm()});
    }
}

// The nearest of nine pixels counts, or of more, for shadows have edges and calibrations errors.
bool CastShadows::agrees(std::size_t camera, int x, int y, int reach, const Share& left, float noise) const {
  const CastShade& shade = shades_[camera];
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

bool CastShadows::is_shadow(const Dark& dark, const ShadedPlane& plane, int reach) const {
  const double far = (plane.offset - plane.normal.dot(dark.from)) / plane.normal.dot(dark.along);
  if (!(far > 0 && far < plane.farthest * dark.looks_at)) return false;
  const Eigen::Vector3d place = dark.from + far * dark.along;
  int seeing = 0, agreeing = 0;
  for (std::size_t i = 0; i < shades_.size(); ++i) {
    const CastShade& other = shades_[i];
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

bool CastShadows::is_shadow(const Dark& dark) const {
  return is_shadow(dark, floor_, 1) ||
         std::any_of(walls_.begin(), walls_.end(),
                     [&](const ShadedPlane& wall) { return is_shadow(dark, wall, 1); });
}

void CastShadows::darken(std::size_t camera) {
  CastShade& shade = shades_[camera];
  std::fill(shade.mask.begin(), shade.mask.end(), std::uint8_t{0});
  shade.shadows = 0;
  for (const Dark& dark : dark_[camera]) {
    if (!is_shadow(dark)) continue;
    shade.mask[dark.pixel] = 255;
    ++shade.shadows;
  }
}

const std::vector<CastShade>& CastShadows::find(std::span<const BeforeStage> cameras, int threads) {
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
