#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/rig.h"
#include "matting/keyers/keyer_choice.h"
#include "studio/messages/studio_control.h"

namespace floatstage::studio {

/// Where a live chain's pictures come from: cameras, or a take that is played as if it were some.
class LiveSource {
 public:
  /// Takes a frame and when it was produced; info.camera is its place in rig(). Called on the source's
  /// threads, those of one camera one after the other. It must not wait.
  using Tap = std::function<void(const Frame& frame, Timestamp produced)>;

  virtual ~LiveSource() = default;
  virtual const Rig& rig() const = 0;
  virtual double frame_rate() const = 0;
  /// How far stamps are from instants, one a camera, or empty: capture::SyncOptions::offsets.
  virtual std::vector<Nanoseconds> time_offsets() const { return {}; }
  /// Pictures of each camera from which its keyer learns: its clean plate, or some photographs.
  virtual std::vector<matting::KeySamples> samples() const = 0;
  /// One sentence for the report: what is measured and what is not.
  virtual std::string description() const = 0;
  /// Once. Frames come until stop() or until it is over.
  virtual void begin(Tap tap) = 0;
  virtual bool over() const = 0;
  virtual void stop() = 0;
  /// Called a few times a second by the thread that runs the chain.
  virtual void poll() {}
  /// Health and recording; null where there is nothing to control.
  virtual StudioControl* control() { return nullptr; }
};

}  // namespace floatstage::studio
