#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/result.h"
#include "core/reused.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/keyer_choice.h"
#include "matting/keyers/live_key.h"
#include "recon/outline.h"
#include "studio/messages/camera_view.h"
#include "studio/node/foreground_tile.h"

namespace floatstage::studio {

/// How well a camera node looks: what may be changed from one frame to the next.
struct NodeQuality {
  int shrink = 1;           ///< photograph pixels per keyed pixel, along each side
  double tolerance = 0.75;  ///< px of the photograph by which outlines may leave the key's edge
  /// Islands and holes of the key of less than this share of the picture's area are left out of the outline:
  /// 4e-5 are 31 pixels at 1024x768. They stay in the tile's matte.
  double smallest = 4e-5;
  bool operator==(const NodeQuality&) const = default;
};

/// InvalidArgument with a sentence for numbers out of range.
Result<void> check(const NodeQuality& quality);

/// Milliseconds that one look took.
struct NodeTimings {
  double key = 0, outline = 0, tile = 0;
};

/// The instant of a set of frames, as the synchroniser found it.
struct Instant {
  std::uint64_t epoch = 0;
  Timestamp time;
};

/// One camera of a camera node: a frame in, the subject's outline and on request its texture out. Keys a
/// down-sampled picture, and touches the photograph's own pixels only where the subject is. Used by one
/// thread at a time; different nodes run side by side. Where the key is fast (LiveKey::fast()) nothing is
/// allocated for colour frames, but to crop Nv12, once subjects as large were seen and the views before were
/// dropped.
class CameraViewMaker {
 public:
  /// `spec` as for make_keyer(); `samples` are whole photographs or clean plates of this camera; by those a
  /// key by colour is corrected, too (corrected_by_plate()). Errors: those of make_keyer(), with the camera's
  /// name.
  static Result<CameraViewMaker> make(const std::string& serial, const CameraModel& model,
                                      const std::string& spec, matting::KeySamples samples);

  /// Makes what look() needs to key at 1/`shrink`, which it otherwise does when that is first asked of it:
  /// keyers learn from whole pictures, which takes longer than a frame. Errors: those of make_keyer().
  Result<void> prepare(int shrink);

  /// `frame` as the source delivered it at `produced`; an empty or corrupt one makes a view that is not
  /// known. With `textured`, the view has a tile when the subject is in the picture. Errors: those of
  /// shrink() and Keyer::key(), and BadData for a frame of another size than the model's.
  /// `shade`: shadows on the floor in the frame, which are none of the subject (LiveKey::key()), or null.
  Result<std::shared_ptr<const CameraView>> look(const Frame& frame, const Instant& instant,
                                                 Timestamp produced, bool textured,
                                                 const NodeQuality& quality,
                                                 const matting::CastShade* shade = nullptr);

  const std::string& serial() const { return serial_; }
  const NodeTimings& timings() const { return timings_; }  ///< of the last look()
  std::string spec() const { return keyers_.at(1).keyer->spec(); }

 private:
  CameraViewMaker() = default;
  static Result<std::unique_ptr<matting::Keyer>> keyer_of(
      const std::string& spec, const matting::KeySamples& samples,
      const std::optional<matting::CleanupOptions>& cleanup);
  Result<matting::LiveKey*> keyer_at(int shrink);
  Result<std::shared_ptr<const ForegroundTile>> tile_of(const Frame& frame, const Matte& small, int shrink);

  std::string serial_;
  CameraModel model_;
  matting::KeySamples samples_;
  struct KeyerAtScale {
    explicit KeyerAtScale(std::unique_ptr<matting::Keyer> made) : keyer(std::move(made)), live(*keyer) {}
    std::unique_ptr<matting::Keyer> keyer;  // knows the clean plate at its size
    matting::LiveKey live;
  };
  std::map<int, KeyerAtScale> keyers_;  // by shrink
  recon::OutlineWorkspace outlines_;
  std::vector<std::uint32_t> sums_;  // of the picture that is made smaller
  Image averaged_;                   // it at a fraction of its size
  MatteEnlarger enlarger_;
  Reused<CameraView> views_;
  Reused<ForegroundTile> tiles_;
  NodeTimings timings_;
};

}  // namespace floatstage::studio
