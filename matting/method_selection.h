#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/image.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// How well each of several mattes of one picture explains it, where they differ or are soft: what `auto`
/// chooses by, since a picture brings no truth along.
///
/// Where all candidates agree on subject or on background, the picture's own colours are theirs; from there
/// both are extended smoothly into the rest (a known plate replaces the extended background where it is
/// confident). There each candidate a must compose the picture: the residual is the mean of |I - a F - (1 -
/// a) B| over those pixels, in 8-bit steps, errors cut off at 48. A candidate without any subject, where
/// another has some, gets infinity; so does one that has another size. All zero where the candidates are hard
/// and equal. `picture`: RGB; `candidates`: one channel each; `plate`: null or of the picture's size.
/// Deterministic.
std::vector<double> composite_residuals(const Image& picture, const std::vector<Image>& candidates,
                                        const Plate* plate = nullptr);

/// What `auto` chooses by over some frames of a clip: how well candidates compose the picture, and how calm
/// they are. Neither is enough: colours that are extended into the unknown prefer soft mattes, and nothing is
/// calmer than an empty one. The least product of mean residual and mean flicker wins; residuals alone decide
/// where no two neighbouring frames were compared.
class MethodComparison {
 public:
  explicit MethodComparison(std::size_t candidates) : residual_(candidates), flicker_(candidates) {}

  /// Mattes of one frame, one a candidate.
  void add(const Image& picture, const std::vector<Image>& mattes, const Plate* plate = nullptr);
  /// Of a frame and the one before; does not count as add(). Sizes that differ count nothing.
  void add_pair(const Image& before, const std::vector<Image>& mattes_before, const Image& picture,
                const std::vector<Image>& mattes);

  /// One a candidate; infinite for those that see nobody where others do. All 0 before anything was added.
  std::vector<double> scores() const;
  /// The candidate of least score, the first of equals; but `usual`, the one that is known to be best as a
  /// rule, unless another's score is less by more than a tenth: differences below that say nothing.
  std::size_t best(std::optional<std::size_t> usual = std::nullopt) const;

 private:
  std::vector<double> residual_, flicker_;
  int frames_ = 0, pairs_ = 0;
};

}  // namespace floatstage::matting
