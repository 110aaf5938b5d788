#pragma once

#include <optional>
#include <vector>

#include "core/image.h"
#include "pipeline/export/instant.h"

namespace floatstage::pipeline {

/// Where a camera's photograph of the subject stands on a sheet; its matte stands at its right, as large.
struct SheetTile {
  int x = 0, y = 0, width = 0, height = 0;  ///< px of the sheet
  int left = 0, top = 0;                    ///< where it is in the photograph, px of the photograph
  int shrink = 1;                           ///< px of the photograph a px of the sheet, a power of two
};

/// The parts of an instant's photographs that its mesh can show, on one picture.
struct PhotoSheet {
  Image picture;                                ///< RGB; mattes are grey, 255 for a camera without
  std::vector<std::optional<SheetTile>> tiles;  ///< by camera of the instant; none: it sees nothing
};

/// No side of a sheet is longer than `longest`: photographs are halved until they fit.
PhotoSheet photo_sheet(const StraightInstant& instant, int longest = 4096);

}  // namespace floatstage::pipeline
