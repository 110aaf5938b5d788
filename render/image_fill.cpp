#include "render/image_fill.h"

#include <algorithm>

namespace floatstage::render {

void PictureFill::Level::reset(int w, int h) {
  width = w;
  height = h;
  stride = static_cast<std::size_t>((w + 1) / 2 * 2);
  const std::size_t size = stride * static_cast<std::size_t>((h + 1) / 2 * 2);
  value.assign(size, 0);
  weight.assign(size, 0);
}

// A coarse pixel is the mean of the known ones among its four.
void PictureFill::pull(Level& fine, Level& coarse, bool weights_too) {
  for (int y = 0; y < coarse.height; ++y) {
    const float *v0 = fine.row(fine.value, 2 * y), *v1 = fine.row(fine.value, 2 * y + 1);
    const float *w0 = fine.row(fine.weight, 2 * y), *w1 = fine.row(fine.weight, 2 * y + 1);
    float *value = coarse.row(coarse.value, y), *weight = coarse.row(coarse.weight, y);
    for (int x = 0; x < coarse.width; ++x) {
      const float sum = w0[2 * x] * v0[2 * x] + w0[2 * x + 1] * v0[2 * x + 1] + w1[2 * x] * v1[2 * x] +
                        w1[2 * x + 1] * v1[2 * x + 1];
      const float total = w0[2 * x] + w0[2 * x + 1] + w1[2 * x] + w1[2 * x + 1];
      value[x] = sum / (total > 0 ? total : 1);
      if (weights_too) weight[x] = std::min(total, 1.F);
    }
  }
}

// A coarse row at twice its width, by linear interpolation between pixel centres.
const float* PictureFill::expanded(Level& coarse, int y, int width) {
  const auto slot = static_cast<std::size_t>(y % 2);
  float* out = rows_[slot].data();
  if (row_at_[slot] == y) return out;
  row_at_[slot] = y;
  const float* in = coarse.row(coarse.value, y);
  const int last = coarse.width - 1;
  out[0] = in[0];
  for (int x = 0; x < last; ++x) {
    out[2 * x + 1] = in[x] * 0.75F + in[x + 1] * 0.25F;
    out[2 * x + 2] = in[x] * 0.25F + in[x + 1] * 0.75F;
  }
  if (2 * last + 1 < width) out[2 * last + 1] = in[last];
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
    float* value = fine.row(fine.value, y);
    const float* weight = fine.row(fine.weight, y);
    for (int x = 0; x < fine.width; ++x) {
      const float around = top[x] * upper + bottom[x] * lower;
      value[x] = weight[x] >= 1 ? value[x] : weight[x] * value[x] + (1 - weight[x]) * around;
    }
  }
}

void PictureFill::run(int width, int height, int channels, const std::uint8_t* known, float* values) {
  const auto step = static_cast<std::size_t>(channels);
  std::size_t count = 0;
  for (int w = width, h = height;; w = (w + 1) / 2, h = (h + 1) / 2) {
    if (levels_.size() <= count) levels_.emplace_back();
    levels_[count++].reset(w, h);
    if (w == 1 && h == 1) break;
  }
  Level& base = levels_.front();
  for (std::size_t c = 0; c < step; ++c) {
    for (int y = 0; y < height; ++y) {
      const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      float *value = base.row(base.value, y), *weight = base.row(base.weight, y);
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
        const bool is = known[line + x] != 0;
        value[x] = is ? values[(line + x) * step + c] : 0;
        weight[x] = is ? 1.F : 0.F;
      }
    }
    for (std::size_t l = 0; l + 1 < count; ++l) pull(levels_[l], levels_[l + 1], c == 0);
    for (std::size_t l = count - 1; l-- > 0;) push(levels_[l + 1], levels_[l]);
    for (int y = 0; y < height; ++y) {
      const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      const float* value = base.row(base.value, y);
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x)
        values[(line + x) * step + c] = value[x];
    }
  }
}

}  // namespace floatstage::render
