#pragma once

#include <span>
#include <vector>

#include "core/image.h"

namespace floatstage::matting {

/// What the subject's and the backdrop's colours are in several cameras' pictures of one instant: histograms
/// (matting/color_model.h). The subject is one and the same, so every camera's model of it borrows from all
/// others'; each has a backdrop of its own.
class ViewColors {
 public:
  /// `shares[i]`: of each pixel of pictures[i] how much it counts as subject, 0 … 1; below 0 it is left out.
  /// Pictures are RGB or empty.
  /// `novelty`: how likely the subject has colours that have not been seen of it, 0 … 1; those of the
  /// backdrop have been.
  ViewColors(std::span<const Image> pictures, std::span<const std::vector<float>> shares, double novelty,
             int threads);

  /// Of each pixel the log of how much likelier its colour is in the subject than in the backdrop.
  std::vector<float> odds(int camera, const Image& picture) const;

 private:
  struct Model {
    std::vector<float> odds;  // a bin
  };
  std::vector<Model> cameras_;
};

}  // namespace floatstage::matting
