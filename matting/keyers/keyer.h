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

namespace floatstage::matting {

/// What happens to a raw key before it is a matte, in this order: a closing fills gaps, thin attachments are
/// cut, small islands go, small holes are filled. "Subject" means alpha >= 128. Each keyer has defaults of
/// its own.
struct CleanupOptions {
  int close_radius = 0;  ///< px; closes gaps up to twice this wide
  int thin_radius = 0;   ///< px; what is thinner than twice this goes beyond twice this from thicker parts
  double smallest_island = 0.002;  ///< of the largest component's area; smaller components become background
  double smallest_hole = 0.0005;   ///< of the largest component's area; smaller holes become subject
  bool largest_only = false;       ///< keep one component only
};

/// Cleans a one-channel alpha picture. Soft edges of what stays are kept, and so are faint parts (down to
/// alpha 24) that hang together with it; an empty picture and one without subject come back empty of subject.
Image clean_up(const Image& alpha, const CleanupOptions& options);

class EmptyStage;
class RowMeasure;

/// Turns a photograph into a matte. Implementations are immutable once made and thread safe; the same frame
/// gives the same bytes on any thread.
class Keyer {
 public:
  virtual ~Keyer() = default;
  /// Same size as the frame, carries its info. An empty frame gives an empty matte. Errors name the camera:
  /// Unsupported for a grey frame where colour is needed (or MJPEG), InvalidArgument for a frame of another
  /// size than the clean plate, BadData for a frame shorter than its layout. Unsupported, too, where the
  /// picture shows nothing of the backing that the keyer was made for: no matte is better than a wrong one.
  virtual Result<Matte> key(const Frame& frame) const = 0;
  /// The photograph with the backing's colour cast removed where the keyer knows one; else the photograph as
  /// RGB.
  Result<Image> suppress_spill(const Frame& frame) const {
    Image rgb;
    if (Result<void> ok = suppress_spill(frame, rgb); !ok) return forward(ok);
    return rgb;
  }
  /// The same into a picture whose memory is used again. Errors leave it as it was.
  virtual Result<void> suppress_spill(const Frame& frame, Image& rgb) const = 0;
  /// One line that makes the same keyer again through make_keyer() with the same samples and clean-up.
  virtual std::string spec() const = 0;
  /// What it does to a raw key: its default, or what it was made with.
  virtual CleanupOptions cleanup() const = 0;
  /// What LiveKey (live_key.h) needs to give the same mattes faster; null where only key() can. The keyer's.
  virtual const RowMeasure* rows() const { return nullptr; }
  /// The empty stage by which it corrects (empty_stage.h) what rows() tell; null where it does not.
  virtual const EmptyStage* empty_stage() const { return nullptr; }
};

/// Makes a keyer from its spec:
///   "chroma" or "chroma:#rrggbb"   CbCr angle to the cloth's colour with a saturation floor; when not given
///                                  the colour is sampled from `samples`: plates, or photographs whose
///                                  borders show the cloth. What else the samples' rims show (walls,
///                                  lamps) is learnt from them too, given a colour or not
///   "difference" or "difference:T" against this camera's clean plate, threshold T in 8-bit steps (default
///                                  24). Several samples: their median, the plate where the subject moves
///   "luminance" or "luminance:T"   black stage: what differs from the black, and from cloth that catches
///                                  light, as the rims of `samples` (or else of each frame) show them; with T
///                                  only where grey > T; with T and without samples wherever
///                                  grey > T
///   "plate" or "plate:K"           against a plate with per-pixel noise, learnt from the samples
///                                  (matting/keyers/plate.h); K standard deviations (default 6) tell the
///                                  subject
/// `samples` are pictures (1 or 3 channels) of this one camera: plates first, else some photographs of the
/// take. A frame that a camera or a converter laid around them (black bars) is background and is not learnt
/// from. Without `cleanup` the keyer uses its own default. Errors: InvalidArgument lists the keyers when the
/// name is unknown, and says what a parameter or sample should be; NotFound when the samples show no green or
/// blue cloth.
Result<std::unique_ptr<Keyer>> make_keyer(std::string_view spec, const std::vector<Image>& samples,
                                          const std::optional<CleanupOptions>& cleanup = std::nullopt);

/// Every keyer with one line of help, for --help and the conformance test.
struct KeyerInfo {
  std::string name, help;
};
std::vector<KeyerInfo> keyers();

}  // namespace floatstage::matting
