#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "matting/keyers/backing_field.h"
#include "matting/keyers/bit_rows.h"
#include "matting/keyers/field_kernels.h"

// Private to the stage: what BackingField's fast paths have in common.
namespace floatstage::matting {

/// The length of a colour whitened by the lower triangle w (W^T W is an inverse spread).
inline float whitened_length(const float* w, float r, float g, float b) {
  const float x = w[0] * r, y = w[1] * r + w[2] * g, z = w[3] * r + w[4] * g + w[5] * b;
  return std::sqrt(x * x + y * y + z * z);
}

/// A field as the rows of a picture see it, columns [x0, x1).
class BackingField::Rows {
 public:
  Rows(const BackingField& field, Scale scale, const Image& picture, int x0, int x1);
  /// Stays valid until it is asked for the next.
  const FieldRow& at(int y);

 private:
  const BackingField& field_;
  Scale scale_;
  int height_;
  std::vector<std::int32_t> cells_;
  std::vector<float> shares_, terms_;
  FieldRow row_;
};

/// Means of an RGB picture's colours over the squares of 2 * radius + 1 pixels around the pixels of a box,
/// row by row. Beyond the picture lies what its border has.
class SquareMeans {
 public:
  SquareMeans(const Image& picture, int radius, const BitBox& box);
  /// Of the next row; the first time of box.y0. Stays valid until the next call.
  const FieldMeans& next();
  /// The bytes of the row that was given last, taken apart; columns from box.x0 on.
  void planes(const std::uint8_t* out[3]) const;

 private:
  void load(int y);
  std::size_t slot(int y) const;

  const Image& picture_;
  int radius_, x0_, x1_, left_, right_, y_;  // [left_, right_): columns that are read
  bool begun_ = false;
  std::size_t missing_;             // columns that the picture lacks on the left
  std::size_t room_;                // of a plane's row
  std::vector<std::uint8_t> ring_;  // 2 * radius + 2 rows of three planes
  std::vector<std::uint32_t> columns_;
  FieldMeans means_;
};

}  // namespace floatstage::matting
