#include "render/cpu/unseen.h"

#include <algorithm>

namespace floatstage::render::cpu {
namespace {

/// Calls body(x in the window, pixel of the picture, place in the lists) for a row's covered pixels in the
/// picture, which are none of the margin's.
template <class Body>
void for_covered(const Projection& projection, int y, Image& picture, const Body& body) {
  const Window& window = projection.window();
  const int shown = y + window.y;
  if (shown < 0 || shown >= picture.height) return;
  const Covered::Row& row = projection.covered().rows[static_cast<std::size_t>(y)];
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = projection.covered().spans[s];
    const int first = std::max(span.begin, -window.x), last = std::min(span.end, picture.width - window.x);
    for (int x = first; x < last; ++x)
      body(x, picture.at(x + window.x, shown), span.list + static_cast<std::size_t>(x - span.begin));
  }
}

}  // namespace

SeenPixels Unseen::run(Projection& projection, Image& picture) {
  // Without the margin, so that all methods continue the same.
  const int margin = projection.margin(), across = projection.window().width - 2 * margin,
            down = projection.window().height - 2 * margin;
  const auto width = static_cast<std::size_t>(across), height = static_cast<std::size_t>(down);
  known_.assign(width * height, 0);
  rows_.assign(height, {});
  if (values_.size() < 3 * known_.size()) values_.resize(3 * known_.size());
  projection.for_rows([&](int y, RowMemory&) {
    if (y < margin || y >= margin + down) return;
    const auto line = static_cast<std::size_t>(y - margin);
    SeenPixels& row = rows_[line];
    for_covered(projection, y, picture, [&](int x, const std::uint8_t* pixel, std::size_t list) {
      const std::size_t at = line * width + static_cast<std::size_t>(x - margin);
      const bool is_seen = projection.visible()[list] != 0;
      known_[at] = is_seen ? 255 : 0;
      ++row.shown;
      row.seen += is_seen;
      for (std::size_t k = 0; k < 3; ++k) values_[3 * at + k] = pixel[k];
    });
  });
  SeenPixels all;
  for (const SeenPixels& row : rows_) all.shown += row.shown, all.seen += row.seen;
  if (all.seen == 0 || all.seen == all.shown) return all;
  fill_.run(across, down, 3, known_.data(), values_.data());
  projection.for_rows([&](int y, RowMemory&) {
    if (y < margin || y >= margin + down) return;
    const auto line = static_cast<std::size_t>(y - margin);
    if (rows_[line].seen == rows_[line].shown) return;
    for_covered(projection, y, picture, [&](int x, std::uint8_t* pixel, std::size_t) {
      const float* value = values_.data() + 3 * (line * width + static_cast<std::size_t>(x - margin));
      for (std::size_t k = 0; k < 3; ++k)
        pixel[k] = static_cast<std::uint8_t>(std::clamp(value[k], 0.F, 255.F) + 0.5F);
    });
  });
  return all;
}

}  // namespace floatstage::render::cpu
