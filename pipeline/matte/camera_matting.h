#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "matting/guide/guided_matte.h"
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

  /// A matte on the way from frame to frame.
  struct Link {
    int frame = -1;   ///< -1: none
    Image matte;      ///< empty for a gap
    Image base = {};  ///< what it was before strokes, or empty: matte() makes it again where it is needed
    bool changed = false;  ///< whether it differs from the one that was there before, for those who make only
                           ///< some again
    std::vector<std::string> idle = {};   ///< sentences: strokes that change nothing in it
    std::vector<std::string> ended = {};  ///< sentences: what was changed in the neighbour and could not be
                                          ///< followed into it
    bool guided = false;                  ///< whether strokes, its own or others', make it another one
  };

  /// The matte of a frame; empty for a gap. `previous`: the neighbouring frame that was made before, or none:
  /// what strokes have changed there is followed into this one.
  Result<Link> matte(int frame, const Link& previous) const;
  /// A matte that was made otherwise, of the photograph's size, with what strokes say about its frame. Masks
  /// have no say in it.
  Result<Link> guided(int frame, const Image& rgb, Image base) const;
  /// Writes the frame's masks over a matte.
  void mask(int frame, Image& matte) const;

  /// Whether matte() needs the neighbour's: somebody has drawn strokes.
  bool follows() const;
  /// Whether the mattes of frames `first` to `last` follow from that of `frame`.
  bool leads_to(int frame, int first, int last) const;
  /// Goes from the first keyframe to the end and then from it back to the beginning. `visit(frame, previous)`
  /// gets what it returned for the neighbour; a frame without a matte (a gap) is bridged. Stops when
  /// `go_on()` is false.
  void follow(const std::function<bool()>& go_on,
              const std::function<Link(int frame, const Link& previous)>& visit) const;

  int camera() const { return camera_; }
  const CameraEdits& edits() const { return edits_; }
  const CameraKey& key() const { return key_; }
  const std::string& method() const { return method_; }
  bool spectral() const { return method_ == "spectral"; }  ///< made by SpectralTake, not by matte()
  void set_method(std::string method) { method_ = std::move(method); }

 private:
  struct Shot {
    Image rgb, base;  // empty for a gap
  };
  Result<Shot> shot(int frame) const;
  /// Of a frame that `auto` compared methods by: what the chosen one made of it.
  std::optional<Result<Image>> compared(int frame) const;
  Result<Link> guided(int frame, const Image& rgb, Image base, const Image& fixed,
                      const matting::CarriedGuidance& carried) const;
  Result<Image> finished(const std::string& method, const Image& rgb, const Image& key,
                         const Image& known) const;
  int first_keyframe() const;
  Image masks(int frame, const Image& rgb) const;
  std::vector<MatteStroke> strokes(int frame) const;
  std::string idle(int frame, std::size_t stroke, matting::StrokeEffect effect) const;
  std::vector<std::string> ended(const matting::CarriedGuidance& carried, int from, const Link& made) const;

  capture::TakeReader* take_;
  int camera_;
  CameraKey key_;
  CameraEdits edits_;
  std::string method_;
  std::map<int, std::string> compared_;  // PNGs of that method's mattes, by frame
};

}  // namespace floatstage::pipeline
