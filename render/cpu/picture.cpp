#include "render/cpu/picture.h"

#include <algorithm>
#include <cstring>

#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

std::uint8_t byte_of(float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.F, 255.F) + 0.5F); }

}  // namespace

void Picture::begin(const View& view, const std::array<float, 3>& background) {
  seen_ = {};
  image_.width = view.model.width;
  image_.height = view.model.height;
  image_.channels = 4;
  image_.pixels.resize(4 * static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height));
  const std::uint8_t rgba[4] = {byte_of(255 * background[0]), byte_of(255 * background[1]),
                                byte_of(255 * background[2]), 0};
  const std::size_t row = 4 * static_cast<std::size_t>(image_.width);
  for (std::size_t i = 0; i < row; i += 4) std::memcpy(image_.pixels.data() + i, rgba, 4);
  for (int y = 1; y < image_.height; ++y) std::memcpy(image_.at(0, y), image_.pixels.data(), row);
}

void Picture::write(const Projection& projection, int y, const float* rgb, int floats) {
  const Covered& covered = projection.covered();
  const Covered::Row& row = covered.rows[static_cast<std::size_t>(y)];
  const int shown = y + projection.window().y, left = projection.window().x;
  if (shown < 0 || shown >= image_.height) return;
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = covered.spans[s];
    const int first = std::max(span.begin, -left), last = std::min(span.end, image_.width - left);
    const float* from = rgb + static_cast<std::size_t>(floats) * (span.list - row.list);
    for (int x = first; x < last; ++x) {
      const float* c = from + static_cast<std::ptrdiff_t>(floats) * (x - span.begin);
      std::uint8_t* to = image_.at(x + left, shown);
      for (int channel = 0; channel < 3; ++channel) to[channel] = byte_of(c[channel]);
      to[3] = 255;
    }
  }
}

Result<void> Picture::soften(Projection& projection, const RendererOptions& options, bool sees) {
  if (projection.interruption().given_up()) return given_up();
  if (sees && has_soft_outline(options) && options.output == RenderOutput::Color)
    seen_ = unseen_.run(projection, image_);
  if (has_soft_outline(options)) outline_.run(projection, options.output == RenderOutput::Opacity, image_);
  return projection.interruption().given_up() ? Result<void>(given_up()) : Result<void>();
}

RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const Picture& picture) {
  return {.picture = &picture.image(),
          .width = view.model.width,
          .height = view.model.height,
          .seen = picture.seen(),
          .cameras = cameras_of(scene, projection.choice())};
}

}  // namespace floatstage::render::cpu
