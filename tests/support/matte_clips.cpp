#include "tests/support/matte_clips.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/random.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kAcross = 4;  // samples a pixel, squared

std::uint8_t byte(double v) { return static_cast<std::uint8_t>(std::clamp(std::lround(v), 0L, 255L)); }

// Opacity and premultiplied colour between the pixels; nothing outside.
std::array<double, 4> sample(const Cutout& cutout, double x, double y) {
  std::array<double, 4> sum{};
  const int x0 = static_cast<int>(std::floor(x - 0.5)), y0 = static_cast<int>(std::floor(y - 0.5));
  const double fx = x - 0.5 - x0, fy = y - 0.5 - y0;
  for (int k = 0; k < 4; ++k) {
    const int u = x0 + k % 2, v = y0 + k / 2;
    if (u < 0 || v < 0 || u >= cutout.alpha.width || v >= cutout.alpha.height) continue;
    const double w = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * *cutout.alpha.at(u, v) / 255.0;
    sum[0] += w;
    for (int c = 0; c < 3; ++c) sum[c + 1] += w * cutout.color.at(u, v)[c];
  }
  return sum;
}

// Smooth noise from a seeded lattice, 0 … 1.
class Lattice {
 public:
  explicit Lattice(std::uint64_t seed) : seed_(seed) {}
  double at(double x, double y) const {
    const double fx = std::floor(x), fy = std::floor(y), u = ease(x - fx), v = ease(y - fy);
    const auto h = [&](double a, double b) {
      return static_cast<double>(mix(seed_ ^ mix(static_cast<std::uint64_t>(static_cast<std::int64_t>(a)) *
                                                     0x9e3779b97f4a7c15ULL +
                                                 static_cast<std::uint64_t>(static_cast<std::int64_t>(b)))) >>
                                 11) /
             9007199254740992.0;
    };
    return (h(fx, fy) * (1 - u) + h(fx + 1, fy) * u) * (1 - v) +
           (h(fx, fy + 1) * (1 - u) + h(fx + 1, fy + 1) * u) * v;
  }

 private:
  static double ease(double t) { return t * t * (3 - 2 * t); }
  std::uint64_t seed_;
};

}  // namespace

Cutout studio_cutout(std::uint64_t seed, int width, int height) {
  SyntheticRigOptions rig;
  rig.cameras = 1, rig.width = width, rig.height = height;
  SyntheticStudioOptions options;
  options.seed = seed;
  options.samples = 64;
  options.stage = SyntheticStage::Black;
  const auto studio = SyntheticStudio::create(synthetic_rig(rig), options);
  const SyntheticShot shot = studio->shoot(0, static_cast<int>(seed % 20));
  const Image lit = *to_rgb(shot.frame), plate = studio->plate(0);
  Cutout cutout{Image(width, height, 3), to_image(shot.matte)};
  for (std::size_t i = 0; i < lit.pixels.size(); ++i) {
    const double a = cutout.alpha.pixels[i / 3] / 255.0;
    if (a > 0) cutout.color.pixels[i] = byte((lit.pixels[i] - (1 - a) * plate.pixels[i]) / a);
  }
  return cutout;
}

Image green_cloth(int width, int height, std::uint64_t seed) {
  const Lattice folds(seed), light(seed + 1);
  Image out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double bright = 0.6 + 0.35 * light.at(x / 140.0, y / 140.0) + 0.12 * folds.at(x / 18.0, y / 90.0);
      const double rgb[3] = {45 * bright, 160 * bright, 70 * bright};
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = byte(rgb[c]);
    }
  return out;
}

Image cluttered_place(int width, int height, std::uint64_t seed) {
  Random random(seed);
  const Lattice grain(seed + 1), shade(seed + 2);
  Image out(width, height, 3);
  const auto paint = [&](int x, int y, const std::array<double, 3>& color, double texture) {
    const double t =
        1 + texture * (grain.at(x / 3.0, y / 3.0) - 0.5) + 0.5 * (shade.at(x / 60.0, y / 60.0) - 0.5);
    for (int c = 0; c < 3; ++c) out.at(x, y)[c] = byte(color[c] * t);
  };
  const auto any_color = [&] {
    return std::array<double, 3>{random.uniform(40, 220), random.uniform(40, 200), random.uniform(30, 190)};
  };
  const std::array<double, 3> wall = any_color(), floor = any_color();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) paint(x, y, y < height * 6 / 10 ? wall : floor, 0.25);
  for (int k = 0; k < 26; ++k) {  // furniture: rectangles and discs
    const std::array<double, 3> color = any_color();
    const double cx = random.uniform(0, width), cy = random.uniform(0, height), rx = random.uniform(6, 50),
                 ry = random.uniform(6, 50), texture = random.uniform(0, 0.8);
    const bool round = random.uniform() < 0.4;
    for (int y = std::max(0, static_cast<int>(cy - ry)); y < std::min<double>(height, cy + ry); ++y)
      for (int x = std::max(0, static_cast<int>(cx - rx)); x < std::min<double>(width, cx + rx); ++x)
        if (!round || std::hypot((x - cx) / rx, (y - cy) / ry) < 1) paint(x, y, color, texture);
  }
  return out;
}

MatteClip make_clip(const Cutout& cutout, const Image& backdrop, const ClipOptions& options) {
  Random random(options.seed);
  const double direction = random.uniform(0, 2 * kPi),
               turn = (random.uniform() < 0.5 ? -1 : 1) * options.turn * kPi / 180;
  const double begin = random.uniform(-0.15, 0.15), swing = random.uniform(0, 2 * kPi);
  MatteClip clip;
  clip.plate = backdrop;
  const double middle = 0.5 * (options.frames - 1);
  for (int f = 0; f < options.frames; ++f) {
    const double angle = begin + turn * (f - middle);
    const double px = options.width / 2.0 + options.speed * (f - middle) * std::cos(direction) +
                      2 * std::sin(swing + 0.7 * f);
    const double py = options.height / 2.0 + 0.6 * options.speed * (f - middle) * std::sin(direction);
    const double c = std::cos(angle) / options.scale, s = std::sin(angle) / options.scale;
    Image picture(options.width, options.height, 3), truth(options.width, options.height, 1);
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        std::array<double, 4> sum{};
        for (int k = 0; k < kAcross * kAcross; ++k) {
          const double dx = x + (k % kAcross + 0.5) / kAcross - px,
                       dy = y + (k / kAcross + 0.5) / kAcross - py;
          const std::array<double, 4> v = sample(cutout, cutout.alpha.width / 2.0 + c * dx + s * dy,
                                                 cutout.alpha.height / 2.0 - s * dx + c * dy);
          for (int i = 0; i < 4; ++i) sum[i] += v[i] / (kAcross * kAcross);
        }
        *truth.at(x, y) = byte(255 * sum[0]);
        for (int i = 0; i < 3; ++i)
          picture.at(x, y)[i] =
              byte(sum[i + 1] + (1 - sum[0]) * backdrop.at(x, y)[i] + options.noise * random.normal());
      }
    }
    clip.frames.push_back(std::move(picture));
    clip.truth.push_back(std::move(truth));
  }
  return clip;
}

}  // namespace floatstage
