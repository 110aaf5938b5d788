#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "core/result.h"

namespace floatstage::calib {

// Calibration targets as they are printed and built. Every flat target has the frame of its print: the origin
// is the lower left corner of the pattern, x to the right, y up, z out of the paper, metres. Lying on the
// floor, its z points up. Columns and rows always count squares or tags, never inner corners. Points are
// numbered row by row from the top left.

/// Plain black and white squares, the top left one black. Unambiguous only when one of columns and rows is
/// odd and the other even; see ambiguity().
struct Chessboard {
  int columns = 0, rows = 0;
  double square = 0;  ///< metres
  bool operator==(const Chessboard&) const = default;
};

/// Chessboard with a marker in each white square, numbered row by row from the top left; the points are the
/// inner corners of the chessboard.
struct CharucoBoard {
  int columns = 0, rows = 0;
  double square = 0, marker = 0;  ///< metres
  std::string dictionary = {};    ///< "4x4_50" … "7x7_1000", "aruco_original", "apriltag_36h11", …
  int first_marker = 0;
  bool inverted = false;  ///< black and white exchanged in print
  bool white_first =
      false;  ///< the top left square is white: what OpenCV printed before 4.6 for an even number of rows
  bool operator==(const CharucoBoard&) const = default;
};

/// Rows of tags with black squares in the gaps' crossings, numbered from the lower left as Kalibr does; the
/// points are the tags' corners, four a tag: lower left, lower right, upper right, upper left.
struct AprilTagGrid {
  int columns = 0, rows = 0;
  double tag = 0, gap = 0;  ///< metres: side of a tag with its black border; between two tags
  std::string dictionary = {};
  int first_tag = 0;
  int border = 1;  ///< width of the black border in cells (Kalibr prints 2)
  bool operator==(const AprilTagGrid&) const = default;
};

/// Two ChArUco boards back to back. The frame is the front's; the back's upper edge is above the front's
/// upper edge and its paper lies `thickness` behind the front's. Points of the back follow those of the
/// front.
struct TwoSidedBoard {
  CharucoBoard front = {};
  int back_first_marker = 0;  ///< the rest of the back is like the front
  double thickness = 0;       ///< metres, from paper to paper
  bool operator==(const TwoSidedBoard&) const = default;
};

/// Two or three bright balls, or flat tags, in a row at known distances. The frame: x along the wand from the
/// first point. Points are the balls' or tags' centres.
struct Wand {
  std::vector<double> positions = {};  ///< metres along the wand; the first is 0; ascending
  double ball = 0;                     ///< metres: diameter of the balls; 0 for tags
  double tag = 0;                      ///< metres: side of the tags; 0 for balls
  std::string dictionary = {};         ///< of the tags
  int first_tag = 0;
  bool operator==(const Wand&) const = default;
};

/// What is printed or built; a Target is what the solver needs to know of it.
using TargetDesign = std::variant<Chessboard, CharucoBoard, AprilTagGrid, TwoSidedBoard, Wand>;

/// Reads a target from one line of words, which is also how it is written on its print:
///   chessboard columns=8 rows=5 square=30mm
///   charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 [first=0] [inverted]
///     [white-first]
///   apriltags columns=6 rows=6 tag=88mm gap=26.4mm [dictionary=apriltag_36h11] [first=0] [border=1]
///   two-sided columns=… rows=… square=… marker=… dictionary=… thickness=5mm [first=0]
///     [back-first=…] [inverted]
///   wand positions=0mm,150mm,450mm ball=25mm        wand positions=0mm,500mm tag=80mm dictionary=… [first=0]
/// Lengths need their unit: mm, cm, m or in. The result has passed check(). BadData says which word is wrong.
Result<TargetDesign> parse_target(std::string_view words);

/// The line that parse_target() reads back to the same target, bit by bit.
std::string to_text(const TargetDesign& target);

/// Reads the target out of a file that holds its line: a print made by write_sheets() (PDF or SVG) or a text
/// file.
Result<TargetDesign> load_target(const std::filesystem::path& file);

/// Sizes positive and printable, dictionary known and large enough, wand positions ascending and tellable
/// apart.
Result<void> check(const TargetDesign& target);

/// Why several cameras may disagree about which point is which: a chessboard that looks the same after half a
/// turn, a wand of two equal balls or with the same distances from both ends. One sentence, or absent.
std::optional<std::string> ambiguity(const TargetDesign& target);

/// Where the points are, in the target's frame, metres; a point's id is its place here.
std::vector<Eigen::Vector3d> target_points(const TargetDesign& design);

/// The same for the solver: points with their normals, the lattice of a board, a wand's lengths with this
/// sigma (metres).
Target make_target(const TargetDesign& design, std::string name, double length_sigma = 1e-4);

/// Names of the marker dictionaries that this build knows.
std::vector<std::string> marker_dictionaries();

}  // namespace floatstage::calib
