#include "render/cpu/floating_inspection.h"

#include <algorithm>
#include <cmath>

#include "render/cpu/false_color.h"
#include "render/cpu/inspection.h"

namespace floatstage::render::cpu {
namespace {

void put(const std::array<float, 3>& color, std::size_t pixel, float* rgb) {
  std::copy(color.begin(), color.end(), rgb + 3 * pixel);
}

class FloatedIntermediate {
 public:
  FloatedIntermediate(const Projection& projection, const PairwiseFlows& flows,
                      const RendererOptions& options, const ShownSlots& shown, int y, const FloatedRow& row)
      : projection_(projection),
        flows_(flows),
        shown_(shown),
        any_(options.shown_camera < 0),
        shrink_(options.flow.shrink),
        y_(y),
        count_(projection.choice().chosen),
        covered_(projection.covered().rows[static_cast<std::size_t>(y)]),
        pixels_(static_cast<std::size_t>(covered_.count)),
        row_(row) {}

  void draw(RenderOutput output, float* rgb, RowMemory& memory) const {
    switch (output) {
      case RenderOutput::Flow:
        return warp(rgb);
      case RenderOutput::Ghosting:
        return ghosting(rgb);
      case RenderOutput::Warped:
        return warped(rgb);
      case RenderOutput::PositionWeights:
        return weights(row_.share.follow, rgb);
      case RenderOutput::ColorWeights:
        return weights(row_.used, rgb);
      case RenderOutput::Field:
        return field(rgb);
      case RenderOutput::Confidence:
        return confidence(rgb);
      default:
        return measured(rgb, memory);
    }
  }

 private:
  float x(std::size_t pixel) const { return projection_.covered().x[covered_.list + pixel]; }

  std::size_t strongest(std::size_t pixel) const {
    std::size_t most = 0;
    for (std::size_t i = 1; i < count_; ++i)
      if (row_.share.pull[i][pixel] > row_.share.pull[most][pixel]) most = i;
    return most;
  }

  // The combined warp of the shown camera, else of each pixel's strongest.
  void warp(float* rgb) const {
    if (!any_ && shown_.camera < 0) return;
    for (std::size_t k = 0; k < pixels_; ++k) {
      const std::size_t i = any_ ? strongest(k) : static_cast<std::size_t>(shown_.camera);
      put(flow_color(x(k) - row_.from_x[i][k], static_cast<float>(y_) + 0.5F - row_.from_y[i][k]), k, rgb);
    }
  }

  void ghosting(float* rgb) const {
    for (std::size_t k = 0; k < pixels_; ++k) {
      const float* mean = row_.mean + 3 * k;
      float apart = 0, total = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        if (row_.used[i][k] <= 0) continue;
        const float* c = row_.rgba[i] + 4 * k;
        apart += row_.used[i][k] * std::hypot(c[0] - mean[0], c[1] - mean[1], c[2] - mean[2]) / 255;
        total += row_.used[i][k];
      }
      put(heat_color(3 * apart / total), k, rgb);
    }
  }

  void warped(float* rgb) const {
    if (shown_.camera < 0) return;
    const auto shown = static_cast<std::size_t>(shown_.camera);
    for (std::size_t k = 0; k < pixels_; ++k) {
      float total = 0;
      for (std::size_t i = 0; i < count_; ++i) total += row_.used[i][k];
      if (row_.used[shown][k] >= kFaintShare * total) std::copy_n(row_.rgba[shown] + 4 * k, 3, rgb + 3 * k);
    }
  }

  void weights(const std::array<float*, kMostListed>& of, float* rgb) const {
    for (std::size_t k = 0; k < pixels_; ++k) {
      float total = 0;
      for (std::size_t i = 0; i < count_; ++i) total += of[i][k];
      if (!(total > 0)) continue;
      for (std::size_t i = 0; i < count_; ++i) {
        const std::array<float, 3> color = camera_color(projection_.choice().listed[i]);
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * k + c] += of[i][k] / total * color[c];
      }
    }
  }

  // Of a field's picture, whose pixels are shrink_ of the view's.
  std::size_t place(std::size_t pixel, const FlowField& field) const {
    const int column = std::min(static_cast<int>(x(pixel)) / shrink_, field.width - 1);
    const int line = std::min(y_ / shrink_, field.height - 1);
    return static_cast<std::size_t>(line) * static_cast<std::size_t>(field.width) +
           static_cast<std::size_t>(column);
  }

  std::size_t shown_pair() const {
    return flow_index_of({static_cast<std::size_t>(shown_.camera), static_cast<std::size_t>(shown_.towards)},
                         count_);
  }

  // What image i shows where it is read, image j shows where that one is.
  std::array<float, 2> apart_by_depth(std::size_t i, std::size_t j, std::size_t pixel) const {
    return {row_.from_x[j][pixel] - row_.from_x[i][pixel], row_.from_y[j][pixel] - row_.from_y[i][pixel]};
  }

  void field(float* rgb) const {
    if (shown_.camera < 0 || shown_.towards < 0) return;
    if (row_.believed != nullptr) {
      const auto from = static_cast<std::size_t>(shown_.camera),
                 to = static_cast<std::size_t>(shown_.towards);
      for (std::size_t k = 0; k < pixels_; ++k) {
        const auto [u, v] = apart_by_depth(from, to, k);
        put(flow_color(u, v), k, rgb);
      }
      return;
    }
    const FlowField& field = flows_.fields()[shown_pair()];
    const auto scale = static_cast<float>(shrink_);
    for (std::size_t k = 0; k < pixels_; ++k) {
      const float* uv = field.uv.data() + 2 * place(k, field);
      put(flow_color(scale * uv[0], scale * uv[1]), k, rgb);
    }
  }

  void confidence(float* rgb) const {
    if (shown_.camera < 0 || shown_.towards < 0) return;
    if (row_.believed != nullptr) {
      const std::uint8_t* line = row_.believed + static_cast<std::ptrdiff_t>(y_ / shrink_) * row_.width;
      for (std::size_t k = 0; k < pixels_; ++k)
        std::fill_n(rgb + 3 * k, 3, static_cast<float>(line[static_cast<int>(x(k)) / shrink_]));
      return;
    }
    const std::vector<std::uint8_t>& known = flows_.confidence()[shown_pair()];
    const FlowField& field = flows_.fields()[shown_pair()];
    for (std::size_t k = 0; k < pixels_; ++k)
      std::fill_n(rgb + 3 * k, 3, known.empty() ? 0.F : static_cast<float>(known[place(k, field)]));
  }

  void measured(float* rgb, RowMemory& memory) const {
    float *nx = memory.floats(pixels_), *ny = memory.floats(pixels_), *nz = memory.floats(pixels_);
    projection_.write_normals(y_, nx, ny, nz);
    std::array<float*, kMostListed> spacing{};
    for (std::size_t i = 0; i < count_; ++i)
      pixel_spacings(projection_, i, y_, {nx, ny, nz}, spacing[i] = memory.floats(pixels_));
    for (std::size_t k = 0; k < pixels_; ++k) {
      BlendClass worst = BlendClass::Sharp;
      for (std::size_t i = 0; i < count_; ++i)
        for (std::size_t j = i; j < count_; ++j)
          if (counts(i, k) && counts(j, k))
            worst = std::max(worst, blend_class(apart(i, j, k), spacing[i][k], spacing[j][k]));
      put(class_color(worst), k, rgb);
    }
  }

  bool counts(std::size_t image, std::size_t pixel) const {
    return projection_.weight(image)[covered_.list + pixel] >= kFaintShare;
  }

  // How far two images show what is here from one another: the longer of both ways, as fields towards a
  // camera that pulls nothing are not sought.
  float apart(std::size_t i, std::size_t j, std::size_t pixel) const {
    if (i == j) return 0;
    if (row_.believed != nullptr) {
      const auto [u, v] = apart_by_depth(i, j, pixel);
      return std::hypot(u, v);
    }
    float longest = 0;
    for (const FlowPair& pair : {FlowPair{i, j}, FlowPair{j, i}}) {
      const FlowField& field = flows_.fields()[flow_index_of(pair, count_)];
      const float* uv = field.uv.data() + 2 * place(pixel, field);
      longest = std::max(longest, std::hypot(uv[0], uv[1]));
    }
    return static_cast<float>(shrink_) * longest;
  }

  const Projection& projection_;
  const PairwiseFlows& flows_;
  const ShownSlots shown_;
  const bool any_;
  const int shrink_, y_;
  const std::size_t count_;
  const Covered::Row& covered_;
  const std::size_t pixels_;
  const FloatedRow& row_;
};

}  // namespace

bool is_floating_intermediate(RenderOutput output) {
  return output == RenderOutput::Flow || output == RenderOutput::Ghosting || output >= RenderOutput::Warped;
}

void float_intermediate(const Projection& projection, const PairwiseFlows& flows,
                        const RendererOptions& options, const ShownSlots& shown, int y, const FloatedRow& row,
                        float* rgb, RowMemory& memory) {
  const auto pixels = static_cast<std::size_t>(projection.covered().rows[static_cast<std::size_t>(y)].count);
  std::fill_n(rgb, 3 * pixels, 0.F);
  FloatedIntermediate(projection, flows, options, shown, y, row).draw(options.output, rgb, memory);
}

}  // namespace floatstage::render::cpu
