// Method:  cast shadows by what several cameras see of one place of the floor
// Paper:   the plane's homography as in S. M. Khan, M. Shah, "A multiview approach to tracking people in
// crowded scenes using a planar homography constraint", ECCV 2006, there of people's feet
// Differs: votes of ratios to the empty stage, each camera's own pixel by pixel
// ADR:     0349

#include "matting/floor_shadows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/check.h"
#include "core/parallel.h"
#include "matting/view_cut.h"

namespace floatstage::matting {
namespace {

constexpr float kOffset = 2;      // 8-bit steps: black is divided by that
constexpr float kDarker = 0.03F;  // log of a ratio: less is no shadow that matters
constexpr float kAlike = 0.1F;    // logs of two cameras' ratios: colours of the floor by direction, blur
constexpr float kUnsure = 0.3F;   // what noise does to a log from which nothing can be told
constexpr int kNoisyPixels = 3;   // deviations
constexpr int kFewestAgree = 2;   // other cameras that agree
constexpr double kFar = 2;        // of where cameras look: beyond stand walls, whose floor nobody sees

using Ratio = std::array<float, 3>;

// How much darker or brighter than the empty stage a camera's pixels are.
struct Look {
  int width = 0, height = 0;
  std::vector<Ratio> log_ratio;
  std::vector<float> noise;  // of a log
  bool there() const { return width > 0; }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

// Sums of 3x3 pixels, as far as they are in the picture, with their number.
std::array<float, 4> around(const Image& picture, int x, int y) {
  std::array<float, 4> sum{};
  for (int v = std::max(0, y - 1); v <= std::min(picture.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(picture.width - 1, x + 1); ++u) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<float>(picture.at(u, v)[c]);
      sum[3] += 1;
    }
  return sum;
}

Look look_at(const BeforeStage& camera) {
  Look look;
  if (camera.picture == nullptr || camera.picture->empty()) return look;
  const Image &picture = *camera.picture, &stage = *camera.stage;
  FLOATSTAGE_CHECK(picture.channels == 3 && stage.channels == 3 && picture.width == stage.width &&
                       picture.height == stage.height,
                   "a picture and its stage are RGB and of one size");
  look.width = picture.width;
  look.height = picture.height;
  // Of one channel, of a mean of nine pixels.
  const auto deviation = static_cast<float>(noise_of(picture) / 3 / 3);
  for (int y = 0; y < look.height; ++y)
    for (int x = 0; x < look.width; ++x) {
      const std::array<float, 4> now = around(picture, x, y), empty = around(stage, x, y);
      Ratio ratio{};
      float least = 255;
      for (std::size_t c = 0; c < 3; ++c) {
        const float a = now[c] / now[3] + kOffset, b = empty[c] / empty[3] + kOffset;
        ratio[c] = std::log(a / b);
        least = std::min({least, a, b});
      }
      look.log_ratio.push_back(ratio);
      look.noise.push_back(deviation / least);
    }
  return look;
}

bool darker(const Ratio& r) { return *std::max_element(r.begin(), r.end()) < -kDarker; }

// Whether a camera shows a place darker by `ratio`, too: the nearest of nine pixels counts, for shadows have
// edges and calibrations errors.
bool agrees(const Look& look, int x, int y, const Ratio& ratio, float noise) {
  for (int v = std::max(0, y - 1); v <= std::min(look.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(look.width - 1, x + 1); ++u) {
      const std::size_t p = look.at(u, v);
      if (look.noise[p] >= kUnsure) continue;
      float apart = 0;
      for (std::size_t c = 0; c < 3; ++c) apart = std::max(apart, std::abs(look.log_ratio[p][c] - ratio[c]));
      if (apart < kAlike + kNoisyPixels * (noise + look.noise[p])) return true;
    }
  return false;
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

Image shadows_of(const Rig& rig, const std::vector<Look>& looks, std::size_t camera) {
  const Look& own = looks[camera];
  Image mask(own.width, own.height, 1);
  const CameraModel& m = rig.cameras[camera].model;
  const double farthest = kFar * (focus_point(rig) - rig.cameras[camera].cam_from_world.center()).norm();
  for (int y = 0; y < own.height; ++y)
    for (int x = 0; x < own.width; ++x) {
      const std::size_t p = own.at(x, y);
      if (!darker(own.log_ratio[p]) || own.noise[p] >= kUnsure) continue;
      const std::optional<Eigen::Vector3d> place =
          on_floor(rig.cameras[camera], {(x + 0.5) / own.width * m.width, (y + 0.5) / own.height * m.height},
                   farthest);
      if (!place) continue;
      int seeing = 0, agreeing = 0;
      for (std::size_t other = 0; other < looks.size(); ++other) {
        const Look& look = looks[other];
        if (other == camera || !look.there()) continue;
        const RigCamera& c = rig.cameras[other];
        const std::optional<Eigen::Vector2d> at = project(c.model, c.cam_from_world * *place);
        if (!at || !inside(c.model, *at)) continue;
        ++seeing;
        agreeing +=
            agrees(look, static_cast<int>(at->x() / c.model.width * look.width),
                   static_cast<int>(at->y() / c.model.height * look.height), own.log_ratio[p], own.noise[p]);
      }
      if (agreeing >= kFewestAgree && 2 * agreeing > seeing) mask.pixels[p] = 255;
    }
  return mask;
}

}  // namespace

std::vector<Image> floor_shadows(const Rig& rig, std::span<const BeforeStage> cameras, int threads) {
  FLOATSTAGE_CHECK(cameras.size() == rig.cameras.size(), "a picture of each camera");
  std::vector<Look> looks(cameras.size());
  parallel_for(cameras.size(), threads, [&](std::size_t i) { looks[i] = look_at(cameras[i]); });
  std::vector<Image> masks(cameras.size());
  parallel_for(cameras.size(), threads, [&](std::size_t i) {
    if (looks[i].there()) masks[i] = shadows_of(rig, looks, i);
  });
  return masks;
}

}  // namespace floatstage::matting
