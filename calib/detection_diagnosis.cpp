#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "calib/board_detection.h"
#include "calib/grey.h"
#include "calib/marker_dictionary.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

Detection because(DetectionFailure failure, std::string reason) { return {{}, failure, std::move(reason)}; }

// Grey levels between the darkest and the brightest hundredth of the picture.
int contrast(const cv::Mat& grey) {
  std::array<int, 256> counts{};
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) ++counts[grey.at<std::uint8_t>(y, x)];
  const double share = 0.01 * static_cast<double>(grey.total());
  int low = 0, high = 255;
  for (double sum = 0; low < 255 && (sum += counts[static_cast<std::size_t>(low)]) < share;) ++low;
  for (double sum = 0; high > 0 && (sum += counts[static_cast<std::size_t>(high)]) < share;) --high;
  return std::max(high - low, 0);
}

// How wide the sharpest edges are, in px: their height over the steepest slope. 1 is as sharp as pixels can
// be.
double edge_width(const cv::Mat& grey) {
  cv::Mat dx, dy, low, high;
  cv::Sobel(grey, dx, CV_16S, 1, 0);
  cv::Sobel(grey, dy, CV_16S, 0, 1);
  cv::erode(grey, low, cv::Mat::ones(15, 15, CV_8U));
  cv::dilate(grey, high, cv::Mat::ones(15, 15, CV_8U));
  std::vector<float> widths;
  for (int y = 8; y < grey.rows - 8; y += 2) {
    for (int x = 8; x < grey.cols - 8; x += 2) {
      const int height = high.at<std::uint8_t>(y, x) - low.at<std::uint8_t>(y, x);
      if (height < 40) continue;
      const float slope =
          std::hypot(static_cast<float>(dx.at<short>(y, x)), static_cast<float>(dy.at<short>(y, x))) / 8;
      widths.push_back(static_cast<float>(height) / std::max(slope, 0.5f));
    }
  }
  if (widths.size() < 200) return 0;  // hardly an edge anywhere: not a question of sharpness
  return percentile(std::move(widths), 0.02);
}

bool near_rim(const cv::Mat& grey, cv::Point2f p, float distance) {
  return p.x < distance || p.y < distance || p.x > static_cast<float>(grey.cols) - 1 - distance ||
         p.y > static_cast<float>(grey.rows) - 1 - distance;
}

bool enough(const BoardSearch& search, int least_points) {
  return static_cast<int>(search.points.size()) >= least_points;
}

// Part of the target is there: at the picture's rim, or covered.
Detection partly(bool at_rim, const std::string& what) {
  if (at_rim)
    return because(DetectionFailure::CutOff,
                   text(what, " at the picture's rim: the target is cut off; keep more of it in view"));
  return because(
      DetectionFailure::PartlyHidden,
      text(what, ": the rest is hidden, too small or too oblique; show more of the target, nearer"));
}

std::optional<TargetDesign> swapped(const TargetDesign& design) {
  if (auto b = std::get_if<CharucoBoard>(&design)) {
    CharucoBoard other = *b;
    std::swap(other.columns, other.rows);
    return TargetDesign(other);
  }
  if (auto g = std::get_if<AprilTagGrid>(&design)) {
    AprilTagGrid other = *g;
    std::swap(other.columns, other.rows);
    return TargetDesign(other);
  }
  if (auto t = std::get_if<TwoSidedBoard>(&design)) {
    TwoSidedBoard other = *t;
    std::swap(other.front.columns, other.front.rows);
    return TargetDesign(other);
  }
  return std::nullopt;
}

std::string numbers(const std::vector<int>& ids) {
  std::string list;
  for (std::size_t i = 0; i < ids.size() && i < 6; ++i) list += text(list.empty() ? "" : ", ", ids[i]);
  return ids.size() > 6 ? list + ", …" : list;
}

std::optional<Detection> diagnose_markers(const cv::Mat& grey, const TargetDesign& design,
                                          const BoardSearch& found, int least_points) {
  const std::vector<BoardFace> faces = board_faces(design);
  const BoardFace& first = faces.front();
  const cv::Mat print = first.inverted ? cv::Mat(255 - grey) : grey;
  if (const std::optional<TargetDesign> other = swapped(design); other && found.seen.markers.size() >= 3) {
    std::size_t agree = 0;
    for (const BoardFace& face : board_faces(*other))
      agree = std::max(agree, consistent_markers(face, found.seen.markers, 3).size());
    if (agree >= 3 && agree > found.consistent.size())
      return because(DetectionFailure::SwappedRowsAndColumns,
                     text("its markers lie as on a board with columns and rows exchanged; write columns=… "
                          "rows=… the other way round"));
  }
  if (!found.consistent.empty()) {
    bool rim = false;
    for (const SeenMarker& m : found.consistent)
      for (const cv::Point2f& c : m.corners) rim |= near_rim(grey, c, 1.2f * m.side());
    return partly(rim, text(found.consistent.size(), " of ", first.markers.size(), " markers were found"));
  }
  std::vector<int> others;
  for (const SeenMarker& m : found.seen.markers) {
    bool ours = false;
    for (const BoardFace& face : faces)
      for (const FaceMarker& f : face.markers) ours |= f.id == m.id;
    if (!ours) others.push_back(m.id);
  }
  if (others.size() >= 3)
    return because(
        DetectionFailure::OtherNumbers,
        text("markers ", numbers(others), " of ", first.dictionary,
             " are in the picture, which this target does not have; is it another board, or 'first' wrong?"));
  std::vector<BoardFace> negative = faces;
  for (BoardFace& face : negative) face.inverted = !face.inverted;
  if (enough(find_on_faces(255 - print, negative, Effort::Quick), least_points))
    return because(DetectionFailure::InvertedPrint,
                   first.inverted
                       ? "the print is not inverted: leave the word 'inverted' out"
                       : "the print is inverted, black and white exchanged: add the word 'inverted'");
  cv::Mat mirrored;
  cv::flip(print, mirrored, 1);
  if (enough(find_on_faces(mirrored, faces, Effort::Quick), least_points))
    return because(
        DetectionFailure::MirroredPrint,
        "the picture or the print is mirrored; turn off mirroring in the camera, or print the target anew");
  std::vector<int> ids;
  if (const MarkerDictionary* other = dictionary_of(print, found.seen.other_squares, 3, &ids);
      other && other->name != first.dictionary)
    return because(
        DetectionFailure::WrongDictionary,
        text("markers ", numbers(ids), " of dictionary ", other->name, " are in the picture, not of ",
             first.dictionary, "; write dictionary=", other->name));
  if (others.empty() && !found.seen.markers.empty())
    return partly(near_rim(grey, found.seen.markers[0].corners[0], 2 * found.seen.markers[0].side()),
                  "one marker was found");
  return std::nullopt;
}

// Whether the board ends with one more row of squares outside this side's corners: dark and light alternate
// there, and beyond lies paper. `corner(i, 0)` runs along the side, `corner(i, 1)` one step further in.
template <class Corner>
bool ends_here(const cv::Mat& grey, int count, const Corner& corner) {
  std::array<double, 2> outer = {0, 0}, number = {0, 0};
  double darkest_beyond = 255;
  for (int i = 0; i + 1 < count; ++i) {
    const cv::Point2f edge = (corner(i, 0) + corner(i + 1, 0)) * 0.5f,
                      out = edge - (corner(i, 1) + corner(i + 1, 1)) * 0.5f;
    const cv::Point2f square = edge + out * 0.5f, beyond = edge + out * 1.15f;
    if (near_rim(grey, beyond, 1)) return false;
    outer[static_cast<std::size_t>(i % 2)] += grey_at(grey, square.x, square.y);
    ++number[static_cast<std::size_t>(i % 2)];
    darkest_beyond = std::min(darkest_beyond, static_cast<double>(grey_at(grey, beyond.x, beyond.y)));
  }
  const double a = outer[0] / std::max(number[0], 1.0), b = outer[1] / std::max(number[1], 1.0);
  return std::abs(a - b) > 25 && darkest_beyond > (a + b) / 2;
}

bool is_whole(const cv::Mat& grey, const ChessboardGrid& g) {
  if (!g.full() || g.columns < 3 || g.rows < 3) return false;
  auto at = [&](int c, int r) { return g.corners.at({c, r}); };
  return ends_here(grey, g.columns, [&](int i, int in) { return at(i, in); }) &&
         ends_here(grey, g.columns, [&](int i, int in) { return at(i, g.rows - 1 - in); }) &&
         ends_here(grey, g.rows, [&](int i, int in) { return at(in, i); }) &&
         ends_here(grey, g.rows, [&](int i, int in) { return at(g.columns - 1 - in, i); });
}

std::optional<Detection> diagnose_chessboard(const cv::Mat& grey, const Chessboard& board,
                                             const BoardSearch& found) {
  const ChessboardGrid& grid = found.grid;
  if (grid.corners.size() < 6) return std::nullopt;
  const int longer = std::max(board.columns, board.rows) - 1,
            shorter = std::min(board.columns, board.rows) - 1;
  const int wide = std::max(grid.columns, grid.rows), narrow = std::min(grid.columns, grid.rows);
  const std::string size = text(grid.columns + 1, " by ", grid.rows + 1, " squares");
  if (grid.full() && wide == longer + 2 && narrow == shorter + 2)
    return because(DetectionFailure::WrongCount,
                   text("a chessboard of ", size,
                        " is in the picture; columns and rows count squares, not inner corners"));
  if (is_whole(grey, grid) || (grid.full() && (wide > longer || narrow > shorter)))
    return because(
        DetectionFailure::WrongCount,
        text("a chessboard of ", size, " is in the picture, not one of ", board.columns, " by ", board.rows));
  float step = 1e9f;
  bool rim = false;
  for (const auto& [place, at] : grid.corners)
    if (const auto next = grid.corners.find({place.first + 1, place.second}); next != grid.corners.end())
      step = std::min(step, std::hypot(next->second.x - at.x, next->second.y - at.y));
  for (const auto& [place, at] : grid.corners) rim |= near_rim(grey, at, 1.5f * step);
  return partly(rim, text("only ", size, " of a chessboard were found"));
}

}  // namespace

Detection diagnose(const cv::Mat& grey, const TargetDesign& design, const BoardSearch& found,
                   int least_points) {
  const int levels = contrast(grey);
  if (levels < 25)
    return because(
        DetectionFailure::TooDark,
        text("the picture has only ", levels,
             " grey levels between its dark and bright parts; give it light, or close the aperture"));
  const Wand* wand = std::get_if<Wand>(&design);
  if (wand) {
    if (wand->ball > 0)
      return because(DetectionFailure::NothingLikeIt,
                     "no bright round spots lie as on the wand; darken the room, or shorten the exposure");
    if (!found.consistent.empty())
      return partly(false, text(found.consistent.size(), " of ", wand->positions.size(), " tags were found"));
  }
  const auto* chessboard = std::get_if<Chessboard>(&design);
  if (!wand && !chessboard) {
    if (std::optional<Detection> d = diagnose_markers(grey, design, found, least_points)) return *d;
  }
  if (!wand) {
    for (const double scale : {0.5, 0.25}) {
      cv::Mat smaller;
      cv::resize(grey, smaller, {}, scale, scale, cv::INTER_AREA);
      if (enough(find_board(smaller, design, Effort::Quick), least_points))
        return because(
            DetectionFailure::Blurred,
            text("found only at ", scale,
                 " of the resolution: the picture is blurred; hold the target still, focus, expose shorter"));
    }
  }
  if (chessboard) {
    if (std::optional<Detection> d = diagnose_chessboard(grey, *chessboard, found)) return *d;
  }
  if (const double width = edge_width(grey); width > 6)
    return because(DetectionFailure::Blurred,
                   text("the sharpest edges are ", std::lround(width),
                        " px wide: the picture is blurred; focus, or expose shorter"));
  return because(DetectionFailure::NothingLikeIt, "nothing in the picture resembles the target");
}

}  // namespace floatstage::calib
