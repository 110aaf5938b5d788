#pragma once

#include <cmath>
#include <cstdint>

#include "matting/keyers/backing.h"

// Private to the stage: the arithmetic of the chroma keyer for one pixel, which chroma_keyer.cpp and the
// kernels of live_key.h do in the same order and precision.
namespace floatstage::matting {

/// A linear form of the channels: r * x + g * y + b * z.
struct ColorForm {
  float r = 0, g = 0, b = 0;
  float of(float x, float y, float z) const { return r * x + g * y + b * z; }
};

// BT.601, full range, CbCr around 0.
constexpr ColorForm kLuma{0.299f, 0.587f, 0.114f};
constexpr float kToCb = 0.564f, kToCr = 0.713f;  // of blue and red less luma

/// u * Cb + v * Cr.
inline ColorForm chroma_form(float u, float v) {
  const float cb = u * kToCb, cr = v * kToCr;
  return {cr - (cb + cr) * kLuma.r, -(cb + cr) * kLuma.g, cb - (cb + cr) * kLuma.b};
}

struct Chroma {
  float luma, cb, cr;
  float length() const { return std::hypot(cb, cr); }
};

inline Chroma chroma_of(Rgb c) {
  const float luma = kLuma.of(c.r, c.g, c.b);
  return {luma, kToCb * (static_cast<float>(c.b) - luma), kToCr * (static_cast<float>(c.r) - luma)};
}

/// How little a pixel looks like the cloth. Saturation is chroma over luma: cloth in shadow keeps it. The
/// angle to the cloth enters as the ratio of the components across and along its direction, so that no pixel
/// needs trigonometry.
struct ClothMeasure {
  // Thresholds of the cloth's saturation along its own direction in the CbCr plane, as shares of the key
  // colour's.
  static constexpr float kSubjectBelow = 0.15f;  // all subject
  static constexpr float kClothAbove = 0.5f;     // all cloth
  static constexpr float kAllCloth = 0.75f;      // no doubt about it, even beside hair
  static constexpr float kAngleSlope = 0.2f;     // what a step across the direction costs of a step along it
  static constexpr float kDarkFloor = 2.0f;      // 8-bit steps of luma that keep black from having saturation
  static constexpr float kEdgeContrast =
      5;  // 8-bit steps of chroma between subject and cloth that solve an edge

  explicit ClothMeasure(Rgb key_color) {
    const Chroma c = chroma_of(key_color);
    along = chroma_form(c.cb / c.length(), c.cr / c.length());
    across = chroma_form(-c.cr / c.length(), c.cb / c.length());
    const float saturation = c.length() / (c.luma + kDarkFloor), slope = 255 / (kClothAbove - kSubjectBelow);
    top = kClothAbove * slope + 0.5f;
    scale = slope / saturation;
    doubtful = top - kAllCloth * slope;
  }

  /// Opacity, not clamped: 255 and above is subject, 0 and below cloth; no doubt about that at most
  /// `doubtful`.
  float value(float r, float g, float b) const {
    const float cloth = along.of(r, g, b) - kAngleSlope * std::abs(across.of(r, g, b));
    return top - scale * cloth / (kLuma.of(r, g, b) + kDarkFloor);
  }

  ColorForm along, across;  ///< the CbCr plane turned so that its first axis is the cloth's direction
  float top = 0, scale = 0, doubtful = 0;
};

}  // namespace floatstage::matting
