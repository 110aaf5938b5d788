#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/flow.h"
#include "render/projected_images.h"

namespace floatstage::render {

/// Is a flow to be believed? Keeps its memory: use one for many pairs; one thread at a time.
class FlowTrust {
 public:
  /// Per pixel of image `from`, 0 … 255: how far is the flow `there` to image `to` to be believed? Not at all
  /// unless both images have their own colour at both ends; else the less, the farther from home `back` (may
  /// be null) leads and the more the images differ along the flow, as such and against no flow at all: steady
  /// as these change, so that what is followed does not come and go at once. Valid until the next call.
  const std::vector<std::uint8_t>& run(const ProjectedImages& images, std::size_t from, std::size_t to,
                                       const FlowField& there, const FlowField* back);

 private:
  struct Span {
    int begin = 0, end = 0;  // of a row's pixels on the proxy
  };
  void differ(const ProjectedImages& images, std::size_t from, std::size_t to, const FlowField& there, int y);
  void judge(const ProjectedImages& images, std::size_t from, std::size_t to, const FlowField& there,
             const FlowField* back, int y);
  float* row(std::vector<float>& rows, int y) const;

  int width_ = 0, height_ = 0;
  std::vector<Span> spans_;
  std::vector<float> apart_[2];        // of one row: differences without and with the flow
  std::vector<float> before_, after_;  // sums along rows, of as many rows as a neighbourhood has
  std::vector<std::uint8_t> believed_;
};

}  // namespace floatstage::render
