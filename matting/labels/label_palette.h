#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"

namespace floatstage::matting {

/// What colours each of some labels, 1 … `labels`, has, in all pictures together: coarse histograms of RGB.
/// A plain value.
class LabelPalette {
 public:
  explicit LabelPalette(int labels);

  /// What was learnt counts so much less from now on, 0 to 1.
  void fade(double keep);
  /// Learns from the pixels that bear a label, 0 is none, and that are opaque in `matte` (alpha above 191).
  void learn(const Image& picture, const Image& matte, const Image& labels);
  bool knows(int label) const { return total_[static_cast<std::size_t>(label - 1)] > 0; }
  /// Of labels of which nothing was learnt, what `other` knows of them; of as many labels.
  void take_unknown(const LabelPalette& other);
  /// In nats, by how much each label's colours fit better than those of all labels in the mean, within
  /// ±kMost; `out` has one number a label. 0 for all where nothing was learnt.
  void odds(const std::uint8_t* rgb, std::span<float> out) const;
  static constexpr float kMost = 3;
  /// How alike two labels' colours are: the Bhattacharyya coefficient, 1 for the same, 0 for no colour in
  /// common. 0 where nothing was learnt of one.
  double alike(int label, int other) const;

 private:
  static constexpr int kSide = 12, kBins = kSide * kSide * kSide;
  static std::size_t bin(const std::uint8_t* rgb);
  float share(std::size_t label, std::size_t bin) const;

  std::vector<std::vector<float>> bins_;  // a label
  std::vector<double> total_;
};

}  // namespace floatstage::matting
