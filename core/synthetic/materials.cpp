#include "core/synthetic/materials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/synthetic/bitmap_font.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/room_surfaces.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3f;

constexpr float kPi = std::numbers::pi_v<float>;

void blend(Vector3f& color, const Vector3f& over, float opacity) { color += (over - color) * opacity; }

// Woven cloth: wrinkles (painted, so that the shells stay smooth), and grain that is left out where a ray
// cannot see it.
float weave(const Vector3f& p, float footprint, std::uint32_t seed) {
  constexpr float kGrain = 0.005f;
  const float seen = std::clamp(1.6f - footprint / kGrain, 0.0f, 1.0f);
  const float bend = value_noise(p / 0.11f, seed);
  const float wrinkle = std::abs(
      2 * value_noise({p.x() / 0.07f + 2 * bend, p.y() / 0.07f, p.z() / 0.045f + 2 * bend}, seed + 2) - 1);
  return 1.02f + 0.07f * (bend - 0.5f) - 0.10f * std::max(0.0f, 1 - 4 * wrinkle) +
         0.13f * seen * (value_noise(p / kGrain, seed + 1) - 0.5f);
}

// A line of print centred on x = 0 with its top at `top`; x to the reader's right. `dot` is one dot's size in
// metres.
float print(std::string_view line, float x, float z, float top, float dot, float width) {
  return printed_ink(line, x / dot + printed_width(line) / 2, (top - z) / dot, width / dot);
}

// 1 in the box |x| < a, |z - z0| < b.
float box(float x, float z, float a, float b, float w) {
  return (1 - soft_step(a, std::abs(x), w)) * (1 - soft_step(b, std::abs(z), w));
}

Vector3f shirt(const SurfacePoint& p, std::uint32_t seed) {
  const float z = p.rest.z(), w = p.footprint;
  const float angle = std::atan2(p.rest.x(), p.rest.y());  // 0 in front, positive to the performer's right
  const float around = 0.15f * angle;                      // metres along the cloth, about
  Vector3f color(0.93f, 0.90f, 0.83f);
  const Vector3f ink(0.11f, 0.12f, 0.26f), red(0.80f, 0.15f, 0.16f);
  const bool front = std::abs(angle) < kPi / 2;
  // Text is read from outside: the performer's right is the reader's left in front, and the other way behind.
  const float x = front ? -around : (angle > 0 ? kPi - angle : -kPi - angle) * 0.15f;
  blend(color, {0.24f, 0.42f, 0.70f}, stripes(z, 0.024f, 0.26f, w) * soft_step(0.115f, std::abs(x), 0.004f));
  blend(color, red, 1 - soft_step(0.012f, std::abs(std::abs(around) - 0.235f), w));  // side seams
  if (front) {
    blend(color, red, print("FLOAT", x, z, 0.430f, 0.0071f, w));
    blend(color, ink, print("TEXTURES", x, z, 0.362f, 0.0044f, w));
    // A badge of small checks between two rules, and a line of small print.
    const float band = box(x, z - 0.290f, 0.105f, 0.022f, w);
    const float check = std::abs(stripes(x, 0.0176f, 0.5f, w) - stripes(z, 0.0176f, 0.5f, w));
    blend(color, check * Vector3f(0.95f, 0.62f, 0.10f) + (1 - check) * ink, band);
    blend(color, ink, print("STAGE 8 - TAKE 01", x, z, 0.252f, 0.0024f, w));
    blend(color, red, print("2008", x, z, 0.215f, 0.0090f, w));
    blend(color, ink, box(x, z - 0.138f, 0.105f, 0.0035f, w));
    blend(color, ink, print("AHEAD OF GHOSTS", x, z, 0.122f, 0.0025f, w));
  } else {
    blend(color, ink, print("STUDIO", x, z, 0.440f, 0.0062f, w));
    blend(color, red, print("07", x, z, 0.375f, 0.0170f, w));
    blend(color, ink, print("EIGHT CAMERAS", x, z, 0.235f, 0.0030f, w));
    blend(color, ink, stripes(x, 0.012f, 0.5f, w) * box(x, z - 0.17f, 0.105f, 0.015f, w));
  }
  blend(color, ink, soft_step(0.528f, z, w));    // collar
  blend(color, ink, 1 - soft_step(0.0f, z, w));  // hem
  return color * weave(p.rest, w, seed);
}

Vector3f sleeve(const SurfacePoint& p, std::uint32_t seed) {
  const float z = p.rest.z(), w = p.footprint;
  if (z > 0.470f) return skin_albedo(p.rest, w, seed);
  Vector3f color(0.93f, 0.90f, 0.83f);
  const Vector3f dark = p.variant > 0 ? Vector3f(0.16f, 0.22f, 0.52f) : Vector3f(0.66f, 0.13f, 0.17f);
  blend(color, dark, stripes(z, 0.034f, 0.5f, w));
  blend(color, {0.95f, 0.70f, 0.16f}, stripes(z + 0.0035f, 0.034f, 0.16f, w));  // a thin yellow edge
  blend(color, {0.14f, 0.14f, 0.18f}, soft_step(0.443f, z, w));                 // cuff
  blend(color, {0.95f, 0.93f, 0.88f},
        soft_step(0.443f, z, w) * stripes(std::atan2(p.rest.x(), p.rest.y()) * 0.034f, 0.010f, 0.4f, w));
  return color * weave(p.rest, w, seed + 3);
}

// Checked cloth; `around` and `z` in metres along it.
Vector3f tartan(float around, float z, float w) {
  Vector3f color(0.25f, 0.29f, 0.45f);
  auto lines = [&](float at, float period, float duty, const Vector3f& line, float opacity) {
    blend(color, line, opacity * stripes(at, period, duty, w));
  };
  lines(around, 0.064f, 0.30f, {0.46f, 0.18f, 0.24f}, 0.65f);
  lines(z, 0.064f, 0.30f, {0.46f, 0.18f, 0.24f}, 0.65f);
  lines(around + 0.030f, 0.064f, 0.075f, {0.93f, 0.90f, 0.80f}, 0.85f);
  lines(z + 0.030f, 0.064f, 0.075f, {0.93f, 0.90f, 0.80f}, 0.85f);
  lines(z + 0.047f, 0.064f, 0.05f, {0.92f, 0.72f, 0.20f}, 0.9f);
  return color;
}

Vector3f trousers(const SurfacePoint& p, std::uint32_t seed) {
  const float z = p.rest.z(), w = p.footprint;
  if (z > 0.803f)
    return Vector3f(0.90f, 0.90f, 0.92f) * (0.85f + 0.15f * stripes(z, 0.006f, 0.5f, w));  // socks
  // Limb coordinates: y to the front, x to the performer's left. The outside is towards the leg's own side.
  const float angle = std::atan2(-p.rest.x() * static_cast<float>(p.variant), p.rest.y()),
              around = 0.068f * angle;
  Vector3f color = tartan(around + 0.02f, z, w);
  const float stripe = std::abs(around - 0.068f * kPi / 2);
  blend(color, {0.95f, 0.93f, 0.88f}, 1 - soft_step(0.016f, stripe, w));
  blend(color, {0.86f, 0.36f, 0.10f}, 1 - soft_step(0.008f, stripe, w));
  blend(color, {0.15f, 0.17f, 0.30f}, soft_step(0.778f, z, w));
  return color * weave(p.rest, w, seed + 5);
}

Vector3f hips(const SurfacePoint& p, std::uint32_t seed) {
  const float z = p.rest.z(), w = p.footprint, angle = std::atan2(p.rest.x(), p.rest.y()),
              around = 0.13f * angle;
  Vector3f color = tartan(around + 0.02f, z, w);
  const float belt = 1 - soft_step(0.019f, std::abs(z + 0.035f), w);
  Vector3f leather(0.34f, 0.19f, 0.10f);
  blend(leather, {0.85f, 0.66f, 0.36f},
        stripes(around, 0.020f, 0.3f, w) * (1 - soft_step(0.005f, std::abs(z + 0.035f), w)));
  blend(color, leather, belt);
  if (std::abs(angle) < 1) {
    blend(color, {0.88f, 0.84f, 0.72f}, box(around, z + 0.035f, 0.028f, 0.022f, w));
    blend(color, {0.30f, 0.22f, 0.16f}, box(around, z + 0.035f, 0.018f, 0.012f, w));
  }
  return color * weave(p.rest, w, seed + 6);
}

Vector3f shoe(const SurfacePoint& p, std::uint32_t seed) {
  const float x = p.rest.x(), y = p.rest.y(), z = p.rest.z(), w = p.footprint;
  Vector3f color(0.78f, 0.16f, 0.15f);
  blend(color, {0.95f, 0.94f, 0.91f}, 1 - soft_step(-0.066f, z, w));                                  // sole
  blend(color, {0.20f, 0.20f, 0.24f}, (1 - soft_step(-0.080f, z, w)) * stripes(y, 0.012f, 0.5f, w));  // tread
  blend(color, {0.95f, 0.94f, 0.91f}, soft_step(0.125f, y, w));  // toe cap
  const float laces = (1 - soft_step(0.018f, std::abs(x), w)) * soft_step(-0.050f, z, w) *
                      soft_step(0.02f, y, w) * (1 - soft_step(0.115f, y, w));
  blend(color, {0.97f, 0.96f, 0.93f}, laces * stripes(y + 0.5f * std::abs(x), 0.016f, 0.45f, w));
  blend(color, {0.97f, 0.96f, 0.93f},
        (1 - soft_step(-0.03f, y, w)) * stripes(z, 0.016f, 0.4f, w) * soft_step(-0.062f, z, w));
  return color * weave(p.rest, w, seed + 7);
}

Vector3f hair(const SurfacePoint& p, std::uint32_t seed) {
  const Vector3f d = p.rest - Vector3f(0, -0.01f, 0.15f);
  const float w = p.footprint, across = std::atan2(d.x(), d.z() + 0.3f) * 0.35f + 0.25f * d.x();
  const float strand = value_noise({across / 0.004f, d.y() / 0.05f, d.z() / 0.05f}, seed + 8);
  const float seen = std::clamp(1.6f - w / 0.004f, 0.0f, 1.0f);
  Vector3f color = Vector3f(0.37f, 0.21f, 0.13f) * (1 + 1.1f * seen * (strand - 0.5f));
  // A hairband that holds the tail.
  blend(color, {0.85f, 0.20f, 0.42f},
        1 - soft_step(0.012f, std::abs(d.y() + 0.045f + 0.4f * d.z() - 0.04f), w));
  return color;
}

Vector3f strand(const SurfacePoint& p, std::uint32_t seed) {
  constexpr std::array<std::array<float, 3>, 4> kColors = {
      {{0.40f, 0.23f, 0.14f}, {0.86f, 0.16f, 0.20f}, {0.95f, 0.72f, 0.14f}, {0.80f, 0.22f, 0.58f}}};
  const auto& c = kColors[static_cast<std::size_t>(p.variant)];
  const float shade = p.variant == 0 ? 0.8f + 0.5f * p.rest.x()
                                     : 0.82f + 0.18f * stripes(p.rest.z(), 0.05f, 0.5f, p.footprint);
  return Vector3f(c[0], c[1], c[2]) * shade *
         (0.9f + 0.2f * value_noise({p.rest.x() * 50, 0, p.rest.z() / 0.02f}, seed + 9));
}

bool of_the_cloth(const SurfacePoint& p) {
  if (p.material == Material::Sleeve) return p.variant > 0 && p.rest.z() < 0.443f;
  return p.material == Material::Shirt && p.rest.y() > 0 && p.rest.z() < 0.20f;
}

// The same patterns in other colours.
Vector3f other_dress(Material material, const Vector3f& usual) {
  switch (material) {
    case Material::Shirt:
    case Material::Sleeve:
      return usual.cwiseProduct(Vector3f(0.58f, 0.14f, 0.20f));
    case Material::Trousers:
    case Material::Hips:
      return Vector3f(0.93f, 0.88f, 0.84f) - 0.5f * usual;
    case Material::Shoe:
    case Material::Hair:
      return 0.35f * usual;
    default:
      return usual;
  }
}

}  // namespace

Vector3f albedo(const SurfacePoint& p, std::uint32_t seed, Dress dress) {
  if (dress == Dress::OfTheCloth && of_the_cloth(p)) return kGreenCloth * weave(p.rest, p.footprint, seed);
  if (dress == Dress::Other) return other_dress(p.material, albedo(p, seed));
  switch (p.material) {
    case Material::Face:
      return face_albedo(p.rest, p.footprint, seed);
    case Material::Skin:
      return skin_albedo(p.rest, p.footprint, seed);
    case Material::Hair:
      return hair(p, seed);
    case Material::Shirt:
      return shirt(p, seed);
    case Material::Sleeve:
      return sleeve(p, seed);
    case Material::Trousers:
      return trousers(p, seed);
    case Material::Hips:
      return hips(p, seed);
    case Material::Shoe:
      return shoe(p, seed);
    case Material::Strand:
      return strand(p, seed);
  }
  return Vector3f::Zero();
}

}  // namespace floatstage::synthetic
