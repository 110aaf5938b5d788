#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// What each label's colours are in each neighbourhood of a picture: histograms in overlapping windows (Bai,
/// Wang, Simons, Sapiro, "Video SnapCut", 2009, on a grid instead of along the contour, for any number of
/// labels).
class LabelColors {
 public:
  /// Windows of `reach` px to each side, every reach/1.5 px, where `wanted` (one channel) has a pixel that is
  /// not 0.
  LabelColors(int width, int height, int count, int reach, const Image& wanted);

  /// Learns from a picture whose pixels bear labels; those from `count` on are left out.
  void learn(const Image& picture, const Image& labels);

  /// The log of how likely a colour is in each label at a place, against a colour drawn blindly; `out` has
  /// `count` numbers. 0 for all where no window lies. After learn().
  void odds(int x, int y, const std::uint8_t* rgb, std::span<float> out) const;

 private:
  static constexpr int kSide = 24, kBins = kSide * kSide * kSide;
  struct Window {
    int x, y;  // its middle
    std::vector<float> bins, total;
  };
  void finish();
  static std::size_t bin(const std::uint8_t* rgb);
  int place(int column, int row) const;

  int width_, height_, count_, reach_, step_, columns_, rows_;
  std::vector<int> at_;  // a grid's place: the window there, or -1
  std::vector<Window> windows_;
};

}  // namespace floatstage::matting
