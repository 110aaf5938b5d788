#include <algorithm>
#include <cmath>

#include "core/synthetic/materials.h"
#include "core/synthetic/noise.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3f;

void blend(Vector3f& color, const Vector3f& over, float opacity) { color += (over - color) * opacity; }

// 1 inside the ellipse of half-widths a, b, 0 outside, soft over `width`.
float ellipse(float x, float z, float a, float b, float width) {
  const float distance = (std::hypot(x / a, z / b) - 1) * std::min(a, b);
  return 1 - soft_step(0, distance, width);
}

// Dark dots of about `size` metres at random places, one a cell of four sizes, in `density` of the cells.
float freckles(const Vector3f& p, float size, float density, float footprint, std::uint32_t seed) {
  const float cell = 4 * size;
  const Vector3f q = p / cell;
  float ink = 0;
  const int x0 = static_cast<int>(std::floor(q.x())), y0 = static_cast<int>(std::floor(q.y())),
            z0 = static_cast<int>(std::floor(q.z()));
  // A dot stays 0.3 cells inside its own cell, so only this one matters.
  if (lattice(x0, y0, z0, seed) < density) {
    const Vector3f center(static_cast<float>(x0) + 0.3f + 0.4f * lattice(x0, y0, z0, seed + 1),
                          static_cast<float>(y0) + 0.3f + 0.4f * lattice(x0, y0, z0, seed + 2),
                          static_cast<float>(z0) + 0.3f + 0.4f * lattice(x0, y0, z0, seed + 3));
    ink = 1 - soft_step(size, (q - center).norm() * cell, std::max(footprint, size * 0.6f));
  }
  return ink;
}

}  // namespace

Vector3f skin_albedo(const Vector3f& rest, float footprint, std::uint32_t seed) {
  Vector3f color(0.89f, 0.68f, 0.56f);
  color *= 0.95f + 0.10f * value_noise(rest / 0.035f, seed);
  blend(color, {0.62f, 0.38f, 0.27f}, 0.45f * freckles(rest, 0.0022f, 0.3f, footprint, seed + 10));
  return color;
}

Vector3f face_albedo(const Vector3f& rest, float w, std::uint32_t seed) {
  Vector3f color = skin_albedo(rest, w, seed);
  const float x = rest.x(), z = rest.z() - kHeadCenter.z(), side = std::abs(x);
  if (rest.y() < 0.02f) return color;

  // Cheeks, with their own freckles.
  const float cheek =
      std::exp(-(std::pow((side - 0.040f) / 0.018f, 2.0f) + std::pow((z + 0.025f) / 0.018f, 2.0f)));
  blend(color, {0.90f, 0.50f, 0.43f}, 0.55f * cheek);
  blend(color, {0.50f, 0.28f, 0.20f}, 0.8f * cheek * freckles(rest, 0.0017f, 1.0f, w, seed + 20));

  // Eyes: lid line, white, iris, pupil, glint.
  const float ex = side - 0.032f, ez = z - 0.006f;
  blend(color, {0.70f, 0.45f, 0.38f}, 0.6f * ellipse(ex, ez, 0.0205f, 0.0135f, 0.006f));
  blend(color, {0.13f, 0.09f, 0.08f}, ellipse(ex, ez - 0.001f, 0.0175f, 0.0100f, w));
  blend(color, {0.95f, 0.94f, 0.91f}, ellipse(ex, ez + 0.0008f, 0.0155f, 0.0078f, w));
  blend(color, {0.20f, 0.34f, 0.55f}, ellipse(ex, ez, 0.0074f, 0.0074f, w));
  blend(color, {0.04f, 0.04f, 0.05f}, ellipse(ex, ez, 0.0036f, 0.0036f, w));
  blend(color, {1.0f, 1.0f, 1.0f},
        ellipse(x - std::copysign(0.032f, x) - 0.0022f, ez - 0.0026f, 0.0018f, 0.0018f, w));

  // Brows: bars that slope a little, with hair texture.
  const float bz = z - 0.0275f + (side > 0.036f ? 0.45f : -0.22f) * (side - 0.036f);
  const float brow_hair = 0.75f + 0.25f * stripes(side + 0.4f * z, 0.004f, 0.6f, w);
  blend(color, {0.20f, 0.12f, 0.08f}, brow_hair * ellipse(side - 0.033f, bz, 0.0185f, 0.0044f, w));

  // Nostrils and the shade under the nose.
  blend(color, {0.62f, 0.40f, 0.34f}, 0.7f * ellipse(x, z + 0.039f, 0.015f, 0.0042f, 0.006f));
  blend(color, {0.25f, 0.12f, 0.10f}, ellipse(side - 0.0075f, z + 0.037f, 0.0040f, 0.0024f, w));

  // Mouth: lips, teeth between them.
  const float smile = z + 0.061f - 9.0f * x * x;
  blend(color, {0.72f, 0.22f, 0.24f}, ellipse(x, smile, 0.0270f, 0.0105f, w));
  blend(color, {0.30f, 0.07f, 0.08f}, ellipse(x, smile, 0.0215f, 0.0046f, w));
  blend(color, {0.94f, 0.93f, 0.88f}, ellipse(x, smile - 0.0010f, 0.0190f, 0.0028f, w));
  return color;
}

}  // namespace floatstage::synthetic
