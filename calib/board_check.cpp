#include <algorithm>
#include <cmath>

#include "calib/board.h"
#include "calib/marker_dictionary.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr int kMostAcross = 200;
constexpr double kLargest = 20;  // metres: no wall is larger

Result<void> fits(const char* what, double metres) {
  if (std::isfinite(metres) && metres >= 1e-4 && metres <= kLargest) return {};
  return fail(ErrorCode::InvalidArgument,
              text(what, " of ", metres * 1000, " mm; it must be between 0.1 mm and 20 m"));
}

Result<void> across(int columns, int rows, int least) {
  if (columns >= least && rows >= least && columns <= kMostAcross && rows <= kMostAcross) return {};
  return fail(ErrorCode::InvalidArgument,
              text(columns, " columns and ", rows, " rows; each must be ", least, " to ", kMostAcross,
                   " (squares are counted, not inner corners)"));
}

Result<void> holds(const std::string& dictionary, int first, int count) {
  const MarkerDictionary* d = find_dictionary(dictionary);
  if (!d)
    return fail(ErrorCode::InvalidArgument, text("dictionary '", dictionary,
                                                 "' is not known; known are 4x4_50 … 7x7_1000, "
                                                 "aruco_original, apriltag_16h5, _25h9, _36h10, _36h11"));
  if (first < 0 || first > d->markers - count)
    return fail(ErrorCode::InvalidArgument, text(count, " markers from number ", first, " on, but ", d->name,
                                                 " has ", d->markers, "; take a larger dictionary"));
  return {};
}

Result<void> sound(const Chessboard& b) {
  if (Result<void> ok = across(b.columns, b.rows, 3); !ok) return ok;
  return fits("a square", b.square);
}

Result<void> sound(const CharucoBoard& b, int first) {
  if (Result<void> ok = across(b.columns, b.rows, 3); !ok) return ok;
  if (Result<void> ok = fits("a square", b.square); !ok) return ok;
  if (Result<void> ok = fits("a marker", b.marker); !ok) return ok;
  // OpenCV's reader needs a quiet zone of most of a cell around a marker.
  if (b.marker > 0.95 * b.square)
    return fail(ErrorCode::InvalidArgument,
                text("a marker of ", b.marker * 1000, " mm does not fit into a square of ", b.square * 1000,
                     " mm with white around it; 0.75 of the square is good"));
  const int all = b.columns * b.rows;
  return holds(b.dictionary, first, b.white_first ? (all + 1) / 2 : all / 2);
}
Result<void> sound(const CharucoBoard& b) { return sound(b, b.first_marker); }

Result<void> sound(const TwoSidedBoard& b) {
  if (Result<void> ok = sound(b.front, b.front.first_marker); !ok) return ok;
  if (Result<void> ok = sound(b.front, b.back_first_marker); !ok) return ok;
  if (!(b.thickness >= 0 && b.thickness <= 1))
    return fail(ErrorCode::InvalidArgument,
                text("a thickness of ", b.thickness * 1000, " mm; it must be between 0 and 1 m"));
  const int all = b.front.columns * b.front.rows, markers = b.front.white_first ? (all + 1) / 2 : all / 2;
  if (std::abs(b.back_first_marker - b.front.first_marker) < markers)
    return fail(ErrorCode::InvalidArgument,
                text("front and back share markers: the front has ", b.front.first_marker, " to ",
                     b.front.first_marker + markers - 1, " and the back begins at ", b.back_first_marker));
  return {};
}

Result<void> sound(const AprilTagGrid& g) {
  if (Result<void> ok = across(g.columns, g.rows, 1); !ok) return ok;
  if (Result<void> ok = fits("a tag", g.tag); !ok) return ok;
  if (Result<void> ok = fits("a gap", g.gap); !ok) return ok;
  if (g.border < 1 || g.border > 3)
    return fail(ErrorCode::InvalidArgument, text("a border of ", g.border, " cells; it must be 1 to 3"));
  return holds(g.dictionary, g.first_tag, g.columns * g.rows);
}

Result<void> sound(const Wand& w) {
  if (w.positions.size() < 2 || w.positions.size() > 3 || w.positions.front() != 0)
    return fail(ErrorCode::InvalidArgument, "a wand has two or three positions, the first is 0mm");
  const double size = w.ball > 0 ? w.ball : w.tag;
  if (Result<void> ok = fits(w.ball > 0 ? "a ball" : "a tag", size); !ok) return ok;
  for (std::size_t i = 1; i < w.positions.size(); ++i) {
    if (Result<void> ok = fits("a position", w.positions[i]); !ok) return ok;
    if (!(w.positions[i] - w.positions[i - 1] > size))
      return fail(ErrorCode::InvalidArgument, text("positions must ascend by more than the ", size * 1000,
                                                   " mm that one ", w.ball > 0 ? "ball" : "tag", " takes"));
  }
  if (w.ball > 0) return {};
  return holds(w.dictionary, w.first_tag, static_cast<int>(w.positions.size()));
}

}  // namespace

Result<void> check(const TargetDesign& target) {
  return std::visit([](const auto& t) { return sound(t); }, target);
}

std::optional<std::string> ambiguity(const TargetDesign& target) {
  if (const auto* b = std::get_if<Chessboard>(&target)) {
    if ((b->columns + b->rows) % 2 == 1) return std::nullopt;
    return text("a chessboard of ", b->columns, " by ", b->rows,
                " squares looks the same after half a turn: cameras may "
                "number its corners differently; use one odd and one even number, or a ChArUco board");
  }
  const auto* w = std::get_if<Wand>(&target);
  if (!w || w->ball <= 0) return std::nullopt;
  if (w->positions.size() == 2)
    return "two equal balls look the same from both ends; three balls at unequal distances tell which is "
           "which";
  const double a = w->positions[1], b = w->positions[2] - w->positions[1];
  if (std::max(a, b) < 1.25 * std::min(a, b))
    return text("the middle ball is nearly half way (", a * 1000, " and ", b * 1000,
                " mm): which end is which cannot be told; "
                "make one distance at least a quarter longer");
  return std::nullopt;
}

}  // namespace floatstage::calib
