#pragma once

#include <array>
#include <string>
#include <vector>

#include "calib/board.h"
#include "core/camera.h"

namespace floatstage::calib {

/// One marker on a face: its corners as they are printed, clockwise from the upper left, in the face's frame.
struct FaceMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  ///< metres
};

/// One point of the target that lies on a face.
struct FacePoint {
  int id = 0;                ///< of the target
  Eigen::Vector2d position;  ///< metres
};

/// One flat side of a target: what detection and printing need to know about it. Private to calib.
struct BoardFace {
  double width = 0, height = 0;  ///< metres: of the pattern
  Rigid3 target_from_face = {};  ///< the face's frame: lower left corner, x right, y up, z out of the paper
  std::string dictionary = {};   ///< empty: no markers
  int border = 1;                ///< of the markers, in cells
  bool inverted = false;
  double square = 0;  ///< side of a chessboard square; 0 where there is none
  std::vector<FaceMarker> markers = {};
  std::vector<FacePoint> points = {};
  std::vector<Eigen::Vector4d> black = {};  ///< x, y (lower left), width, height of the plain black squares
};

/// The faces of a target: one, two for a two-sided board, one a tag for a wand with tags, none for balls.
std::vector<BoardFace> board_faces(const TargetDesign& target);

}  // namespace floatstage::calib
