#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "matting/keyer.h"
#include "matting/plate.h"

namespace floatstage {

/// What first says, photograph by photograph of one camera, what is subject: somebody else's mattes, a chroma key, or a
/// plate.
class CameraKey {
 public:
  enum class Kind { None, Guide, Chroma, Plate };

  /// Says nothing about any photograph: for methods that can do with what a person says.
  static CameraKey none();
  /// Another program's mattes as PNG: <guide>/<serial>/<frame>.png. NotFound when the camera has none.
  static Result<CameraKey> guided(const TakeReader& take, int camera, const std::filesystem::path& guide);
  /// NotFound when neither plate nor photographs show green or blue cloth at their borders.
  static Result<CameraKey> chroma(TakeReader& take, int camera);
  /// From plates/<serial>.png and plates/<serial>/*.png where they were shot, else found behind the performance in
  /// `photographs` of its pictures, and learnt again without what the first plate keys. Unsupported when the pictures agree
  /// nowhere (the camera moved).
  static Result<CameraKey> plate(TakeReader& take, int camera, int photographs = 48);
  /// The guide when it is given; else chroma where cloth is most of the backdrop; else the plate; else chroma after all.
  static Result<CameraKey> best(TakeReader& take, int camera, const std::filesystem::path& guide);

  /// The key that a method of `matte` starts from; none where spectral matting has to do without.
  static Result<CameraKey> for_method(TakeReader& take, int camera, const std::string& method, const std::filesystem::path& guide);

  Kind kind() const { return kind_; }
  /// How it was made, for reports: "chroma:#2f7a45", "plate:6", "guide", "none".
  const std::string& spec() const { return spec_; }
  /// Null without one.
  const Plate* known_plate() const { return plate_ ? plate_.get() : nullptr; }

  /// One channel, of the photograph's size; what is missing in the guide is an empty picture.
  Result<Image> key(const Frame& photograph, int frame) const;

 private:
  Kind kind_ = Kind::None;
  std::string spec_, serial_;
  std::filesystem::path guide_;
  std::shared_ptr<const Keyer> keyer_;
  std::shared_ptr<const Plate> plate_;
};

}  // namespace floatstage
