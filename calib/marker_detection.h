#pragma once

#include <array>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "calib/board_face.h"

namespace floatstage::calib {

/// A marker in a picture; corners clockwise from its upper left, OpenCV's pixels (first centre at 0). Private
/// to calib.
struct SeenMarker {
  int id = 0;
  std::array<cv::Point2f, 4> corners;
  float side() const;            ///< px, mean
  float short_diagonal() const;  ///< px
};

struct SeenMarkers {
  std::vector<SeenMarker> markers;                        ///< of the dictionary, each id once
  std::vector<std::array<cv::Point2f, 4>> other_squares;  ///< dark squares that are no marker of it
};

/// Markers of a dictionary. `windows` are the sides (px, odd) of the neighbourhoods in which dark and light
/// are told apart: small ones for small markers, large ones for blurred ones. `scale` < 1 searches in a
/// reduced picture. `apart` px are taken from the dark all around first: tags whose corners touch other black
/// would not be seen as squares.
struct MarkerSearch {
  std::vector<int> windows = {13};
  double scale = 1;
  int apart = 0;
};
SeenMarkers find_markers(const cv::Mat& grey, const std::string& dictionary, int border,
                         const MarkerSearch& how = {});

/// The markers of a face that lie as on the face, seen by a camera: one plane-to-picture map with slack for
/// the lens explains them. Empty when fewer than `least` do.
std::vector<SeenMarker> consistent_markers(const BoardFace& face, const std::vector<SeenMarker>& seen,
                                           std::size_t least);

/// A face's points near those markers, refined where edges cross.
struct FoundPoint {
  int id = 0;
  cv::Point2f at;
};
std::vector<FoundPoint> points_near_markers(const cv::Mat& grey, const BoardFace& face,
                                            const std::vector<SeenMarker>& markers);

/// In which dictionary most of these squares can be read, when at least `least` of them can; else null.
const struct MarkerDictionary* dictionary_of(const cv::Mat& grey,
                                             const std::vector<std::array<cv::Point2f, 4>>& squares,
                                             std::size_t least, std::vector<int>* ids = nullptr);

}  // namespace floatstage::calib
