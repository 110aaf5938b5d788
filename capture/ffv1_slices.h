#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/frame.h"

// Private to capture/: what there is to know of an FFV1 picture without decoding it (RFC 9043).

namespace floatstage::capture {

/// Whether every slice of an FFV1 picture (version 3, with slice checksums) is as the encoder wrote it. The
/// decoder checks too, but only to paint old pixels over the damage without saying so. ("Slice Footer":
/// slices are found from the back by their 24-bit sizes; the CRC of a slice with its footer is zero.)
bool ffv1_intact(std::span<const std::uint8_t> picture);

/// The grid in which a track's pictures are cut into slices, each of which is coded for itself.
class Ffv1Slices {
 public:
  /// From the codec's private data ("Configuration Record"), of pictures of this size. Absent where that is
  /// not of version 3.
  static std::optional<Ffv1Slices> of(std::span<const std::uint8_t> configuration, int width, int height);

  /// Shortens a key picture so that a decoder spends no time on slices that lie outside of all `boxes`: of
  /// the header is left, with a footer that says that what follows is lost (error_status 2). Returns its new
  /// size. 0, and the picture stays as it was, where the slices are not as the grid says, or one that meets
  /// a box is damaged: it is to be read as a whole then, which tells why.
  std::size_t keep(std::span<std::uint8_t> picture, std::span<const PixelBox> boxes) const;

 private:
  using Transitions = std::array<std::uint8_t, 256>;
  struct Slice {
    std::span<std::uint8_t> bytes;  // with its footer
    bool is_kept = false;
  };
  std::optional<PixelBox> cells_of(std::span<const std::uint8_t> slice, bool is_first) const;
  std::optional<std::vector<Slice>> find(std::span<std::uint8_t> picture,
                                         std::span<const PixelBox> boxes) const;

  int width_ = 0, height_ = 0;    // px
  int columns_ = 0, rows_ = 0;    // of cells
  Transitions transitions_ = {};  // of the range coder's states, after a one
};

}  // namespace floatstage::capture
