#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "matting/keyers/plate.h"

namespace floatstage::pipeline {

class PlateCorrection;
class QuickKeyer;

/// What first says, photograph by photograph of one camera, what is subject: somebody else's mattes, a keyer,
/// a plate, or what was cut out from a person's clicks. Where mattes/given/ has a matte of the photograph,
/// that one says it, whatever the key.
class CameraKey {
 public:
  enum class Kind { None, Guide, Keyer, Plate, Cut };

  /// Says nothing about any photograph: for methods that can do with what a person says.
  /// `reason`: why there is none.
  static CameraKey none(const std::string& reason = "");
  /// Another program's mattes as PNG: <guide>/<serial>/<frame>.png. NotFound when the camera has none.
  static Result<CameraKey> guided(const capture::TakeReader& take, int camera,
                                  const std::filesystem::path& guide);
  /// By a keyer's word: "chroma", "luminance:30"; where a plate was shot, corrected by it (PlateCorrection).
  /// NotFound when neither plate nor photographs show green or blue cloth at their borders to "chroma";
  /// InvalidArgument for a parameter that cannot be.
  static Result<CameraKey> keyed(capture::TakeReader& take, int camera, const std::string& spec);
  /// From plates/<serial>.png and plates/<serial>/*.png where they were shot, else found behind the
  /// performance in `photographs` of its pictures, and learnt again without what the first plate keys.
  /// Unsupported when the pictures agree nowhere (the camera moved). `deviations` of a pixel's noise tell the
  /// subject; absent: the keyer's own number.
  static Result<CameraKey> plate(capture::TakeReader& take, int camera,
                                 std::optional<double> deviations = std::nullopt);
  /// Followed from the seed of `edits` (seed_of()) through a cluttered place (matting/video/segment_clip.h),
  /// as a whole, by ready() or the first key(): where all mattes are there it is never needed. `go_on` may
  /// stop that (Cancelled) and must live as long.
  static Result<CameraKey> cut(capture::TakeReader& take, int camera, const CameraEdits& edits,
                               const std::function<bool()>& go_on);
  /// The guide when it is given; else chroma where cloth is most of the backdrop; else a plate that was shot;
  /// else what is cut out where somebody clicked on the subject; else a plate found behind the performance;
  /// else chroma after all, where there is more than hardly any cloth. What plate() says, where there is not.
  static Result<CameraKey> best(capture::TakeReader& take, int camera, const std::filesystem::path& guide,
                                const CameraEdits& edits, const std::function<bool()>& go_on);

  /// The key that a way to mattes starts from (one of matte_methods(), but for "consistent"); none where
  /// spectral matting has to do without. "given" starts from the guide, or from mattes/given/.
  static Result<CameraKey> for_how(capture::TakeReader& take, int camera, const std::string& how,
                                   const std::filesystem::path& guide, const CameraEdits& edits,
                                   const std::function<bool()>& go_on);

  Kind kind() const { return kind_; }
  /// How it was made, for reports: "chroma:#2f7a45", "plate:6", "guide", "cut", "none".
  const std::string& spec() const { return spec_; }
  /// Whether another seed would make another key.
  bool uses_strokes() const { return uses_strokes_; }
  /// Null without one.
  const matting::Plate* known_plate() const { return plate_ ? plate_.get() : nullptr; }

  /// Why there is none, or why it is cloth that is not most of the backdrop.
  const std::string& reason() const { return reason_; }
  /// Share of the subject that stands where no photograph shows the place without it: a plate that was found
  /// knows nothing there. 0 for other keys.
  double unseen() const { return unseen_; }
  bool found() const { return found_; }  ///< a plate that nobody shot, found behind the performance

  /// Does now what the first key() would wait for. InvalidArgument when no click marks the subject;
  /// Cancelled.
  Result<void> ready() const;

  /// One channel, of the photograph's size; what is missing in the guide is an empty picture.
  Result<Image> key(const Frame& photograph, int frame) const;

 private:
  static Result<CameraKey> without_given(capture::TakeReader& take, int camera, const std::string& how,
                                         const std::filesystem::path& guide, const CameraEdits& edits,
                                         const std::function<bool()>& go_on);
  Kind kind_ = Kind::None;
  bool uses_strokes_ = false;
  double unseen_ = 0;
  bool found_ = false;
  std::string spec_, reason_;
  std::filesystem::path guide_;  // a folder with <frame>.png
  std::filesystem::path given_;  // likewise, or nothing
  std::shared_ptr<QuickKeyer> keyer_;
  std::shared_ptr<const PlateCorrection> correction_;  // null without
  std::shared_ptr<const matting::Plate> plate_;
  struct Cut;
  std::shared_ptr<Cut> cut_;
};

}  // namespace floatstage::pipeline
