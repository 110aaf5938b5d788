#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/image.h"
#include "matting/keyers/bit_rows.h"
#include "matting/keyers/field_kernels.h"

// Private to the stage: surfaces behind the subject that are no cloth of one colour.
namespace floatstage::matting {

/// How a field is learnt. Every length is a share of the picture, every level a number of standard deviations
/// of the backing itself; docs/constants.md says which sets the numbers were chosen and checked on.
struct FieldOptions {
  double sigmas = 4;    ///< a colour this far off the backing is none of it
  double reach = 0.05;  ///< of the longer side: half the window in which the backing's colour is averaged
  double rim = 0.03;    ///< of the longer side: width of the rim in which the backing is known to be seen
  double least_known = 0.002;  ///< of a window must be backing, or nothing is known in its middle
  bool darker_too = false;     ///< what is darker than the backing is its shadow (a black stage)
};

/// What one camera sees behind the subject, place by place: the mean colour of the backing near a pixel and
/// how it spreads there, whatever surfaces it is made of and however they are lit. Where the subject stands
/// the field is that of its surroundings. Relative to the picture: it serves pictures of any size. A value;
/// thread safe to read.
class BackingField {
 public:
  /// Which spread a colour is compared with: of single pixels, or of means over a cell of the field.
  enum class Scale { Pixel, Cell };

  /// Standard deviations by which each pixel of an RGB picture is off the backing there (Mahalanobis), row by
  /// row; infinity where no backing is known near. For Scale::Cell the picture is averaged over a cell first.
  /// Slow: what key() and fill_holes() do in vectors (field_kernels.h) is tested against it.
  std::vector<float> distances(const Image& picture, Scale scale) const;

  /// A raw key: 128 and above where a pixel, or the mean of the cell around it, is `sigmas` and more off the
  /// backing; a ramp from half of that.
  Image key(const Image& picture) const;

  /// Fills the holes of a cleaned key that are no backing when looked at as a whole: their cells are more
  /// than half of `sigmas` off it in the mean, as black hair before a black wall.
  void fill_holes(const Image& picture, Image& alpha) const;

  /// Solves the opacity of the pixels within a cell of the outline of a cleaned key: a key only says that a
  /// pixel is not all backing, and the glow of a bright edge reaches far. Of a mixed pixel I = a F + (1 - a)
  /// B the share a is that along F - B, with F the mean of the nearby subject well inside and B the field's,
  /// all as square roots: the rim of a round body is dimmer than its inside. Pixels keep their key where F is
  /// within twice `sigmas` of B, or no inside is near.
  void solve_edges(const Image& picture, Image& alpha) const;
  /// The same of a key, and only those pixels into `alpha` where `here` has bits.
  void solve_edges(const Image& picture, const Image& key, const BitRows& here, Image& alpha) const;

  /// Standard deviation of a pixel's grey about the backing, in 8-bit steps: the median over the backing.
  float noise() const { return noise_; }
  /// Pixels of a picture of this width that a cell is wide, at least 1.
  int cell(int width) const;
  /// Mean grey of what was found to be backing, 8-bit steps.
  double grey() const { return grey_; }
  /// Share of the picture that was found to be backing.
  double share() const { return share_; }
  /// The brightest grey that was let into the backing, in 8-bit steps: at most 255.
  double brightest() const { return brightest_; }

 private:
  class Rows;  // field_rows.h
  void solve_edges(const Image& picture, const Image& key, const BitRows* here, Image& alpha) const;
  friend struct BackingFieldReference;  // of the tests
  friend std::optional<BackingField> learn_field(const std::vector<Image>&, const std::vector<Image>&,
                                                 const FieldOptions&);

  // Values of the cells row by row, in planes of which each row goes on with its last value
  // (field_kernels.h).
  std::size_t stride() const { return (static_cast<std::size_t>(cols_) + FieldRow::kAhead + 15) / 16 * 16; }
  const float* terms(Scale scale, int row) const;  // FieldRow::kTerms planes
  float known(std::size_t col, std::size_t row) const { return known_[row * stride() + col]; }

  int cols_ = 0, rows_ = 0;
  std::vector<float> pixel_, cell_;
  std::vector<float> known_;  // 1 where the backing is known near
  double share_ = 0, grey_ = 0, brightest_ = 255;
  float noise_ = 0, sigmas_ = 4;
  bool darker_too_ = false;
};

/// Grows the backing from the pictures' rims inwards (ADR 0170). `pictures`: RGB, of one camera; those of
/// another size than the first are not looked at. `left_out`: empty, or a mask a picture of what is known to
/// be something else (cloth, borders that a converter added), not 0 there. The rim is backing but for what is
/// brighter than a level; that level is the lowest of a ladder at which the outline of what remains is within
/// a twentieth of the sharpest. Nothing when no rim is left. Deterministic.
std::optional<BackingField> learn_field(const std::vector<Image>& pictures,
                                        const std::vector<Image>& left_out, const FieldOptions& options = {});

}  // namespace floatstage::matting
