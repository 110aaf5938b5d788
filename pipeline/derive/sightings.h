#pragma once

#include <string>
#include <vector>

#include "calib/board.h"
#include "capture/take.h"
#include "core/rig.h"
#include "pipeline/world.h"

namespace floatstage::pipeline {

/// Where a camera saw a thing.
struct Sighting {
  int camera = 0;
  Eigen::Vector2d pixel;  ///< corner origin
};

struct Placed {
  Eigen::Vector3d point;
  double error = 0;  ///< root mean square distance to the pixels, px
};

/// The point nearest to the rays through the pixels. InvalidArgument, with `what` in the sentence, for fewer
/// than two cameras, rays that are parallel, or a point that misses its pixels by more than `most` px.
Result<Placed> place(const Rig& rig, const std::vector<Sighting>& seen, const std::string& what,
                     double most = 5);

struct BoardWorld {
  WorldChange change;
  int points = 0, cameras = 0;
  double rms = 0;  ///< metres that the points miss the board by
};

/// The world in which a board that lies on the floor in one frame has its frame (calib/board.h: origin at its
/// lower left corner, z up), `height` metres above the floor: up, floor and scale in one. BadData says how
/// many cameras found it and why not, or that they do not agree about it.
Result<BoardWorld> world_from_board(capture::TakeReader& take, const calib::TargetDesign& board, int frame,
                                    double height);

}  // namespace floatstage::pipeline
