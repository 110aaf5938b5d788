// Method:  read markers of every dictionary; the layout on which most of them lie as a plane seen by a
// camera;
//          without markers, the size of whole chessboards that grow from crossings
// Paper:   none
// Differs: –
// ADR:     0230

#include "calib/board_identification.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/board_detection.h"
#include "calib/chessboard_grid.h"
#include "calib/grey.h"
#include "calib/marker_detection.h"
#include "calib/marker_dictionary.h"
#include "calib/saddle.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr std::size_t kLeastMarkers = 3;  // of a picture that counts
constexpr int kMostAcross = 24;           // columns that are tried
constexpr double kUsualMarker = 0.75;     // of a square, until it is measured

// Markers of one dictionary in all pictures.
struct Read {
  const MarkerDictionary* dictionary = nullptr;
  bool inverted = false;
  std::vector<std::vector<SeenMarker>> pictures;
  int highest = -1;
};

// The dictionary that holds all markers of this one's kind: 4x4_50 is the beginning of 4x4_1000.
const MarkerDictionary* largest_like(const MarkerDictionary* d) {
  const MarkerDictionary* best = d;
  const std::string kind = std::string(d->name).substr(0, 4);
  if (kind[1] != 'x') return d;
  for (const MarkerDictionary& other : all_dictionaries())
    if (std::string(other.name).starts_with(kind) && other.markers > best->markers) best = &other;
  return best;
}

const MarkerDictionary* smallest_like(const MarkerDictionary* d, int highest) {
  const MarkerDictionary* best = d;
  const std::string kind = std::string(d->name).substr(0, 4);
  if (kind[1] != 'x') return d;
  for (const MarkerDictionary& other : all_dictionaries())
    if (std::string(other.name).starts_with(kind) && other.markers > highest && other.markers < best->markers)
      best = &other;
  return best;
}

// In which dictionary most markers can be read, with black and white as they are or exchanged.
std::optional<Read> read_markers(const std::vector<cv::Mat>& greys) {
  std::map<std::pair<const MarkerDictionary*, bool>, int> votes;
  for (const cv::Mat& grey : greys)
    for (const bool inverted : {false, true}) {
      const cv::Mat print = inverted ? cv::Mat(255 - grey) : grey;
      const SeenMarkers seen = find_markers(print, "4x4_1000", 1);
      std::vector<std::array<cv::Point2f, 4>> squares = seen.other_squares;
      for (const SeenMarker& m : seen.markers) squares.push_back(m.corners);
      std::vector<int> ids;
      if (const MarkerDictionary* d = dictionary_of(print, squares, kLeastMarkers, &ids))
        votes[{largest_like(d), inverted}] += static_cast<int>(ids.size());
    }
  const auto most = std::max_element(votes.begin(), votes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == votes.end()) return std::nullopt;
  Read out{most->first.first, most->first.second, {}, -1};
  for (const cv::Mat& grey : greys) {
    const cv::Mat print = out.inverted ? cv::Mat(255 - grey) : grey;
    out.pictures.push_back(find_markers(print, out.dictionary->name, 1).markers);
    for (const SeenMarker& m : out.pictures.back()) out.highest = std::max(out.highest, m.id);
  }
  return out;
}

// Markers that lie as on the face, over all pictures, and pictures with enough of them.
struct Agreement {
  std::size_t markers = 0;
  int pictures = 0;
};

Agreement agreement_with(const BoardFace& face, const Read& read) {
  Agreement out;
  for (const std::vector<SeenMarker>& seen : read.pictures) {
    const std::size_t n = consistent_markers(face, seen, kLeastMarkers).size();
    out.markers += n;
    out.pictures += n >= kLeastMarkers;
  }
  return out;
}

// How large a marker is beside a square, from where markers' centres lie: the median, to the nearest
// twentieth. Light bleeds over edges, so no more can be told; only how far corners are kept apart depends on
// it.
double marker_share(const BoardFace& face, const Read& read) {
  std::vector<double> sides;
  for (const std::vector<SeenMarker>& seen : read.pictures) {
    const std::vector<SeenMarker> on = consistent_markers(face, seen, 4);
    std::vector<cv::Point2f> from, to;
    for (const SeenMarker& m : on) {
      const auto at = std::find_if(face.markers.begin(), face.markers.end(),
                                   [&](const FaceMarker& f) { return f.id == m.id; });
      const Eigen::Vector2d middle = (at->corners[0] + at->corners[2]) / 2;
      to.emplace_back(static_cast<float>(middle.x()), static_cast<float>(middle.y()));
      from.push_back((m.corners[0] + m.corners[1] + m.corners[2] + m.corners[3]) * 0.25f);
    }
    if (from.size() < 4) continue;
    const cv::Mat map = cv::findHomography(from, to, 0);
    if (map.empty()) continue;
    for (const SeenMarker& m : on) {
      std::vector<cv::Point2f> corners;
      cv::perspectiveTransform(std::vector<cv::Point2f>(m.corners.begin(), m.corners.end()), corners, map);
      for (std::size_t i = 0; i < 4; ++i) sides.push_back(cv::norm(corners[i] - corners[(i + 1) % 4]));
    }
  }
  if (sides.empty()) return kUsualMarker;
  return std::clamp(std::round(20 * median(std::move(sides))) / 20, 0.3, 0.95);
}

std::optional<IdentifiedBoard> marker_board(const Read& read, double square) {
  std::optional<TargetDesign> best;
  Agreement most;
  const std::string dictionary = read.dictionary->name;
  const auto consider = [&](const TargetDesign& design) {
    const Agreement a = agreement_with(board_faces(design).front(), read);
    if (a.markers > most.markers) most = a, best = design;
  };
  for (int columns = 2; columns <= kMostAcross; ++columns) {
    // As many rows as the highest number needs.
    const int squares = 2 * (read.highest + 1), rows = std::max(2, (squares + columns - 1) / columns);
    for (const bool white_first : {false, true})
      consider(CharucoBoard{columns, rows, 1, kUsualMarker, dictionary, 0, read.inverted, white_first});
    if (dictionary.starts_with("apriltag"))
      consider(AprilTagGrid{columns, (read.highest + columns) / columns, 1, 0.3, dictionary, 0, 1});
  }
  if (!best) return std::nullopt;
  const std::string name = smallest_like(read.dictionary, read.highest)->name;
  if (auto* charuco = std::get_if<CharucoBoard>(&*best)) {
    const double share = marker_share(board_faces(*best).front(), read);
    charuco->marker = std::round(1e5 * share * square) / 1e5;
    charuco->square = square;
    charuco->dictionary = name;
  } else if (auto* tags = std::get_if<AprilTagGrid>(&*best)) {
    tags->tag = square;
    tags->gap = 0.3 * square;
    tags->dictionary = name;
  }
  return IdentifiedBoard{
      *best, most.pictures,
      text("markers of ", name, " up to number ", read.highest, ", ", most.markers,
           " of them as on this board", read.inverted ? ", black and white exchanged" : "")};
}

std::optional<IdentifiedBoard> chessboard(const std::vector<cv::Mat>& greys, double square) {
  constexpr double kSize = 960;  // px, as detection begins
  constexpr std::size_t kCrossings = 1000;
  constexpr int kLeast = 3;  // crossings across: fewer are anywhere
  std::map<std::pair<int, int>, int> votes;
  for (const cv::Mat& grey : greys) {
    cv::Mat small = grey;
    if (const double scale = kSize / std::max(grey.cols, grey.rows); scale < 1)
      cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
    const ChessboardGrid grid = grow_chessboard(find_saddles(small, kCrossings), kCrossings);
    const auto [low, high] = std::minmax(grid.columns, grid.rows);
    if (grid.full() && low >= kLeast) ++votes[{low, high}];
  }
  const auto most = std::max_element(votes.begin(), votes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == votes.end()) return std::nullopt;
  const auto [low, high] = most->first;
  return IdentifiedBoard{Chessboard{low + 1, high + 1, square}, most->second,
                         text("a whole grid of ", low, " by ", high, " crossings without markers")};
}

}  // namespace

std::optional<IdentifiedBoard> identify_board(std::span<const Image> pictures, double square) {
  std::vector<cv::Mat> greys;
  for (const Image& p : pictures) greys.push_back(grey_of(p));
  const int least = pictures.size() > 1 ? 2 : 1;
  if (const std::optional<Read> read = read_markers(greys))
    if (std::optional<IdentifiedBoard> board = marker_board(*read, square); board && board->pictures >= least)
      return board;
  std::optional<IdentifiedBoard> board = chessboard(greys, square);
  if (board && board->pictures >= least) return board;
  return std::nullopt;
}

}  // namespace floatstage::calib
