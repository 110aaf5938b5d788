#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/result.h"

// Private to the stage.
namespace floatstage::matting {

/// What a still camera has seen of each place of its backdrop, and how often: only where a matte said that it
/// was background, and some pixels away from the subject. Where the subject always stood, nothing is known.
class BackdropMemory {
 public:
  BackdropMemory(int width, int height);

  /// One frame more. `near`: not 0 where the subject is or is near.
  void observe(const Image& picture, const Image& near);
  /// Forgets everything and learns a plate (matting/keyers/plate.h) from frames as a whole.
  Result<void> learn(const std::vector<Image>& pictures, const std::vector<Image>& near);

  bool known(std::size_t pixel) const { return trust_[pixel] > 0; }
  /// Log of how much likelier the subject is than the backdrop, its shadow included, in that pixel; 0 where
  /// nothing is known.
  float odds(std::size_t pixel, const std::uint8_t* rgb) const;
  /// For CutEvidence::calm, in a frame.
  std::vector<float> calm(const Image& picture) const;

 private:
  int width_, height_;
  std::vector<float> color_, noise_, trust_;  // trust: 0 … 1
  std::vector<std::uint8_t> seen_;
};

}  // namespace floatstage::matting
