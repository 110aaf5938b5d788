#include "studio/messages/outline_code.h"

#include <algorithm>
#include <cmath>

#include "studio/messages/byte_io.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::size_t kLeastPoint = 2, kLeastPolygon = 1 + 3 * kLeastPoint;
constexpr auto kFurthest = static_cast<std::int64_t>(kFurthestPoint * kOutlineSteps);

// Twenty-nine bits of position: sums of two cannot overflow.
bool is_near(std::int64_t steps) { return steps >= -kFurthest && steps <= kFurthest; }

}  // namespace

Result<std::string> encode_outline_points(const Silhouette& outline) {
  std::string code;
  if (outline.points.size() > kMostOutlinePoints)
    return fail(ErrorCode::InvalidArgument, "an outline of too many points; simplify it more");
  code.reserve(16 + 5 * outline.points.size());
  ByteWriter out(code);
  out.put(static_cast<std::uint8_t>(outline.beyond_counts ? 1 : 0));
  out.put_varint(static_cast<std::uint64_t>(outline.polygons()));
  std::int64_t x = 0, y = 0;
  for (int p = 0; p < outline.polygons(); ++p) {
    const int begin = outline.starts[p], end = outline.starts[p + 1];
    if (end - begin < 3)
      return fail(ErrorCode::InvalidArgument, "an outline's polygon has fewer than three points");
    out.put_varint(static_cast<std::uint64_t>(end - begin));
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d& point = outline.points[i];
      if (!(point.cwiseAbs().maxCoeff() <= kFurthestPoint))
        return fail(ErrorCode::InvalidArgument, "an outline's point lies nowhere near its picture");
      const std::int64_t next_x = std::llround(point.x() * kOutlineSteps),
                         next_y = std::llround(point.y() * kOutlineSteps);
      out.put_signed(next_x - x);
      out.put_signed(next_y - y);
      x = next_x;
      y = next_y;
    }
  }
  return code;
}

Result<Silhouette> decode_outline_points(std::string_view code) {
  const auto bad = [](const char* what) { return fail(ErrorCode::BadData, what); };
  ByteReader in(code);
  Silhouette outline;
  const auto flags = in.get<std::uint8_t>();
  if (flags > 1) return bad("an outline of unknown kind");
  outline.beyond_counts = flags == 1;
  const std::size_t polygons = in.get_count(kLeastPolygon);
  outline.starts.reserve(polygons + 1);
  outline.points.reserve(std::min(in.rest().size() / 4, kMostOutlinePoints));
  if (polygons > 0) outline.starts.push_back(0);
  std::int64_t x = 0, y = 0;
  for (std::size_t p = 0; p < polygons && in.good(); ++p) {
    const std::size_t points = in.get_count(kLeastPoint);
    if (points < 3) return bad("an outline whose polygons are cut off");
    if (points > kMostOutlinePoints - outline.points.size()) return bad("an outline of too many points");
    for (std::size_t i = 0; i < points; ++i) {
      const std::int64_t dx = in.get_signed(), dy = in.get_signed();
      if (!is_near(dx / 2) || !is_near(dy / 2) || !is_near(x + dx) || !is_near(y + dy))
        return bad("an outline that leaves its picture far behind");
      x += dx;
      y += dy;
      outline.points.emplace_back(static_cast<double>(x) / kOutlineSteps,
                                  static_cast<double>(y) / kOutlineSteps);
    }
    outline.starts.push_back(static_cast<int>(outline.points.size()));
  }
  if (!in.done()) return bad("an outline of another length than announced");
  return outline;
}

}  // namespace floatstage::studio::wire
