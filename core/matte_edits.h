#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// What a person says about a place in a photograph.
enum class MatteLabel { Background, Foreground };

/// A click (one point) or a scribble (several): everything within `radius` of the line belongs to the label.
struct MatteStroke {
  MatteLabel label = MatteLabel::Foreground;
  double radius = 3;  ///< px, positive
  std::vector<Eigen::Vector2d>
      points;  ///< px of the camera's photographs, the picture's corner at (0, 0); at least one
  /// Of several subjects which one it marks, a name for which is_usable_label() holds; empty: not said, and
  /// always so of background. It says nothing of opacity.
  std::string subject = {};
  bool operator==(const MatteStroke&) const = default;
};

/// The strokes in one frame. From there they are carried along the clip, forwards and backwards.
struct MatteKeyframe {
  int frame = 0;
  std::vector<MatteStroke> strokes;  ///< later ones paint over earlier ones
  bool operator==(const MatteKeyframe&) const = default;
};

/// An area that is background in every frame (a garbage mask: lamp stands, the edge of the cloth) or
/// foreground in every frame (a hold-out: a green prop). Stands still; nothing is carried along.
struct MatteMask {
  MatteLabel label = MatteLabel::Background;
  std::vector<Eigen::Vector2d> polygon;  ///< px, at least three corners; even-odd where it crosses itself
  int first = 0;                         ///< first frame
  std::optional<int> last;               ///< last frame, included; absent: to the end
  double radius = 0;  ///< px; positive: `polygon` is the path of a brush instead, one point at least
  bool operator==(const MatteMask&) const = default;
};

struct CameraEdits {
  std::vector<MatteKeyframe> keyframes;  ///< in order of their frames, each at most once
  std::vector<MatteMask> masks;
  bool operator==(const CameraEdits&) const = default;
};

/// mattes/edits.json: what an operator said about the mattes of a take, by serial. The only file below
/// mattes/ that people make; no verb ever removes it.
struct MatteEdits {
  std::map<std::string, CameraEdits> cameras;
  bool operator==(const MatteEdits&) const = default;
};

/// The work of a person: what `evaluate --mattes` reports beside the scores.
struct MatteEffort {
  int keyframes = 0, clicks = 0, scribbles = 0, masks = 0;
};
MatteEffort effort_of(const CameraEdits& edits);

/// What of the edits concerns opacity: the same without subjects.
CameraEdits without_subjects(CameraEdits edits);

/// Reads strictly; the sentence names the camera and what is wrong. Unsupported for a version that is not
/// known.
Result<MatteEdits> parse_matte_edits(std::string_view json, std::string_view name_for_errors);
/// In the lowest format that holds them: 2 where a stroke has a subject, else 1.
std::string to_json(const MatteEdits& edits);

/// No file is no edits.
Result<MatteEdits> load_matte_edits(const std::filesystem::path& file);
Result<void> save_matte_edits(const MatteEdits& edits, const std::filesystem::path& file);

/// Paints strokes into a picture of one channel: 0 background, 255 foreground, other pixels as they are. A
/// pixel counts where its centre does. `scale`: pixels of `map` over pixels of the photograph; a stroke
/// covers at least the pixel that its points lie in.
void paint_strokes(const std::vector<MatteStroke>& strokes, double scale, Image& map);
/// Likewise the masks that hold in `frame`.
bool holds_in(const MatteMask& mask, int frame);
void paint_masks(const std::vector<MatteMask>& masks, int frame, double scale, Image& map);

}  // namespace floatstage
