#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/flow.h"
#include "render/flow/flow_kernels.h"
#include "render/flow/split_plane.h"

namespace floatstage::render {

/// How a picture becomes what the solver reads.
struct PyramidOptions {
  float stiffness = 15;  ///< alpha: the smoothness against the data
  float edge = 5;        ///< 8-bit steps a px: a gradient at which the smoothness is worth half
};

/// One level of a picture. Pixel (x, y) of level l covers the four pixels (2x, 2y) … (2x+1, 2y+1) of l - 1.
///
/// The *domain* is where the picture shows the proxy at all (FlowImage::state not 0); outside it there is a
/// *band* of kBand pixels into which brightness is continued, so that derivatives at the outline see no edge;
/// beyond it nothing is computed.
struct PictureLevel {
  enum Zone : std::uint8_t { kOutside = 0, kBand = 1, kDomain = 2 };
  static constexpr int kBandWidth = 2;  // px: the reach of a second central difference

  int width = 0, height = 0;
  std::vector<std::uint8_t> zone;  ///< width * height
  std::vector<std::uint8_t> own;   ///< share of evidence, 0 … 255; 0 outside the domain
  bool whole = false;              ///< everything is domain and evidence
  std::vector<float> value;        ///< smoothed brightness; 0 beyond the band
  SplitPlane first;                ///< the same, rounded to 1/128, as the picture that is looked from
  SplitPlane data;                 ///< weight of its data: own / 255
  SplitPlane stiffness;            ///< of the smoothness; almost 0 in the band, 0 beyond
  std::vector<SplitSpan> spans;    ///< per row: the blocks that hold domain or band

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  /// The same picture as the one that is looked into.
  SampledPicture sampled() const;

  std::vector<std::uint16_t> samples;  ///< with kSampleMargin around
};

/// A picture at full size and halved again and again. Kept between pictures: memory is taken only when
/// something is larger than before.
class PicturePyramid {
 public:
  /// `levels` of at least 1. The picture is not kept.
  void build(const FlowImage& picture, int levels, const PyramidOptions& options);
  /// The same in two: brightness, zones and spans of all levels, then what the solver reads of each, which
  /// may be asked for on several threads at once.
  void shrink(const FlowImage& picture, int levels);
  void finish(int level, const PyramidOptions& options);
  const PictureLevel& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

 private:
  void grow_band(PictureLevel& level);
  static void lay_out(PictureLevel& level, std::vector<float>& row);
  static void find_stiffness(PictureLevel& level, const PyramidOptions& options, std::vector<float>& row);

  PictureLevel raw_;
  std::vector<PictureLevel> levels_;
  std::vector<std::vector<float>> rows_;  // scratch: a row of each level
  std::vector<std::uint8_t> bytes_;       // scratch of one row
  std::vector<int> border_;               // scratch: pixels that join the band
};

/// How often a picture can be halved and still have `least` px on its shorter side, and one level more: 1 …
int pyramid_levels(int width, int height, int least);

}  // namespace floatstage::render
