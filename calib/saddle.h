#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

namespace floatstage::calib {

/// What a ring around a place says: grey as a sum of waves. At the crossing of two edges the second wave
/// rules. Pixels are OpenCV's (first centre at 0). Private to calib.
struct Ring {
  cv::Vec2f second;  ///< amplitude of the second wave, as a vector: its angle is twice the direction of the
                     ///< light squares
  float asymmetry = 0;  ///< mean |I(θ) - I(θ + π)|: 0 at a saddle, large on one edge or at a corner
  float contrast() const { return std::hypot(second[0], second[1]); }
  bool is_saddle() const { return contrast() > 5 && asymmetry < 0.7f * contrast(); }
};

Ring ring_around(const cv::Mat& grey, cv::Point2f center, float radius);

/// The exact crossing of edges near `start`: the point about which the picture within `radius` px is most
/// symmetric, grey at p + d equal to grey at p - d. Unlike the point to which gradients lead (Förstner;
/// cornerSubPix) it does not drift when blur is as wide as the disc is. Absent when it leaves the disc, lies
/// too near to the picture's rim, or is no crossing of light and dark.
std::optional<cv::Point2f> refine_saddle(const cv::Mat& grey, cv::Point2f start, float radius);

/// Places where a smoothed picture is saddle-shaped, strongest first, at most `most` of them: the determinant
/// of its second derivatives has a deep local minimum, and the ring agrees.
struct Saddle {
  cv::Point2f at;
  float strength = 0;
  cv::Vec2f second;  ///< of its ring
};
std::vector<Saddle> find_saddles(const cv::Mat& grey, std::size_t most);

}  // namespace floatstage::calib
