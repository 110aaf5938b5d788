#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/detail/synthesis_protocol.h"

namespace floatstage::detail::test {

/// Where a synthesised pixel's details come from, or -1: y * width + x in all children laid one below the
/// other, as wide as the widest of them.
using Places = std::vector<std::int64_t>;

/// What tells a synthesis from a blur, from noise and from copies; outside the children. PSNR and SSIM rank
/// these wrongly: a blur is nearer to the truth than any invented hair.
struct SynthesisFigures {
  /// dB against the truth in the four finest octaves, the finest last.
  std::array<double, 4> spectrum{};
  /// The same in the tenth of the picture whose finest octave is weakest: what is out of focus.
  std::array<double, 4> defocused{};
  /// Mean distance of the picture's neighbourhoods to the nearest of the children's (Eq. 4.11), and the other
  /// way about; as a multiple of the truth's.
  double to_children = 0, from_children = 0;
  /// Mean of |ln variance - ln the truth's| over 4 levels, 4 directions and windows of 64 px.
  double sub_bands = 0;
  double downsampled = 0;  ///< PSNR against the low picture, dB; at most 99
  /// The largest of |gradient across borders over that 8 px beside them - 1|: of children and of tiles.
  double seam = 0;
  int repeats = 0;  ///< how often the most used block of 17 x 17 px of the children is copied as a whole
  double psnr = 0;  ///< reported, no gate
};

/// What the truth gives, once for all pictures that are compared with it.
class SynthesisJudge {
 public:
  explicit SynthesisJudge(const SynthesisProtocol& protocol);
  /// `tile`: the side of tiles whose borders are looked at; 0: none. `places`: of every pixel; empty: nothing
  /// is known of copies.
  SynthesisFigures measure(const Image& picture, int tile = 256, const Places& places = {}) const;

 private:
  struct Energies {
    double to_children = 0, from_children = 0;
  };
  Energies energies(const Image& picture) const;

  const SynthesisProtocol& protocol_;
  std::vector<std::array<double, 4>> truth_blocks_;
  std::vector<std::size_t> defocused_;
  std::vector<double> truth_bands_;
  Energies truth_energies_;
};

/// How often the most used block of 17 x 17 px is copied as a whole outside the children.
int most_used_block(const SynthesisProtocol& protocol, const Places& places, int width, int height);

/// The names of the gates that figures do not pass: "G1" to "G7".
std::vector<std::string> failed_gates(const SynthesisFigures& figures);

std::string to_text(const SynthesisFigures& figures);

}  // namespace floatstage::detail::test
