#include "core/synthetic/room_surfaces.h"

#include <algorithm>
#include <cmath>

#include "core/synthetic/noise.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3f;

// Distance to the nearest multiple of `period`.
float off_grid(float x, float period) { return std::abs(x - period * std::round(x / period)); }

// 1 within `half` of 0, falling to 0 over `soft` more.
float bar(float distance, float half, float soft) {
  return std::clamp(1 - (distance - half) / soft, 0.0f, 1.0f);
}

Vector3f mix_to(const Vector3f& color, const Vector3f& over, float share) {
  return color + share * (over - color);
}

// A wall of a dome that nobody hung cloth on.
Vector3f technical_wall(const RoomPoint& p, std::uint32_t seed) {
  const float up = p.position.z();
  Vector3f color = Vector3f(0.048f, 0.050f, 0.054f) * p.light *
                   (0.8f + 0.4f * value_noise({p.along / 0.7f, up / 0.7f, 5}, seed + 11));
  const float lines =
      std::max(bar(off_grid(p.along, 0.21f), 0.004f, 0.006f), bar(off_grid(up, 0.21f), 0.004f, 0.006f));
  color = mix_to(color, {0.045f, 0.105f, 0.050f}, lines);
  color = mix_to(color, {0.070f, 0.200f, 0.085f}, bar(off_grid(p.along, 1.7f), 0.022f, 0.008f));
  // Lamps hang in two bands, a little off their places.
  const float column = std::round(p.along / 0.42f), row = std::round(up / 0.34f);
  const float jitter = 0.08f * (lattice(static_cast<int>(column), static_cast<int>(row), 2, seed) - 0.5f);
  const float distance = std::hypot(p.along - 0.42f * column - jitter, up - 0.34f * row);
  if (static_cast<int>(row) % 5 != 2)
    color = mix_to(color, {0.62f, 0.60f, 0.50f}, bar(distance, 0.022f, 0.012f));
  return color;
}

// The lamps stand close to a floor that is dark at its rim.
Vector3f lit_floor(const RoomPoint& p, std::uint32_t seed) {
  const float r = p.position.head<2>().norm();
  const float light = 0.16f + 0.94f * std::exp(-r * r / 7.5f);
  return kGreenCloth * light * (0.97f + 0.06f * value_noise(p.position / 0.3f, seed + 12));
}

Vector3f cyclorama(const RoomPoint& p, std::uint32_t seed) {
  const Vector3f& x = p.position;
  const float left = (x - Vector3f(-2.5f, 1, 2)).squaredNorm(),
              right = (x - Vector3f(3, -1.5f, 1)).squaredNorm();
  const float light = 0.40f + 0.65f * std::exp(-left / 5) + 0.45f * std::exp(-right / 4) +
                      0.05f * value_noise(x / 0.8f, seed + 13);
  return Vector3f(0.125f, 0.275f, 0.640f) * light;
}

Vector3f lit_black(const RoomPoint& p, std::uint32_t seed) {
  const Vector3f& x = p.position;
  float value = 0.014f * p.light;
  if (p.axis == 2 && p.floor && std::abs(x.x()) < 1.7f) {
    const float folds = 0.75f + 0.5f * value_noise({x.x() / 0.12f, x.y() / 0.9f, 1}, seed + 14);
    value += 0.15f * std::exp(-x.head<2>().squaredNorm() / 1.6f) * folds;
  }
  return Vector3f(1.06f, 1.0f, 0.96f) * value;
}

Vector3f planks(const RoomPoint& p, std::uint32_t seed) {
  const float across = p.position.x() / 0.14f;
  const int plank = static_cast<int>(std::floor(across));
  const float tone = 0.75f + 0.5f * lattice(plank, 0, 0, seed + 15);
  const float grain = value_noise({p.position.x() / 0.012f, p.position.y() / 0.25f, 2}, seed + 16);
  const float gap = bar(off_grid(p.position.x(), 0.14f), 0.002f, 0.004f);
  return mix_to(Vector3f(0.50f, 0.34f, 0.21f) * tone * (0.85f + 0.3f * grain), {0.10f, 0.07f, 0.05f}, gap);
}

// Books of all colours, blue and green among them.
Vector3f shelves(float along, float up, std::uint32_t seed) {
  const float shelf = up / 0.36f, book = along / 0.045f;
  const int row = static_cast<int>(std::floor(shelf)), column = static_cast<int>(std::floor(book));
  if (shelf - std::floor(shelf) < 0.08f) return {0.40f, 0.27f, 0.17f};
  if (shelf - std::floor(shelf) > 0.70f + 0.22f * lattice(column, row, 4, seed + 17))
    return {0.12f, 0.09f, 0.07f};
  auto channel = [&](int c) { return 0.12f + 0.68f * lattice(column, row, c, seed + 18); };
  return {channel(0), channel(1), channel(2)};
}

Vector3f furnished(const RoomPoint& p, std::uint32_t seed) {
  if (p.axis == 2) return p.floor ? planks(p, seed) : Vector3f(0.78f, 0.77f, 0.74f) * p.light;
  const float up = p.position.z(), along = p.along;
  const int side = 2 * p.axis + (p.position[p.axis] > 0 ? 1 : 0);
  if (side == 0 && std::abs(along) < 1.1f && up > 0.9f && up < 2.3f)  // a window
    return off_grid(along, 0.55f) < 0.03f ? Vector3f(0.85f, 0.84f, 0.82f) : Vector3f(0.80f, 0.88f, 0.97f);
  if (side != 1 && up < 2.1f && std::fmod(std::abs(along) + 0.7f, 2.6f) < 1.5f)
    return shelves(along, up, seed + side);
  const float paper = value_noise({along / 0.10f, up / 0.10f, static_cast<float>(side)}, seed + 19);
  return Vector3f(0.66f, 0.60f, 0.50f) * p.light * (0.9f + 0.2f * paper);
}

Vector3f crosses(const Vector3f& cloth, const RoomPoint& p) {
  const float u = p.axis == 2 ? p.position.x() : p.along, v = p.axis == 2 ? p.position.y() : p.position.z();
  const float du = off_grid(u - 0.3f, 0.9f), dv = off_grid(v - 0.3f, 0.9f);
  const float cross = std::max(bar(du, 0.010f, 0.004f) * bar(dv, 0.055f, 0.004f),
                               bar(dv, 0.010f, 0.004f) * bar(du, 0.055f, 0.004f));
  const bool orange = (std::lround((u - 0.3f) / 0.9f) + std::lround((v - 0.3f) / 0.9f)) % 2 != 0;
  return mix_to(cloth, orange ? Vector3f(0.90f, 0.42f, 0.10f) : Vector3f(0.92f, 0.92f, 0.90f), cross);
}

Vector3f cables(const Vector3f& cloth, const RoomPoint& p) {
  const Vector3f& x = p.position;
  float black = 0, grey = 0;
  if (p.axis == 2 && p.floor) {
    black = bar(std::abs(x.y() - 0.55f - 0.35f * std::sin(1.3f * x.x())), 0.010f, 0.004f);
    grey = bar(std::abs(x.x() + 0.8f - 0.25f * std::sin(1.7f * x.y())), 0.012f, 0.004f);
  } else if (p.axis != 2) {
    const float sag = 1.75f + 0.22f * std::pow(off_grid(p.along, 3.0f), 2.0f);
    black = bar(std::abs(x.z() - sag), 0.012f, 0.004f);
    grey = bar(off_grid(p.along - 0.8f, 2.4f), 0.010f, 0.004f);
  }
  return mix_to(mix_to(cloth, {0.60f, 0.60f, 0.62f}, grey), {0.05f, 0.05f, 0.06f}, black);
}

}  // namespace

Vector3f room_surface(SyntheticStage stage, const RoomPoint& p, std::uint32_t seed) {
  const Vector3f cloth = kGreenCloth * p.light;
  switch (stage) {
    case SyntheticStage::Green:
    case SyntheticStage::GreenClothes:
      return cloth;
    case SyntheticStage::Black:
      return Vector3f::Constant(0.022f * p.light);
    case SyntheticStage::GreenBlack:
      return p.axis == 2 && p.floor ? lit_floor(p, seed) : technical_wall(p, seed);
    case SyntheticStage::BlueCyclorama:
      return cyclorama(p, seed);
    case SyntheticStage::LitBlack:
      return lit_black(p, seed);
    case SyntheticStage::Room:
      return furnished(p, seed);
    case SyntheticStage::Markers:
      return crosses(cloth, p);
    case SyntheticStage::Cables:
      return cables(cloth, p);
  }
  return cloth;
}

}  // namespace floatstage::synthetic
