#include "calib/board_detection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include <opencv2/imgproc.hpp>

#include "calib/grey.h"

namespace floatstage::calib {
namespace {

// A picture that was made smaller, and the way back.
struct Level {
  cv::Mat grey;
  float scale = 1;
  cv::Point2f full(cv::Point2f p) const {
    const float shift = (1 / scale - 1) / 2;
    return p * (1 / scale) + cv::Point2f(shift, shift);
  }
};

Level reduced(const cv::Mat& grey, double scale) {
  Level level{grey, 1};
  if (scale >= 1) return level;
  cv::resize(grey, level.grey, {}, scale, scale, cv::INTER_AREA);
  level.scale = static_cast<float>(scale);
  return level;
}

// How the grid's (column, row) in the picture becomes the board's corner: a quarter turn, then counted from
// the upper left.
struct Turn {
  int quarter;
  std::pair<int, int> corner(int column, int row, int columns, int rows) const {
    switch (quarter) {
      case 0:
        return {column, row};
      case 1:
        return {row, columns - 1 - column};
      case 2:
        return {columns - 1 - column, rows - 1 - row};
      default:
        return {rows - 1 - row, column};
    }
  }
};

// Whether the square right of and below the grid's corner (0, 0) is dark: its colour is that of every second
// square.
bool first_square_is_dark(const cv::Mat& grey, const ChessboardGrid& grid) {
  std::array<double, 2> sum = {0, 0}, count = {0, 0};
  for (const auto& [place, at] : grid.corners) {
    const auto [c, r] = place;
    const auto right = grid.corners.find({c + 1, r}), below = grid.corners.find({c, r + 1}),
               over = grid.corners.find({c + 1, r + 1});
    if (right == grid.corners.end() || below == grid.corners.end() || over == grid.corners.end()) continue;
    const cv::Point2f middle = (at + right->second + below->second + over->second) * 0.25f;
    sum[static_cast<std::size_t>(c + r) % 2] += static_cast<double>(grey_at(grey, middle.x, middle.y));
    ++count[static_cast<std::size_t>(c + r) % 2];
  }
  return sum[0] / std::max(count[0], 1.0) < sum[1] / std::max(count[1], 1.0);
}

// The board's corners out of a grid that is all there; empty when the sizes differ.
std::vector<FoundPoint> number_corners(const cv::Mat& grey, const ChessboardGrid& grid,
                                       const Chessboard& board) {
  const int columns = board.columns - 1, rows = board.rows - 1;
  std::vector<FoundPoint> points;
  if (!grid.full()) return points;
  const bool first_is_dark = first_square_is_dark(grey, grid);
  std::optional<Turn> best;
  double least = 0;
  for (int quarter = 0; quarter < 4; ++quarter) {
    if ((quarter % 2 == 0 ? grid.columns : grid.rows) != columns ||
        (quarter % 2 == 0 ? grid.rows : grid.columns) != rows)
      continue;
    const Turn turn{quarter};
    // The grid's first square has this corner of the board at its upper left; there, even ones are dark.
    const std::array<int, 4> corner = {0, grid.columns, grid.columns + grid.rows, grid.rows};
    if (first_is_dark != (corner[static_cast<std::size_t>(quarter)] % 2 == 0)) continue;
    // Of the turns that the colours allow, the most upright one: id 0 nearest to the picture's upper left.
    for (const auto& [place, at] : grid.corners) {
      if (turn.corner(place.first, place.second, grid.columns, grid.rows) != std::pair{0, 0}) continue;
      const double distance = at.x + at.y;
      if (!best || distance < least) best = turn, least = distance;
    }
  }
  if (!best) return points;
  for (const auto& [place, at] : grid.corners) {
    const auto [c, r] = best->corner(place.first, place.second, grid.columns, grid.rows);
    points.push_back({r * columns + c, at});
  }
  std::sort(points.begin(), points.end(),
            [](const FoundPoint& a, const FoundPoint& b) { return a.id < b.id; });
  return points;
}

// Rows or columns too many (a shadow, a tile beside the board): the one full part of the right size, when
// there is one.
ChessboardGrid trimmed(const ChessboardGrid& grid, int columns, int rows) {
  ChessboardGrid part;
  int parts = 0;
  for (const auto& [w, h] : std::set<std::pair<int, int>>{{columns, rows}, {rows, columns}}) {
    for (int r0 = 0; r0 + h <= grid.rows; ++r0) {
      for (int c0 = 0; c0 + w <= grid.columns; ++c0) {
        ChessboardGrid candidate;
        candidate.columns = w, candidate.rows = h;
        for (int r = 0; r < h; ++r)
          for (int c = 0; c < w; ++c)
            if (const auto at = grid.corners.find({c0 + c, r0 + r}); at != grid.corners.end())
              candidate.corners[{c, r}] = at->second;
        if (!candidate.full()) continue;
        ++parts;
        part = std::move(candidate);
      }
    }
  }
  return parts == 1 ? part : ChessboardGrid{};
}

// Every corner refined in the full picture, in windows that stay clear of the neighbours; empty when one is
// lost.
std::vector<FoundPoint> refined(const cv::Mat& grey, const ChessboardGrid& grid,
                                const std::vector<FoundPoint>& points) {
  float nearest = 1e9f;
  for (const auto& [place, at] : grid.corners)
    for (const std::pair<int, int>& next :
         {std::pair{place.first + 1, place.second}, {place.first, place.second + 1}})
      if (const auto other = grid.corners.find(next); other != grid.corners.end())
        nearest = std::min(nearest, std::hypot(other->second.x - at.x, other->second.y - at.y));
  const float radius = std::clamp(0.4f * nearest, 3.0f, 12.0f);
  std::vector<FoundPoint> exact;
  for (const FoundPoint& p : points) {
    std::optional<cv::Point2f> at = refine_saddle(grey, p.at, radius);
    // A start from a reduced picture may lie too far off for a window this narrow, or the squares bend in one
    // this wide.
    for (const float scale : {0.6f, 1.6f})
      if (!at) at = refine_saddle(grey, p.at, std::max(3.0f, scale * radius));
    if (!at) return {};
    exact.push_back({p.id, *at});
  }
  return exact;
}

}  // namespace

BoardSearch find_chessboard(const cv::Mat& grey, const Chessboard& board, Effort effort) {
  constexpr double kQuickSize =
      960;  // px: crossings of boards that fill a third of the picture are far apart at this size
  const double first = std::min(1.0, kQuickSize / std::max(grey.cols, grey.rows));
  const std::size_t wanted = static_cast<std::size_t>(board.columns - 1) * (board.rows - 1);
  std::vector<double> scales = {first};
  if (effort == Effort::Full) {
    if (first < 1) scales.push_back(1);
    scales.push_back(first / 2);
  }
  BoardSearch best;
  for (const double scale : scales) {
    const Level level = reduced(grey, scale);
    ChessboardGrid grid =
        grow_chessboard(find_saddles(level.grey, std::max<std::size_t>(500, 4 * wanted)), wanted);
    for (auto& [place, at] : grid.corners) at = level.full(at);
    if (grid.corners.size() > wanted || (!grid.full() && grid.corners.size() >= wanted)) {
      const ChessboardGrid part = trimmed(grid, board.columns - 1, board.rows - 1);
      if (part.full()) grid = part;
    }
    if (grid.corners.size() > best.grid.corners.size()) best.grid = grid;
    best.points = refined(grey, grid, number_corners(grey, grid, board));
    if (!best.points.empty()) {
      best.grid = std::move(grid);
      break;
    }
  }
  return best;
}

BoardSearch find_on_faces(const cv::Mat& grey, const std::vector<BoardFace>& faces, Effort effort) {
  BoardSearch search;
  if (faces.empty()) return search;
  const BoardFace& first = faces.front();
  const std::size_t most = first.markers.size();
  const std::size_t least = most > 1 && first.dictionary.find("apriltag_3") == std::string::npos ? 2 : 1;
  auto choose = [&] {
    const BoardFace* chosen = nullptr;
    search.consistent.clear();
    for (const BoardFace& face : faces) {
      std::vector<SeenMarker> agree = consistent_markers(face, search.seen.markers, least);
      if (agree.size() > search.consistent.size()) search.consistent = std::move(agree), chosen = &face;
    }
    return chosen;
  };
  auto add = [&](SeenMarkers more) {
    for (SeenMarker& m : more.markers)
      if (std::none_of(search.seen.markers.begin(), search.seen.markers.end(),
                       [&](const SeenMarker& s) { return s.id == m.id; }))
        search.seen.markers.push_back(m);
    search.seen.other_squares.insert(search.seen.other_squares.end(), more.other_squares.begin(),
                                     more.other_squares.end());
  };
  // The corners of a tag grid's tags touch black squares; a narrow window keeps what is taken from them
  // apart.
  const int apart = first.square > 0 || first.black.empty() ? 0 : 1;
  search.seen =
      find_markers(grey, first.dictionary, first.border, {.windows = {apart > 0 ? 5 : 13}, .apart = apart});
  const BoardFace* face = choose();
  if (effort == Effort::Full && search.consistent.size() < most) {
    // Something is there: look closer. Nothing: once more where blur matters less.
    if (search.consistent.size() * 2 < most && (face || !search.seen.markers.empty()))
      add(find_markers(grey, first.dictionary, first.border,
                       {.windows = {apart > 0 ? 9 : 5, 29}, .apart = apart}));
    else if (!face)
      add(find_markers(grey, first.dictionary, first.border,
                       {.windows = {apart > 0 ? 5 : 11}, .scale = 0.5, .apart = apart}));
    face = choose();
  }
  if (face) search.points = points_near_markers(grey, *face, search.consistent);
  return search;
}

BoardSearch find_board(const cv::Mat& grey, const TargetDesign& design, Effort effort) {
  if (const auto* chessboard = std::get_if<Chessboard>(&design))
    return find_chessboard(grey, *chessboard, effort);
  const std::vector<BoardFace> faces = board_faces(design);
  if (faces.empty() || !faces.front().inverted) return find_on_faces(grey, faces, effort);
  return find_on_faces(255 - grey, faces, effort);
}

}  // namespace floatstage::calib
