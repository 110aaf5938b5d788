#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage::render {

/// Continues pictures where they are not known: unknown pixels take the smooth continuation of the known ones
/// around them (pull-push over a pyramid, Gortler et al. 1996, section 3.4). Keeps its memory: use one for
/// many pictures; one thread at a time.
class PictureFill {
 public:
  /// `values`: `channels` interleaved floats a pixel. `known`: one entry a pixel, how far it is: those of 255
  /// stay as they are, those of 0 become their surroundings, others lie between. With none known everything
  /// becomes 0.
  void run(int width, int height, int channels, const std::uint8_t* known, float* values);

 private:
  /// Rows and columns are even in number; what that adds is unknown.
  struct Level {
    int width = 0, height = 0;
    std::size_t stride = 0;
    std::vector<float> value, weight;  // weight: how far it is known, 0 … 1
    void reset(int w, int h);
    float* row(std::vector<float>& plane, int y) const {
      return plane.data() + static_cast<std::size_t>(y) * stride;
    }
  };
  static void pull(Level& fine, Level& coarse, bool weights_too);
  void push(Level& coarse, Level& fine);
  const float* expanded(Level& coarse, int y, int width);

  std::vector<Level> levels_;
  std::vector<float> rows_[2];  // two coarse rows at the fine level's width
  int row_at_[2] = {-1, -1};
};

}  // namespace floatstage::render
