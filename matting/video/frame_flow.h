#pragma once

#include <vector>

#include "core/image.h"
#include "matting/video/video_matting.h"

// Private to the stage: what moves between two frames of a clip.
namespace floatstage::matting {

/// Where each pixel of one picture was in another: to(x, y) looks like from(x + u, y + v), in px.
struct FrameFlow {
  int width = 0, height = 0;
  std::vector<float> uv;  ///< interleaved
};

/// The flow that carries `from` to `to` (W of eq. 7.3, looked up backwards), by dense inverse search (Kroeger
/// et al. 2016). RGB or grey pictures of one size; none is found in pictures of less than 32 px.
FrameFlow flow_between(const Image& from, const Image& to);

/// What `from` looks like when it is carried: bilinear, edges repeated (eq. 7.4).
Image carried(const Image& from, const FrameFlow& flow);
Eigen::MatrixXf carried(const Eigen::MatrixXf& from, const FrameFlow& flow);

/// How well the carried picture explains the other, a pixel: 255 where colours agree, falling to 25 where
/// they do not.
Image confidence_of(const Image& from, const Image& to, const FrameFlow& flow);

}  // namespace floatstage::matting
