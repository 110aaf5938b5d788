#include "render/cpu/picture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "render/renderer_checks.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kLongestWarp = 8;  // px: the flow's full colour

std::uint8_t byte_of(float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.F, 255.F) + 0.5F); }

std::array<float, 3> hue(float h) {
  std::array<float, 3> rgb{};
  const float shift[3] = {0, 2.F / 3, 1.F / 3};
  for (std::size_t c = 0; c < 3; ++c) {
    const float turn = h + shift[c], part = turn - std::floor(turn);
    rgb[c] = std::clamp(std::abs(part * 6 - 3) - 1, 0.F, 1.F);
  }
  return rgb;
}

// One colour a camera, the same from every view.
std::array<float, 3> camera_color(int index) {
  const float turn = 0.11F + 0.618034F * static_cast<float>(index);
  std::array<float, 3> rgb = hue(turn - std::floor(turn));
  for (float& c : rgb) c = 0.25F + 0.75F * c;
  return rgb;
}

}  // namespace

void Picture::begin(const View& view, const std::array<float, 3>& background) {
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

Result<void> Picture::soften(Projection& projection, const RendererOptions& options) {
  if (projection.interruption().given_up()) return given_up();
  if (has_soft_outline(options)) outline_.run(projection, options.output == RenderOutput::Opacity, image_);
  return projection.interruption().given_up() ? Result<void>(given_up()) : Result<void>();
}

bool is_shared_intermediate(RenderOutput output) {
  return output == RenderOutput::Weights || output == RenderOutput::Visibility ||
         output == RenderOutput::SoftVisibility || output == RenderOutput::Depth ||
         output == RenderOutput::Opacity;
}

void draw_intermediate(Projection& projection, const Scene& scene, const View& view, RenderOutput output,
                       Picture& picture) {
  const Eigen::AlignedBox3f& box = scene.impl().box;
  const float middle =
      static_cast<float>((view.view_from_world * Eigen::Vector3d(box.center().cast<double>())).z());
  const float radius = 0.5F * box.diagonal().norm() + 1e-6F;
  const CameraChoice& choice = projection.choice();
  const std::size_t shown = output == RenderOutput::Weights ? choice.listed.size() : choice.chosen;
  projection.for_rows([&](int y, RowMemory& memory) {
    const Covered::Row& row = projection.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    float* rgb = memory.floats(3 * count);
    std::fill_n(rgb, 3 * count, 0.F);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = row.list + i;
      if (output == RenderOutput::Opacity) break;  // Picture::soften() draws it
      if (output == RenderOutput::Depth) {
        const float z = 1 / projection.covered().inverse_z[at];
        const float bright = 1 - std::clamp((z - middle + radius) / (2 * radius), 0.F, 1.F);
        std::fill_n(rgb + 3 * i, 3, 255 * bright);
        continue;
      }
      for (std::size_t slot = 0; slot < shown; ++slot) {
        const float part = 1 / static_cast<float>(shown);
        const float amount = output == RenderOutput::Weights ? projection.weight(slot)[at]
                             : output == RenderOutput::Visibility
                                 ? part * static_cast<float>(projection.visible()[at] >> slot & 1)
                                 : part * projection.soft(slot)[at];
        const std::array<float, 3> color = camera_color(choice.listed[slot]);
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] += 255 * amount * color[c];
      }
    }
    picture.write(projection, y, rgb, 3);
  });
}

std::array<float, 3> flow_color(float u, float v) {
  const float direction = std::atan2(v, u) / (2 * std::numbers::pi_v<float>),
              amount = std::min(std::hypot(u, v) / kLongestWarp, 1.F);
  std::array<float, 3> rgb = hue(direction);
  for (float& c : rgb) c = 255 * (1 + amount * (c - 1));
  return rgb;
}

std::array<float, 3> heat_color(float amount) {
  std::array<float, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = 255 * std::clamp(3 * amount - static_cast<float>(c), 0.F, 1.F);
  return rgb;
}

RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const Picture& picture) {
  return {.picture = &picture.image(),
          .width = view.model.width,
          .height = view.model.height,
          .cameras = cameras_of(scene, projection.choice())};
}

}  // namespace floatstage::render::cpu
