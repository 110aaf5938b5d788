#include "calib/marker_detection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/marker_dictionary.h"
#include "calib/saddle.h"
#include "core/check.h"

namespace floatstage::calib {
namespace {

using Quad = std::array<cv::Point2f, 4>;

cv::Point2f on_face(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

const FaceMarker* face_marker(const BoardFace& face, int id) {
  for (const FaceMarker& m : face.markers)
    if (m.id == id) return &m;
  return nullptr;
}

std::vector<cv::Point2f> map_points(const cv::Mat& picture_from_face,
                                    const std::vector<cv::Point2f>& points) {
  std::vector<cv::Point2f> mapped;
  cv::perspectiveTransform(points, mapped, picture_from_face);
  return mapped;
}

// The cells of a square, 1 where light; its border is left to the caller.
cv::Mat read_cells(const cv::Mat& grey, const Quad& square, int across) {
  constexpr int kCell = 8;  // px a cell in the rectified square
  const float size = static_cast<float>(kCell * across) - 1;
  const Quad target = {cv::Point2f(0, 0), {size, 0}, {size, size}, {0, size}};
  cv::Mat flat, light;
  cv::warpPerspective(grey, flat, cv::getPerspectiveTransform(square.data(), target.data()),
                      {kCell * across, kCell * across});
  cv::threshold(flat, light, 128, 1, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::Mat cells(across, across, CV_8U);
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x)
      cells.at<std::uint8_t>(y, x) =
          2 * cv::countNonZero(light({x * kCell + 2, y * kCell + 2, kCell - 4, kCell - 4})) >
          (kCell - 4) * (kCell - 4);
  return cells;
}

// A square that was found in a picture with less dark: grown back, its marker read in the true picture.
std::optional<SeenMarker> read_shrunk(const cv::Mat& grey, Quad square, float shrunk,
                                      const MarkerDictionary& kind, int border) {
  const cv::Point2f middle = (square[0] + square[1] + square[2] + square[3]) * 0.25f;
  for (cv::Point2f& c : square) {
    const cv::Point2f out = c - middle;
    c += out * (1.6f * shrunk / std::max(std::hypot(out.x, out.y), 1.0f));
  }
  const cv::Mat cells = read_cells(grey, square, kind.cells + 2 * border);
  const cv::Mat inner = cells({border, border, kind.cells, kind.cells});
  if (cv::countNonZero(cells) - cv::countNonZero(inner) > kind.cells / 2)
    return std::nullopt;  // the border is not black
  SeenMarker marker;
  int turned = 0;
  if (!cv::aruco::getPredefinedDictionary(kind.opencv)->identify(inner, marker.id, turned, 0.6))
    return std::nullopt;
  std::rotate(square.begin(), square.begin() + (4 - turned) % 4, square.end());
  marker.corners = square;
  return marker;
}

// One marker's own map: what a lens bends is straight over one marker.
cv::Mat marker_map(const FaceMarker& on, const SeenMarker& seen) {
  std::vector<cv::Point2f> from;
  for (const Eigen::Vector2d& c : on.corners) from.push_back(on_face(c));
  return cv::getPerspectiveTransform(from,
                                     std::vector<cv::Point2f>(seen.corners.begin(), seen.corners.end()));
}

}  // namespace

float SeenMarker::side() const {
  float sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f d = corners[(i + 1) % 4] - corners[i];
    sum += std::hypot(d.x, d.y);
  }
  return sum / 4;
}

float SeenMarker::short_diagonal() const {
  const cv::Point2f a = corners[2] - corners[0], b = corners[3] - corners[1];
  return std::min(std::hypot(a.x, a.y), std::hypot(b.x, b.y));
}

SeenMarkers find_markers(const cv::Mat& grey, const std::string& dictionary, int border,
                         const MarkerSearch& how) {
  const double scale = how.scale;
  const MarkerDictionary* kind = find_dictionary(dictionary);
  FLOATSTAGE_CHECK(kind, "dictionary '" + dictionary + "' was not checked");
  SeenMarkers found;
  if (grey.cols * scale < 32 || grey.rows * scale < 32) return found;
  cv::Mat searched = grey;
  if (scale < 1) cv::resize(grey, searched, {}, scale, scale, cv::INTER_AREA);
  if (how.apart > 0) {
    cv::Mat lighter;  // `searched` may be the caller's picture
    cv::dilate(searched, lighter, cv::Mat::ones(2 * how.apart + 1, 2 * how.apart + 1, CV_8U));
    searched = lighter;
  }
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border;
  parameters->minMarkerPerimeterRate = 0.02;
  std::map<int, int> seen;  // how often each id
  for (const int window : how.windows) {
    parameters->adaptiveThreshWinSizeMin = parameters->adaptiveThreshWinSizeMax = window;
    std::vector<std::vector<cv::Point2f>> quads, rejected;
    std::vector<int> ids;
    cv::aruco::detectMarkers(searched, cv::aruco::getPredefinedDictionary(kind->opencv), quads, ids,
                             parameters, rejected);
    auto full = [&](const std::vector<cv::Point2f>& quad) {
      Quad q;
      const float shift = static_cast<float>((1 / scale - 1) / 2);
      for (std::size_t i = 0; i < 4; ++i) q[i] = quad[i] * (1 / scale) + cv::Point2f(shift, shift);
      return q;
    };
    std::vector<SeenMarker> read;
    if (how.apart > 0) {
      quads.insert(quads.end(), rejected.begin(), rejected.end());
      for (const auto& quad : quads) {
        const Quad square = full(quad);
        if (std::optional<SeenMarker> m =
                read_shrunk(grey, square, static_cast<float>(how.apart / scale), *kind, border))
          read.push_back(*m);
        else
          found.other_squares.push_back(square);
      }
    } else {
      for (std::size_t i = 0; i < quads.size(); ++i) read.push_back({ids[i], full(quads[i])});
      for (const auto& quad : rejected) found.other_squares.push_back(full(quad));
    }
    std::set<int> now;
    for (const SeenMarker& m : read) {
      const auto [at, fresh] = seen.emplace(m.id, 0);
      if (!now.insert(m.id).second)
        at->second = 2;  // twice in one picture: neither can be trusted
      else if (fresh)
        found.markers.push_back(m);
    }
  }
  std::erase_if(found.markers, [&](const SeenMarker& m) { return seen[m.id] > 1; });
  std::sort(found.markers.begin(), found.markers.end(),
            [](const SeenMarker& a, const SeenMarker& b) { return a.id < b.id; });
  return found;
}

std::vector<SeenMarker> consistent_markers(const BoardFace& face, const std::vector<SeenMarker>& seen,
                                           std::size_t least) {
  std::vector<SeenMarker> on;
  for (const SeenMarker& m : seen)
    if (face_marker(face, m.id)) on.push_back(m);
  // Each marker's own map tells where the others should be; the one that most agree with leads.
  std::vector<SeenMarker> best;
  for (const SeenMarker& leader : on) {
    const cv::Mat map = marker_map(*face_marker(face, leader.id), leader);
    std::vector<SeenMarker> agree;
    for (const SeenMarker& m : on) {
      const FaceMarker& at = *face_marker(face, m.id);
      std::vector<cv::Point2f> corners;
      for (const Eigen::Vector2d& c : at.corners) corners.push_back(on_face(c));
      const std::vector<cv::Point2f> expected = map_points(map, corners);
      // A map from one small square is shaky far away: the slack grows with the distance in markers.
      const double apart = (at.corners[0] - face_marker(face, leader.id)->corners[0]).norm() /
                           (at.corners[1] - at.corners[0]).norm();
      const double slack = (0.15 + 0.12 * apart) * std::max(m.side(), 4.0f);
      double off = 0;
      for (std::size_t i = 0; i < 4; ++i)
        off = std::max(off, static_cast<double>(
                                std::hypot(expected[i].x - m.corners[i].x, expected[i].y - m.corners[i].y)));
      if (off <= slack) agree.push_back(m);
    }
    if (agree.size() > best.size()) best = std::move(agree);
  }
  // A map that explains only the smaller part of what was read is an accident: another layout, or another
  // board.
  if (best.size() < least || 5 * best.size() < 3 * on.size()) best.clear();
  return best;
}

std::vector<FoundPoint> points_near_markers(const cv::Mat& grey, const BoardFace& face,
                                            const std::vector<SeenMarker>& markers) {
  std::vector<FoundPoint> found;
  if (markers.empty()) return found;
  const double side = (face.markers[0].corners[1] - face.markers[0].corners[0]).norm();
  const bool is_tag_grid = face.square <= 0;
  // How far a point's window may reach before it meets other edges, in metres.
  const MarkerDictionary* kind = find_dictionary(face.dictionary);
  const double free = is_tag_grid ? side / (kind->cells + 2 * face.border) * face.border
                                  : std::max((face.square - side) / 2, 0.06 * face.square);
  for (const FacePoint& point : face.points) {
    // The markers nearest to the point, at most two, each by its own map.
    const double reach = is_tag_grid ? side : 1.2 * face.square;
    cv::Point2f sum(0, 0);
    double weights = 0, pixels_a_metre = 0;
    for (const SeenMarker& m : markers) {
      const FaceMarker& at = *face_marker(face, m.id);
      const Eigen::Vector2d middle = 0.5 * (at.corners[0] + at.corners[2]);
      const double apart = (middle - point.position).norm();
      if (apart > reach) continue;
      const cv::Point2f p = map_points(marker_map(at, m), {on_face(point.position)})[0];
      const double weight = 1 / (apart * apart);
      sum += p * weight;
      weights += weight;
      pixels_a_metre += weight * m.short_diagonal() / side;
    }
    if (weights <= 0) continue;
    // Other edges come nearest across a cell's diagonal; what is seen obliquely has a short one.
    const float radius = static_cast<float>(std::clamp(0.7 * free * pixels_a_metre / weights, 3.0, 12.0));
    if (const std::optional<cv::Point2f> exact = refine_saddle(grey, sum * (1 / weights), radius))
      found.push_back({point.id, *exact});
  }
  return found;
}

const MarkerDictionary* dictionary_of(const cv::Mat& grey, const std::vector<Quad>& squares,
                                      std::size_t least, std::vector<int>* ids) {
  std::map<const MarkerDictionary*, std::set<int>> votes;
  for (const Quad& square : squares) {
    for (const int cells : {4, 5, 6, 7}) {
      const cv::Mat bits = read_cells(grey, square, cells + 2);
      const cv::Mat inner = bits({1, 1, cells, cells});
      if (cv::countNonZero(bits) != cv::countNonZero(inner)) continue;  // the border is not black
      const MarkerDictionary* smallest = nullptr;
      for (const MarkerDictionary& d : all_dictionaries()) {
        if (d.cells != cells || (smallest && d.opencv < cv::aruco::DICT_ARUCO_ORIGINAL)) continue;
        int id = -1, turned = 0;
        if (!cv::aruco::getPredefinedDictionary(d.opencv)->identify(inner, id, turned, 0)) continue;
        votes[&d].insert(id);
        if (d.opencv < cv::aruco::DICT_ARUCO_ORIGINAL) smallest = &d;  // 4x4_50 is the beginning of 4x4_1000
      }
    }
  }
  const MarkerDictionary* best = nullptr;
  for (const auto& [dictionary, read] : votes)
    if (read.size() >= least && (!best || read.size() > votes[best].size())) best = dictionary;
  if (best && ids) ids->assign(votes[best].begin(), votes[best].end());
  return best;
}

}  // namespace floatstage::calib
