#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "pipeline/matte/camera_key.h"

namespace floatstage::pipeline {

/// One camera's photographs to mattes, by one method. Thread safe: all state is in what is passed in.
class CameraMatting {
 public:
  CameraMatting(capture::TakeReader& take, int camera, CameraKey key, CameraEdits edits, std::string method);

  /// "key", "closed-form" or "spectral", as the method asks for. `auto` chooses by MethodComparison on a few
  /// photographs, and spectral where there is no key. Edits have no say in it: a stroke must not change the
  /// method of frames that it does not concern.
  /// What it made for that is kept for matte(), packed.
  Result<std::string> chosen_method();

  /// The matte of a frame; empty for a gap. `previous`: the matte of the neighbouring frame that was made
  /// before, or empty.
  Result<Image> matte(int frame, const Image& previous) const;

  /// Whether matte() needs the neighbour's: a person has chosen among parts, and the choice is followed; not
  /// where the key has followed it already.
  bool follows() const;
  /// A matte on the way, and whether it differs from the one that was there before (for those who make only
  /// some again).
  struct Link {
    Image matte;
    bool changed = false;
  };
  /// Goes from the first keyframe to the end and then from it back to the beginning. `visit(frame, previous)`
  /// gets what it returned for the neighbour; a frame without a matte (a gap) is bridged. Stops when
  /// `go_on()` is false.
  void follow(const std::function<bool()>& go_on,
              const std::function<Link(int frame, const Link& previous)>& visit) const;

  /// Writes the frame's masks and strokes over a matte.
  void mask(int frame, Image& matte) const;

  int camera() const { return camera_; }
  const CameraEdits& edits() const { return edits_; }
  const CameraKey& key() const { return key_; }
  const std::string& method() const { return method_; }
  bool spectral() const { return method_ == "spectral"; }  ///< made by SpectralTake, not by matte()
  void set_method(std::string method) { method_ = std::move(method); }

 private:
  Result<Image> finished(const std::string& method, const Image& rgb, const Image& key,
                         const Image& known) const;
  int first_keyframe() const;
  Image said(int frame, int width, int height, bool strokes, bool masks) const;

  capture::TakeReader* take_;
  int camera_;
  CameraKey key_;
  CameraEdits edits_;
  std::string method_;
  std::map<int, std::string> compared_;  // PNGs of that method's mattes, by frame
};

}  // namespace floatstage::pipeline
