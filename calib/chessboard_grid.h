#pragma once

#include <map>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "calib/saddle.h"

namespace floatstage::calib {

/// Crossings that hang together as a chessboard. Its columns and rows are those of the picture, by any
/// quarter turn: (column, row) → place; column × row turns as x × y in the picture. Private to calib.
struct ChessboardGrid {
  std::map<std::pair<int, int>, cv::Point2f> corners = {};
  int columns = 0, rows = 0;  ///< of corners; the smallest column and row are 0
  bool full() const { return !corners.empty() && corners.size() == static_cast<std::size_t>(columns) * rows; }
};

/// The largest grid that grows from the crossings, each neighbour being where the others lead to expect it
/// and of opposite colour (Geiger et al. 2012 grow likewise, by an energy). Empty when no four crossings make
/// a square.
ChessboardGrid grow_chessboard(const std::vector<Saddle>& saddles, std::size_t enough);

}  // namespace floatstage::calib
