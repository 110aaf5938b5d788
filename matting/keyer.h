#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"

namespace floatstage {

/// What happens to a raw key before it is a matte: a closing that fills gaps, then small islands and holes go.
struct CleanupOptions {
  int close_radius = 0;             ///< px; closes gaps up to twice this wide
  double smallest_island = 0.002;   ///< of the largest component's area; smaller components become background
  double smallest_hole = 0.0005;    ///< of the largest component's area; smaller holes become subject
  bool largest_only = false;        ///< keep one component only
};

/// Cleans a one-channel alpha picture; soft edges of what stays are kept.
Image clean_up(const Image& alpha, const CleanupOptions& options);

/// Turns a photograph into a matte. Implementations are immutable once made and thread safe.
class Keyer {
 public:
  virtual ~Keyer() = default;
  /// Same size as the frame. An empty frame gives an empty matte. Errors name the camera.
  virtual Result<Matte> key(const Frame& frame) const = 0;
  /// The photograph with the backing's colour cast removed where the keyer knows one; else the photograph as RGB.
  virtual Result<Image> suppress_spill(const Frame& frame) const = 0;
  /// One line that makes the same keyer again through make_keyer().
  virtual std::string spec() const = 0;
};

/// Makes a keyer from its spec:
///   "chroma" or "chroma:#rrggbb"   CbCr angle to the cloth's colour with a saturation floor; the colour is sampled
///                                  from `samples` (plates, or photographs whose borders show the cloth) when not given
///   "difference" or "difference:T" against this camera's clean plate, threshold T in 8-bit steps
///   "luminance:T"                  black stage: grey > T is subject
/// `samples` are pictures of this one camera: plates first, else some photographs of the take.
/// InvalidArgument lists the keyers when the name is unknown.
Result<std::unique_ptr<Keyer>> make_keyer(std::string_view spec, const std::vector<Image>& samples,
                                          const CleanupOptions& cleanup);

/// Every keyer with one line of help, for --help and the conformance test.
struct KeyerInfo {
  std::string name, help;
};
std::vector<KeyerInfo> keyers();

}  // namespace floatstage
