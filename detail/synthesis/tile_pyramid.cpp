#include "detail/synthesis/tile_pyramid.h"

#include <algorithm>

#include "core/check.h"

namespace floatstage::detail {

TilePyramid::TilePyramid(int width, int height, int levels, int side, int overlap, Take take)
    : levels_(static_cast<std::size_t>(levels)), side_(side), overlap_(overlap), take_(std::move(take)) {
  for (Level& level : levels_) {
    level.width = width, level.height = height;
    width = (width + 1) / 2, height = (height + 1) / 2;
  }
}

bool TilePyramid::complete() const { return levels_[0].end == levels_[0].height; }

Result<void> TilePyramid::add(const Image& rows) {
  FLOATSTAGE_CHECK(rows.channels == 3 && rows.width == levels_[0].width &&
                       levels_[0].end + rows.height <= levels_[0].height,
                   "rows of another picture");
  for (int y = 0; y < rows.height; ++y)
    if (Result<void> ok = push(0, rows.at(0, y)); !ok) return ok;
  return {};
}

Result<void> TilePyramid::push(std::size_t at, const std::uint8_t* row) {
  Level& level = levels_[at];
  level.rows.insert(level.rows.end(), row, row + 3 * static_cast<std::size_t>(level.width));
  ++level.end;
  if (at + 1 < levels_.size() && (level.end % 2 == 0 || level.end == level.height))
    if (Result<void> ok = halve(at); !ok) return ok;
  while (level.next * side_ < level.height &&
         level.end >= std::min(level.height, (level.next + 1) * side_ + overlap_))
    if (Result<void> ok = cut(at); !ok) return ok;
  return {};
}

// The last two rows; a last one alone counts twice, as a last column does.
Result<void> TilePyramid::halve(std::size_t at) {
  const Level& level = levels_[at];
  const std::uint8_t *below = level.row(level.end - 1),
                     *above = level.end % 2 == 0 ? level.row(level.end - 2) : below;
  std::vector<std::uint8_t> half(3 * static_cast<std::size_t>((level.width + 1) / 2));
  for (std::size_t i = 0; i < half.size(); ++i) {
    const std::size_t left = i / 3 * 6 + i % 3,
                      right = std::min(left + 3, 3 * static_cast<std::size_t>(level.width - 1) + i % 3);
    half[i] = static_cast<std::uint8_t>((above[left] + above[right] + below[left] + below[right] + 2) / 4);
  }
  return push(at + 1, half.data());
}

Result<void> TilePyramid::cut(std::size_t at) {
  Level& level = levels_[at];
  const int y0 = std::max(0, level.next * side_ - overlap_),
            y1 = std::min(level.height, (level.next + 1) * side_ + overlap_);
  for (int column = 0; column * side_ < level.width; ++column) {
    const int x0 = std::max(0, column * side_ - overlap_),
              x1 = std::min(level.width, (column + 1) * side_ + overlap_);
    Image tile(x1 - x0, y1 - y0, 3);
    for (int y = y0; y < y1; ++y)
      std::copy_n(level.row(y) + 3 * static_cast<std::size_t>(x0), 3 * static_cast<std::size_t>(tile.width),
                  tile.at(0, y - y0));
    if (Result<void> ok = take_({static_cast<int>(at), column, level.next, tile}); !ok) return ok;
  }
  ++level.next;
  // What the next row of tiles overlaps, and what is not halved yet.
  const int keep = std::clamp(level.next * side_ - overlap_, level.first, level.end - level.end % 2);
  level.rows.erase(level.rows.begin(),
                   level.rows.begin() + static_cast<std::ptrdiff_t>(3) * (keep - level.first) * level.width);
  level.first = keep;
  return {};
}

}  // namespace floatstage::detail
