#pragma once

#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// How often colours occur: a histogram of 32 steps a channel, smoothed so that a few thousand pixels fill
/// it.
class ColorModel {
 public:
  ColorModel() : bins_(kBins, 0.0f) {}

  static constexpr int kSide = 32, kBins = kSide * kSide * kSide;
  static std::size_t bin(const std::uint8_t* rgb) {
    return (static_cast<std::size_t>(rgb[0] >> 3) * kSide + (rgb[1] >> 3)) * kSide + (rgb[2] >> 3);
  }

  void add(const std::uint8_t* rgb, float weight = 1) { add(bin(rgb), weight); }
  void add(std::size_t bin, float weight) { bins_[bin] += weight; }
  /// Smooths and normalises; after it likelihood() may be asked.
  void finish();
  /// Over that of a colour drawn blindly: 1 is no news. Never 0, since every model has seen too little. 1
  /// when nothing was added.
  float likelihood(const std::uint8_t* rgb) const { return likelihood(bin(rgb)); }
  float likelihood(std::size_t bin) const { return bins_[bin]; }

 private:
  std::vector<float> bins_;
};

}  // namespace floatstage::matting
