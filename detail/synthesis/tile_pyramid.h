#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::detail {

/// Cuts a picture that comes row by row, and its halves, into tiles. Of each level it holds the rows of one
/// row of tiles: memory grows with the picture's width alone.
class TilePyramid {
 public:
  struct Tile {
    int level = 0;  ///< 0: the picture; each further one is half as large, rounded up
    int column = 0, row = 0;
    const Image& picture;  ///< RGB; smaller at the right and bottom edge
  };
  using Take = std::function<Result<void>(const Tile&)>;

  /// Tiles of `side` px with `overlap` px of their neighbours around them, handed to `take` by rows, of every
  /// level from left to right and from the top.
  TilePyramid(int width, int height, int levels, int side, int overlap, Take take);

  /// RGB, as wide as the picture. The error is take's.
  Result<void> add(const Image& rows);
  bool complete() const;
  int levels() const { return static_cast<int>(levels_.size()); }
  int width(int level) const { return levels_[static_cast<std::size_t>(level)].width; }
  int height(int level) const { return levels_[static_cast<std::size_t>(level)].height; }

 private:
  struct Level {
    int width = 0, height = 0;
    int first = 0, end = 0;  // rows that are held
    int next = 0;            // row of tiles
    std::vector<std::uint8_t> rows;
    const std::uint8_t* row(int y) const {
      return &rows[static_cast<std::size_t>(y - first) * 3 * static_cast<std::size_t>(width)];
    }
  };
  Result<void> push(std::size_t level, const std::uint8_t* row);
  Result<void> halve(std::size_t level);
  Result<void> cut(std::size_t level);

  std::vector<Level> levels_;
  const int side_, overlap_;
  const Take take_;
};

}  // namespace floatstage::detail
