#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "calib/board_face.h"
#include "calib/chessboard_grid.h"
#include "calib/detect.h"
#include "calib/marker_detection.h"

namespace floatstage::calib {

/// What one search found, with what the diagnosis needs to know. Private to calib. Pixels are OpenCV's.
struct BoardSearch {
  std::vector<FoundPoint> points;
  SeenMarkers seen;                    ///< of marker boards
  std::vector<SeenMarker> consistent;  ///< the markers that lie as on the target
  ChessboardGrid grid;                 ///< of chessboards
};

/// Effort: how many ways a search tries before it gives up.
enum class Effort { Quick, Full };

BoardSearch find_on_faces(const cv::Mat& grey, const std::vector<BoardFace>& faces, Effort effort);
BoardSearch find_chessboard(const cv::Mat& grey, const Chessboard& board, Effort effort);

/// Two or three balls or tags of a wand.
BoardSearch find_wand(const cv::Mat& grey, const Wand& wand);

/// Any target but a wand.
BoardSearch find_board(const cv::Mat& grey, const TargetDesign& design, Effort effort);

/// The likely cause why `found` is not enough.
Detection diagnose(const cv::Mat& grey, const TargetDesign& design, const BoardSearch& found,
                   int least_points);

}  // namespace floatstage::calib
