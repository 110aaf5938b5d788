#pragma once

#include <string>
#include <vector>

#include "core/result.h"
#include "core/rig.h"

namespace floatstage::pipeline {

/// Which cameras pictures are drawn from, and which are left out to compare with.
struct Inputs {
  std::vector<bool> input;  ///< a camera each; one that is held out is no input while it is compared with
  std::vector<int> held;    ///< in the order in which they are compared with
};

/// `inputs`: empty (every camera), serials, or the one word "every:N": every N-th camera in the rig's order,
/// of cameras on a grid (render::camera_grid()) every N-th of every N-th row. `hold_out`: serials, of which
/// an extension may be left out; empty: the cameras that are no inputs, on a grid with every:N those of them
/// in the middle between inputs, where nothing is near; all where all are inputs. NotFound for a serial that
/// there is not; InvalidArgument for words that make no sense and where fewer than two inputs would be left.
Result<Inputs> choose_inputs(const Rig& rig, const std::vector<std::string>& inputs,
                             const std::vector<std::string>& hold_out);

}  // namespace floatstage::pipeline
