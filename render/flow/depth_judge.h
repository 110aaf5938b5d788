#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/flow/depth_kernels.h"
#include "render/flow/depth_sweep.h"

namespace floatstage::render {

/// How far displacements are believed that DepthSweep found: as far as the pictures are alike where they
/// lead, over a neighbourhood, and more so than without them. Keeps its memory.
class DepthJudge {
 public:
  /// `known`: width * height of the problem's level, 0…255; 0 off its domain and where no picture is
  /// evidence.
  void run(const DepthSweep::Problem& problem, int threads, std::vector<std::uint8_t>& known);

 private:
  struct Picture {
    RowRing moved, weight;
  };
  struct Sums {
    std::vector<float> apart, rows;  // one row with half a neighbourhood at both ends; sums along several
  };
  struct Worker {
    std::vector<Picture> pictures;
    RowRing shift_x, shift_y, mean, none, still, moved, said;
    Sums of_still, of_moved, of_said;
  };
  static void reset(const DepthLevel& level, Worker& worker);
  static void differ(const DepthSweep::Problem& problem, int y, Worker& worker);
  static void believe(const PictureLevel& level, int y, const Worker& worker, std::uint8_t* known);

  std::vector<Worker> workers_;  // one a band of rows
};

}  // namespace floatstage::render
