#include "render/image_fill.h"

#include <algorithm>

#include "render/fill_kernels.h"

namespace floatstage::render {

// What lies beyond the picture is unknown; all else is written before it is read.
void PictureFill::Level::reset(int w, int h) {
  width = w;
  height = h;
  stride = static_cast<std::size_t>((w + 1) / 2 * 2);
  const std::size_t used = stride * static_cast<std::size_t>(h),
                    size = stride * static_cast<std::size_t>((h + 1) / 2 * 2);
  for (std::vector<float>* plane : {&value, &weight}) {
    if (plane->size() < size) plane->resize(size);
    float* at = plane->data();
    std::fill(at + used, at + size, 0.F);
    if (w % 2 == 0) continue;
    for (std::size_t end = stride; end <= used; end += stride) at[end - 1] = 0;
  }
}

void PictureFill::pull(Level& fine, Level& coarse, bool weights_too) {
  const FillKernels& kernels = fill_kernels();
  const auto count = static_cast<std::size_t>(coarse.width);
  for (int y = 0; y < coarse.height; ++y) {
    const float *w0 = fine.row(fine.weight, 2 * y), *w1 = fine.row(fine.weight, 2 * y + 1);
    kernels.pull(fine.row(fine.value, 2 * y), w0, fine.row(fine.value, 2 * y + 1), w1, count,
                 coarse.row(coarse.value, y));
    if (weights_too) kernels.pull_weights(w0, w1, count, coarse.row(coarse.weight, y));
  }
}

const float* PictureFill::expanded(Level& coarse, int y, int width) {
  const auto slot = static_cast<std::size_t>(y % 2);
  float* out = rows_[slot].data();
  if (row_at_[slot] == y) return out;
  row_at_[slot] = y;
  fill_kernels().expand(coarse.row(coarse.value, y), static_cast<std::size_t>(coarse.width),
                        static_cast<std::size_t>(width), out);
  return out;
}

void PictureFill::push(Level& coarse, Level& fine) {
  for (std::vector<float>& row : rows_)
    if (row.size() < fine.stride) row.resize(fine.stride);
  row_at_[0] = row_at_[1] = -1;
  for (int y = 0; y < fine.height; ++y) {
    const float place =
        std::clamp(0.5F * static_cast<float>(y) - 0.25F, 0.F, static_cast<float>(coarse.height - 1));
    const int y0 = static_cast<int>(place), y1 = std::min(y0 + 1, coarse.height - 1);
    const float lower = place - static_cast<float>(y0), upper = 1 - lower;
    const float *top = expanded(coarse, y0, fine.width), *bottom = expanded(coarse, y1, fine.width);
    fill_kernels().push(top, upper, bottom, lower, fine.row(fine.weight, y),
                        static_cast<std::size_t>(fine.width), fine.row(fine.value, y));
  }
}

void PictureFill::run(int width, int height, int channels, const std::uint8_t* known, float* values) {
  const auto step = static_cast<std::size_t>(channels), length = static_cast<std::size_t>(width);
  std::size_t count = 0;
  for (int w = width, h = height;; w = (w + 1) / 2, h = (h + 1) / 2) {
    if (levels_.size() <= count) levels_.emplace_back();
    levels_[count++].reset(w, h);
    if (w == 1 && h == 1) break;
  }
  Level& base = levels_.front();
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = known + static_cast<std::size_t>(y) * length;
    std::transform(row, row + length, base.row(base.weight, y),
                   [](std::uint8_t is) { return static_cast<float>(is) / 255; });
  }
  for (std::size_t c = 0; c < step; ++c) {
    for (int y = 0; y < height; ++y) {
      const std::size_t line = static_cast<std::size_t>(y) * length;
      fill_kernels().take(values + line * step + c, step, known + line, length, base.row(base.value, y));
    }
    for (std::size_t l = 0; l + 1 < count; ++l) pull(levels_[l], levels_[l + 1], c == 0);
    for (std::size_t l = count - 1; l-- > 0;) push(levels_[l + 1], levels_[l]);
    for (int y = 0; y < height; ++y) {
      const float* value = base.row(base.value, y);
      float* out = values + static_cast<std::size_t>(y) * length * step + c;
      for (std::size_t x = 0; x < length; ++x) out[x * step] = value[x];
    }
  }
}

}  // namespace floatstage::render
