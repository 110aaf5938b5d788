#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// What the pixels of a row are compared with: the terms of a BackingField (backing_field.h) at the height of
/// the row, and how far across the field's cells each pixel lies.
struct FieldRow {
  /// Mean of 3 channels; lower triangle W of the inverse spread, W^T W.
  static constexpr std::size_t kTerms = 9;
  static constexpr std::size_t kAhead = 32;  ///< floats that may be read behind a plane's last cell
  const float* terms = nullptr;              ///< kTerms planes, `stride` floats each, a multiple of 16
  std::size_t stride = 0;
  const float* known = nullptr;         ///< a cell: 0 where no backing is known; null: it is everywhere
  const std::int32_t* cells = nullptr;  ///< a pixel: the cell whose middle is left of its own
  const float* shares = nullptr;        ///< a pixel: how far it is to the middle of the next one, of 1
  bool narrow = false;                  ///< there are fewer pixels than cells
  bool darker_too = false;              ///< what is darker than the backing is none off it
};

/// Mean colours of a row: those of pixel x are the sums of columns x … x + size - 1 of three planes over
/// size * size.
struct FieldMeans {
  const std::uint32_t* columns[3] = {};  ///< size + padded() of each may be read
  int size = 1;
};

/// BackingField's arithmetic for a row of pixels, in vectors of whatever the processor has. The same bits on
/// all, and as BackingField::distances(). Rows, of whatever is read or written a pixel, hold padded() pixels
/// (cloth_kernels.h), and so much is written.
struct FieldKernels {
  const char* name;  ///< of the instruction set
  /// out = a + share * (b - a).
  void (*between)(const float* a, const float* b, float share, std::size_t count, float* out);
  /// columns += more - less.
  void (*slide)(const std::uint8_t* more, const std::uint8_t* less, std::size_t count,
                std::uint32_t* columns);
  /// How far means of colours are off the backing, in standard deviations; infinity where none is known.
  void (*distances)(const FieldRow& row, const FieldMeans& means, std::size_t count, float* out);
  /// The same as opacity: half at `sigmas`, none at half of them.
  void (*mean_alphas)(const FieldRow& row, const FieldMeans& means, float sigmas, std::size_t count,
                      std::uint8_t* out);
  /// The same of single pixels, taken apart into r, g and b.
  void (*alphas)(const FieldRow& row, const std::uint8_t* const* rgb, float sigmas, std::size_t count,
                 std::uint8_t* out);
};

const FieldKernels& field_kernels();            ///< the best that this processor has
std::vector<FieldKernels> all_field_kernels();  ///< all that it has, for tests

}  // namespace floatstage::matting
