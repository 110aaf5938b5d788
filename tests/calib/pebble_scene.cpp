#include "tests/calib/pebble_scene.h"

#include <cmath>
#include <numbers>
#include <random>

#include "core/parallel.h"
#include "core/png.h"
#include "core/synthetic/noise.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 280, kHeight = 210;
constexpr double kRadius = 2;              // metres, of the rig
constexpr int kPebbles = 24, kAcross = 2;  // rays a pixel: across squared

struct Pebble {
  Vector3d middle;
  double radius;
};

class Heap {
 public:
  explicit Heap(std::uint64_t seed) : seed_(static_cast<std::uint32_t>(seed)) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> at(-0.35, 0.35), size(0.1, 0.22);
    for (int i = 0; i < kPebbles; ++i)
      pebbles_.push_back({{at(random), at(random), at(random)}, size(random)});
  }

  // Grey of what a ray meets first; dark where it meets nothing.
  float grey(const Vector3d& from, const Vector3d& way) const {
    double nearest = 1e9;
    for (const Pebble& p : pebbles_) {
      const Vector3d to = p.middle - from;
      const double along = to.dot(way), miss = to.squaredNorm() - along * along;
      if (const double inside = p.radius * p.radius - miss; inside > 0)
        nearest = std::min(nearest, along - std::sqrt(inside));
    }
    if (nearest > 1e8) return 15;
    const Eigen::Vector3f x = (from + nearest * way).cast<float>();
    float sum = 0, weight = 0;
    for (const float cells : {7.f, 16.f, 36.f, 68.f}) {  // a metre
      sum += synthetic::value_noise(cells * x, seed_ + static_cast<std::uint32_t>(cells)) * 0.8f;
      weight += 0.8f;
    }
    const float v = 0.5f + 2.2f * (sum / weight - 0.5f);
    return 30 + 200 * std::min(std::max(v, 0.f), 1.f);
  }

 private:
  std::uint32_t seed_;
  std::vector<Pebble> pebbles_;
};

Image photograph(const Heap& heap, const RigCamera& camera, std::uint64_t seed) {
  Image out(kWidth, kHeight, 1);
  const Rigid3 world_from_cam = camera.cam_from_world.inverse();
  std::mt19937_64 random(seed);
  std::normal_distribution<float> noise(0, 2);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      float sum = 0;
      for (int s = 0; s < kAcross * kAcross; ++s) {
        const Eigen::Vector2d pixel(x + (s % kAcross + 0.5) / kAcross, y + (s / kAcross + 0.5) / kAcross);
        const auto ray = unproject(camera.model, pixel);
        sum += ray ? heap.grey(world_from_cam.translation, (world_from_cam.rotation * *ray).normalized()) : 0;
      }
      const float v = sum / (kAcross * kAcross) + noise(random);
      *out.at(x, y) = static_cast<std::uint8_t>(std::min(std::max(std::lround(v), 0L), 255L));
    }
  return out;
}

std::vector<std::pair<double, double>> places(PebbleRig shape) {
  std::vector<std::pair<double, double>> out;  // azimuth and elevation, degrees
  const auto row = [&](int cameras, double elevation, double from) {
    for (int i = 0; i < cameras; ++i) out.emplace_back(from + 360.0 * i / cameras, elevation);
  };
  if (shape == PebbleRig::Ring) {
    row(20, 15, 0);
  } else {
    // A dome over the front half: rows of neighbours 18° apart.
    for (int i = 0; i < 10; ++i) out.emplace_back(18.0 * i, 5);
    for (int i = 0; i < 8; ++i) out.emplace_back(10 + 20.0 * i, 25);
    for (int i = 0; i < 6; ++i) out.emplace_back(25 + 26.0 * i, 45);
  }
  return out;
}

}  // namespace

PebbleScene pebble_scene(PebbleRig shape, std::uint64_t seed, const std::filesystem::path& folder) {
  std::mt19937_64 random(seed * 7919 + static_cast<std::uint64_t>(shape));
  std::uniform_real_distribution<double> unit(-1, 1);
  CameraModel lens{.width = kWidth, .height = kHeight, .fx = 0, .fy = 0, .cx = 0, .cy = 0, .lens = {}};
  lens.fx = lens.fy = kWidth * (1.6 + 0.4 * unit(random));
  lens.cx = kWidth / 2.0 + 5 * unit(random);
  lens.cy = kHeight / 2.0 + 5 * unit(random);
  lens.lens = BrownConrady{.k1 = -0.1 + 0.1 * unit(random), .k2 = 0.05 * unit(random)};
  const double radius = kRadius * lens.fx / (1.6 * kWidth);  // the heap fills the picture whatever the lens
  const Heap heap(seed);
  PebbleScene scene;
  for (const auto& [azimuth, elevation] : places(shape)) {
    const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
    const Vector3d shake(unit(random), unit(random), unit(random)),
        aim(unit(random), unit(random), unit(random));
    const Vector3d eye =
        radius * (Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)) + 0.02 * shake);
    const auto number = scene.truth.cameras.size();
    scene.truth.cameras.push_back({.serial = text("c", number < 10 ? "0" : "", number),
                                   .model = lens,
                                   .cam_from_world = look_at(eye, 0.05 * aim, Vector3d::UnitZ()),
                                   .color = {}});
  }
  scene.pictures.resize(scene.truth.cameras.size());
  parallel_for(scene.pictures.size(), 0, [&](std::size_t i) {
    const RigCamera& camera = scene.truth.cameras[i];
    MarkerlessPicture& p = scene.pictures[i];
    p = {camera.serial,  folder / (camera.serial + ".png"),
         camera.model,   photograph(heap, camera, seed * 1000 + i),
         Prior::Unknown, {}};
    if (i > 0) p.same_lens_as = 0;
    // What is not known must not be looked at.
    p.model.fx = p.model.fy = kWidth;
    p.model.cx = kWidth / 2.0;
    p.model.cy = kHeight / 2.0;
    p.model.lens = BrownConrady{};
    if (!save_png(p.pixels, p.file)) p.file.clear();
  });
  return scene;
}

}  // namespace floatstage::calib
