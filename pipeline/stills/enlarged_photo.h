#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "detail/synthesis/provenance.h"
#include "pipeline/enlarged_box.h"

namespace floatstage::pipeline {

/// For every pixel of a photograph the place in a still that shows the same, px, corners at whole numbers;
/// not finite where there is none.
struct StillMap {
  int width = 0, height = 0;
  std::vector<Eigen::Vector2f> at;

  StillMap() = default;
  StillMap(int w, int h);  ///< nothing anywhere
  Eigen::Vector2f& operator()(int x, int y) { return at[static_cast<std::size_t>(y) * width + x]; }
  const Eigen::Vector2f& operator()(int x, int y) const {
    return at[static_cast<std::size_t>(y) * width + x];
  }
  /// At a point of the photograph, between the four pixels around it; not finite where one of them is not.
  Eigen::Vector2f between(double x, double y) const;
};

/// What became of a still in a photograph.
struct CarriedStill {
  double used = 0;      ///< share of the photograph's subject that got its details
  double moved = 0;     ///< px of the photograph by which the still was bent to fit, mean of what is used
  StillMap map;         ///< where it lies in the end
  std::string why_not;  ///< why nothing of it is used; empty: some is
};

/// A photograph at a multiple of its size, into which stills are carried: what a still shows finer than the
/// photograph is added to the photograph enlarged, so that its means over photograph's pixels stay those of
/// the photograph (thesis ch. 4 asks that of details; docs/adr/0297). The subject alone gets details.
class EnlargedPhoto {
 public:
  /// `picture` RGB, `matte` of one channel (empty: all is subject); both outlive this. `scale` 1 or more.
  EnlargedPhoto(const Image& picture, const Image& matte, int scale, int threads);

  /// Bends the still to the photograph by optical flow, twice, and adds its details where both then show the
  /// same. `zoom`: pixels of the still in one of the photograph, linear. Later stills replace earlier ones.
  /// Errors: the flow's.
  Result<CarriedStill> carry(const Image& still, double zoom, const StillMap& map, detail::Provenance as);

  const Image& picture() const { return enlarged_; }
  /// One channel: a detail::Provenance a pixel.
  const Image& provenance() const { return provenance_; }

 private:
  struct Fine;
  Result<CarriedStill> carry(const Image& still, double zoom, const StillMap& map, detail::Provenance as,
                             bool proven);
  Result<void> prove(const Image& still, double zoom, const StillMap& map, const EnlargedBox& box,
                     std::vector<float>& trusted) const;
  EnlargedBox box_of(const StillMap& map) const;
  Fine seen_through(const Image& still, const StillMap& map, const EnlargedBox& box, int shrunk) const;
  void match_tones(Fine& fine, const EnlargedBox& box) const;
  Result<void> bend(const Fine& fine, const EnlargedBox& box, StillMap& map) const;
  std::vector<float> trust(const Fine& fine, const EnlargedBox& box) const;
  void take_noise_off(const Fine& fine, const std::vector<float>& coarse, const EnlargedBox& box,
                      std::vector<float>& trusted) const;
  void add(const Fine& fine, const EnlargedBox& box, const std::vector<float>& trusted,
           detail::Provenance as);
  bool is_subject(int x, int y) const;

  const Image& photo_;
  const Image& matte_;
  const int scale_, threads_;
  Image enlarged_, provenance_;
};

}  // namespace floatstage::pipeline
