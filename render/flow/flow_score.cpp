#include "render/flow/flow_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/text.h"
#include "render/flow/flo_file.h"

namespace floatstage::render {
namespace {

using Color = std::array<double, 3>;

/// The wheel goes round through six colours; between two of them one channel rises or falls in so many steps,
/// few where the eye tells hues apart badly.
std::vector<Color> color_wheel() {
  struct Arc {
    int steps, channel;
    bool rises;
    Color from;
  };
  const Arc arcs[] = {{15, 1, true, {1, 0, 0}},  {6, 0, false, {1, 1, 0}}, {4, 2, true, {0, 1, 0}},
                      {11, 1, false, {0, 1, 1}}, {13, 0, true, {0, 0, 1}}, {6, 2, false, {1, 0, 1}}};
  std::vector<Color> wheel;
  for (const Arc& arc : arcs)
    for (int i = 0; i < arc.steps; ++i) {
      Color color = arc.from;
      const double share = static_cast<double>(i) / arc.steps;
      color[static_cast<std::size_t>(arc.channel)] = arc.rises ? share : 1 - share;
      wheel.push_back(color);
    }
  return wheel;
}

/// `u`, `v` in units of the largest displacement.
Color color_of(const std::vector<Color>& wheel, double u, double v) {
  const double length = std::hypot(u, v), turn = std::atan2(-v, -u) / std::numbers::pi;  // -1 … 1
  const double place = (turn + 1) / 2 * static_cast<double>(wheel.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const Color &a = wheel[low], &b = wheel[(low + 1) % wheel.size()];
  const double share = place - static_cast<double>(low);
  Color color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double hue = (1 - share) * a[c] + share * b[c];
    color[c] = length <= 1 ? 1 - length * (1 - hue) : 0.75 * hue;
  }
  return color;
}

}  // namespace

Result<FlowScore> score_flow(const FlowField& field, const FlowField& truth) {
  if (field.width != truth.width || field.height != truth.height)
    return fail(ErrorCode::InvalidArgument, text("a flow field of ", field.width, "x", field.height,
                                                 " has no truth in one of ", truth.width, "x", truth.height));
  FlowScore score;
  double distance = 0, angle = 0;
  for (std::size_t i = 0; i < truth.uv.size(); i += 2) {
    if (!is_known(truth.uv[i], truth.uv[i + 1])) continue;
    const double u = field.uv[i], v = field.uv[i + 1], tu = truth.uv[i], tv = truth.uv[i + 1];
    distance += std::hypot(u - tu, v - tv);
    // The angle by its tangent: near 0 its cosine says nothing.
    const double cross = std::hypot(v - tv, tu - u, u * tv - v * tu), dot = u * tu + v * tv + 1;
    angle += std::atan2(cross, dot);
    ++score.known;
  }
  const double count = static_cast<double>(score.known);
  score.epe = score.known > 0 ? distance / count : std::numeric_limits<double>::quiet_NaN();
  score.aae = angle / count * 180 / std::numbers::pi;
  return score;
}

Image flow_picture(const FlowField& field, double largest) {
  static const std::vector<Color> wheel = color_wheel();
  if (largest <= 0)
    for (std::size_t i = 0; i < field.uv.size(); i += 2)
      if (is_known(field.uv[i], field.uv[i + 1]))
        largest = std::max(largest, static_cast<double>(std::hypot(field.uv[i], field.uv[i + 1])));
  const double scale = largest > 0 ? 1 / largest : 0;
  Image picture(field.width, field.height, 3);
  for (std::size_t p = 0; 2 * p < field.uv.size(); ++p) {
    const float u = field.uv[2 * p], v = field.uv[2 * p + 1];
    if (!is_known(u, v)) continue;
    const Color color = color_of(wheel, scale * u, scale * v);
    for (std::size_t c = 0; c < 3; ++c)
      picture.pixels[3 * p + c] = static_cast<std::uint8_t>(std::lround(255 * color[c]));
  }
  return picture;
}

}  // namespace floatstage::render
