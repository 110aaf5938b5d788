#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/board.h"
#include "core/image.h"

namespace floatstage::calib {

/// A board that pictures show, told without a description of it.
struct IdentifiedBoard {
  TargetDesign
      design;  ///< a chessboard, a ChArUco board or a tag grid; its squares (or tags) as large as was said
  int pictures = 0;  ///< that show it
  std::string how;   ///< what was read in them, one sentence
};

/// Which board these pictures show: the kind of markers and how they lie (their numbers tell the columns), or
/// the crossings of a whole chessboard, in as many pictures as possible. Lengths cannot be seen: `square`
/// (metres) is taken as given. Rows of a marker board that never show their markers are not known of. Absent
/// when fewer than two pictures (of one: one) agree on a board.
std::optional<IdentifiedBoard> identify_board(std::span<const Image> pictures, double square);

}  // namespace floatstage::calib
