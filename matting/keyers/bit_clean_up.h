#pragma once

#include "matting/keyers/bit_rows.h"
#include "matting/keyers/keyer.h"

// Private to the stage.
namespace floatstage::matting {

/// clean_up() (keyer.h) on bits: which pixels it keeps, fills and takes away, of a key whose closing is done
/// (byte_closing.h).
class BitCleanUp {
 public:
  /// Whether these can be done: radii that morphology on words, within a word around the key, can do.
  static bool can(const CleanupOptions& options);

  /// `subject`: opacity of at least 128; `faint`: of at least 24. Both become what they are of the cleaned
  /// key.
  void run(const CleanupOptions& options, BitRows& subject, BitRows& faint);
  /// Where the cleaned key is the raw one; elsewhere it is 0, or 255 where filled().
  const BitRows& kept() const { return kept_; }
  const BitRows& filled() const { return filled_; }

 private:
  bool choose_islands(const CleanupOptions& options, const BitRows& subject);
  void erase_the_rest(const BitRows& subject, const BitRows& faint);
  void fill_holes(double largest_hole, const BitRows& subject);

  BitMorphology morphology_;
  BitComponents components_;
  BitRows core_, thick_, near_, dropped_, around_dropped_, rest_, kept_, filled_;
  std::vector<std::uint8_t> chosen_;
  BitBox box_;          // of the islands that stay
  double largest_ = 0;  // px, the largest island
};

}  // namespace floatstage::matting
