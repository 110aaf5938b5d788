#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matting/keyers/bit_clean_up.h"
#include "matting/keyers/bit_rows.h"
#include "matting/keyers/byte_closing.h"
#include "matting/keyers/empty_stage.h"
#include "matting/keyers/row_measure.h"

// Private to the stage.
namespace floatstage::matting {

/// EmptyStage::correct() on bits, of a part of a picture. One thread at a time; nothing is allocated once
/// parts as large were seen.
class BitEmptyStage {
 public:
  /// `stage` outlives it.
  explicit BitEmptyStage(const EmptyStage& stage);

  /// Whether the empty stage was shot at this size.
  bool fits(int width, int height) const { return stage_.alike().fits(width, height); }
  /// Corrects opacities in place: of row y `stride` bytes apart, as many as the stage's plate is wide and
  /// high, 0 outside of `part`, whose columns begin with a whole word. False, and only fixtures are gone,
  /// where the plate does not fit. `changed`: what was written to.
  bool correct(const PixelRows& rgb, const BitBox& part, std::uint8_t* alpha, std::size_t stride,
               BitBox& changed);

 private:
  void read(const std::uint8_t* alpha, std::size_t stride);
  bool take_out_fixtures(const PixelRows& rgb, std::uint8_t* alpha, std::size_t stride);
  void drop_remains(std::uint8_t* alpha, std::size_t stride);
  void find_solid(const PixelRows& rgb);
  bool fits_the_key() const;
  void keep_touching();
  void find_more();

  const EmptyStage& stage_;
  BitRows fixtures_;  // of the whole picture
  BitBox part_;
  std::vector<std::uint8_t> row_;
  BitRows some_, subject_;  // of the part, as all that follow: above 0, at least 128
  BitRows gone_, around_gone_;
  BitCleanUp cleaner_;
  BitMorphology morphology_;
  BitComponents components_;
  ByteClosing closing_;
  BitRows seen_, solid_, solid_faint_, touching_, lacks_, thick_, surrounded_, more_;
  std::vector<std::uint64_t> unlike_;
  std::vector<long> areas_;
  std::vector<std::uint8_t> touched_;
};

}  // namespace floatstage::matting
