#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/board.h"
#include "core/camera.h"

namespace floatstage::calib {

/// One shape in one colour on a sheet: a disc when `radius` is positive, else closed loops filled by the
/// even-odd rule.
struct Ink {
  bool black = true;
  std::vector<std::vector<Eigen::Vector2d>> loops = {};  ///< metres
  Eigen::Vector2d center = Eigen::Vector2d::Zero();      ///< metres
  double radius = 0;                                     ///< metres
};

/// A sheet of white paper: metres from its upper left corner, x right, y down. Later shapes cover earlier
/// ones.
struct Sheet {
  std::string name = {};  ///< "", or "front" and "back"
  double width = 0, height = 0;
  std::vector<Ink> inks = {};
  std::string caption = {};       ///< the target's line, see parse_target()
  Rigid3 target_from_sheet = {};  ///< of a point (x, y, 0) of the paper
};

/// What has to be printed for a target that passes check(): one sheet, two for a two-sided board. A wand of
/// balls gives a black strip with white discs where the balls belong: a drilling template, and a flat wand of
/// its own. `margin` metres of paper stay around the pattern, at least what detection needs.
std::vector<Sheet> target_sheets(const TargetDesign& target, double margin = 0.015);

/// One sheet as SVG, all as the pages of one PDF; true to scale, with the target's line inside and in print,
/// and a ruler to check the printer with. The same bytes every time.
std::string to_svg(const Sheet& sheet);
std::string to_pdf(const std::vector<Sheet>& sheets);

/// Writes a .pdf, or a .svg a sheet (two become <name>-front.svg and <name>-back.svg). Returns the files.
/// InvalidArgument for another extension or a target that does not pass check(); Io.
Result<std::vector<std::filesystem::path>> write_sheets(const TargetDesign& target,
                                                        const std::filesystem::path& file);

}  // namespace floatstage::calib
