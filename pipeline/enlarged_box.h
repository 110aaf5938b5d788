#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/parallel.h"
#include "pipeline/bicubic.h"

namespace floatstage::pipeline {

/// A rectangle of a picture's pixels whose enlargement is wanted.
struct EnlargedBox {
  int x = 0, y = 0, width = 0, height = 0;
};

/// What read_bicubic() gives at the centres of pixels `scale` times as fine, over a box of a picture of
/// `width` x `height` pixels, whose channels `read(x, y, channel)` gives (only places inside are asked for;
/// the border is repeated). Interleaved, box.width * scale to a row. Rows and columns one after the other:
/// weights repeat with every pixel.
template <class Read>
std::vector<float> enlarged_box(const Read& read, int width, int height, const EnlargedBox& box, int channels,
                                int scale, int threads) {
  std::vector<std::array<float, 4>> weights(static_cast<std::size_t>(scale));
  std::vector<int> before(weights.size());  // of the pixel itself, the second of the four: 0 or one less
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double at = (static_cast<double>(i) + 0.5) / scale - 0.5;
    before[i] = at < 0 ? -1 : 0;
    const std::array<double, 4> w = catmull_rom(at - before[i]);
    for (std::size_t k = 0; k < 4; ++k) weights[i][k] = static_cast<float>(w[k]);
  }
  const std::size_t row = static_cast<std::size_t>(box.width) * scale * channels;
  std::vector<float> out(row * box.height * scale);
  parallel_for(static_cast<std::size_t>(box.height), threads, [&](std::size_t line) {
    const int y = box.y + static_cast<int>(line), columns = box.width + 4;
    std::vector<float> mixed(static_cast<std::size_t>(columns) * channels);
    for (int j = 0; j < scale; ++j) {
      const auto& wy = weights[static_cast<std::size_t>(j)];
      for (int c = 0; c < columns; ++c)
        for (int k = 0; k < channels; ++k) {
          float sum = 0;
          for (int i = 0; i < 4; ++i)
            sum += wy[static_cast<std::size_t>(i)] *
                   static_cast<float>(
                       read(std::clamp(box.x + c - 2, 0, width - 1),
                            std::clamp(y + before[static_cast<std::size_t>(j)] + i - 1, 0, height - 1), k));
          mixed[static_cast<std::size_t>(c) * channels + k] = sum;
        }
      float* to = &out[(line * scale + static_cast<std::size_t>(j)) * row];
      for (int x = 0; x < box.width; ++x)
        for (int s = 0; s < scale; ++s) {
          const auto& wx = weights[static_cast<std::size_t>(s)];
          const float* from =
              &mixed[static_cast<std::size_t>(x + 1 + before[static_cast<std::size_t>(s)]) * channels];
          for (int k = 0; k < channels; ++k)
            *to++ = wx[0] * from[k] + wx[1] * from[k + channels] + wx[2] * from[k + 2 * channels] +
                    wx[3] * from[k + 3 * channels];
        }
    }
  });
  return out;
}

/// A whole picture, `scale` times as large.
inline Image enlarged_picture(const Image& picture, int scale, int threads) {
  if (scale == 1) return picture;
  Image out(picture.width * scale, picture.height * scale, picture.channels);
  constexpr int kRows = 32;  // at a time, so that numbers of all pixels need not be held
  for (int y = 0; y < picture.height; y += kRows) {
    const EnlargedBox box{0, y, picture.width, std::min(kRows, picture.height - y)};
    const std::vector<float> values =
        enlarged_box([&](int px, int py, int k) { return picture.at(px, py)[k]; }, picture.width,
                     picture.height, box, picture.channels, scale, threads);
    std::uint8_t* to = out.at(0, y * scale);
    for (std::size_t i = 0; i < values.size(); ++i)
      to[i] = static_cast<std::uint8_t>(std::clamp(values[i], 0.F, 255.F) + 0.5F);
  }
  return out;
}

}  // namespace floatstage::pipeline
