#pragma once

#include <vector>

#include "core/frame.h"
#include "core/matte.h"

namespace floatstage::studio {

/// The pixels of a width x height photograph around everything that a matte made at 1/factor of its size does
/// not call background, with a border wide enough for smooth reading. Empty when there is no subject.
PixelBox subject_box(const Matte& small, int factor, int width, int height);

/// Puts mattes made at a fraction of a photograph's size at the photograph's pixels. Its memory is kept, for
/// one thread at a time.
class MatteEnlarger {
 public:
  /// Of a matte at 1/factor of the size what lies within `box`, bilinearly. One channel; `out` keeps its
  /// memory.
  void enlarge(const Matte& small, int factor, const PixelBox& box, Image& out);

 private:
  /// For a pixel of a line of the photograph: the two small pixels around it, and the share of the second in
  /// 256ths.
  struct Tap {
    int low, high, share;
  };
  static void find_taps(int first, int count, int factor, int small, std::vector<Tap>& line);

  std::vector<Tap> across_, down_;
  std::vector<int> line_;  // of small pixels, between two rows; 256ths
};

}  // namespace floatstage::studio
