#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/board.h"
#include "calib/observations.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::calib {

/// Why nothing was found in a picture: the likely cause, from evidence in the picture itself.
enum class DetectionFailure {
  None,                   ///< the target was found
  Unreadable,             ///< the picture could not be decoded
  NothingLikeIt,          ///< nothing in it resembles the target
  CutOff,                 ///< a part was found, at the picture's rim
  PartlyHidden,           ///< a part was found, too little to use
  Blurred,                ///< out of focus or moving: found only at a lower resolution, or no edge is sharp
  TooDark,                ///< or too bright: no contrast
  InvertedPrint,          ///< found with black and white exchanged
  MirroredPrint,          ///< found in the mirrored picture
  SwappedRowsAndColumns,  ///< found with rows and columns exchanged
  WrongCount,             ///< a chessboard of another size (inner corners counted instead of squares?)
  WrongDictionary,        ///< markers of another dictionary
  OtherNumbers,           ///< markers of this dictionary that are not on this target
};

const char* name_of(DetectionFailure failure);
std::optional<DetectionFailure> detection_failure_named(std::string_view name);

/// What was found in one picture.
struct Detection {
  std::vector<SeenPoint> points;  ///< ascending ids; empty unless failure is None
  DetectionFailure failure = DetectionFailure::None;
  std::string reason;  ///< one sentence on why not, and what to do; empty when found
  bool operator==(const Detection&) const = default;
};

struct DetectOptions {
  int least_points = 6;  ///< fewer are none (a wand needs all its points)
  bool diagnose = true;  ///< look for the likely cause when nothing is found: costs three more searches
  double sigma = 0.2;    ///< px, written into every point: what good pictures of flat boards give
};

/// Finds the target in one picture (1, 3 or 4 channels). Pixels have the corner origin. Corners of
/// chessboards, ChArUco boards and AprilTag grids are where edges cross, to a few hundredths of a pixel;
/// centres of balls are the centroids of their light, corrected for nothing: the image of a sphere is an
/// ellipse whose centre lies off the image of the sphere's centre by up to tan(angle off axis) ·
/// (radius/depth)² · focal length. Thread safe. The design must pass check().
Detection detect(const TargetDesign& design, const Image& image, const DetectOptions& options = {});

/// A picture that is loaded when its turn comes. `key` names its content for the cache (see content_key());
/// empty: never cached.
struct PictureToDetect {
  std::string name, key;
  std::function<Result<Image>()> load;
};

struct DetectAllOptions {
  DetectOptions detect = {};
  int threads = 0;                      ///< 0: one per core; results do not depend on it
  std::filesystem::path cache = {};     ///< a folder that is made when needed; empty: no cache
  std::function<void()> progress = {};  ///< called after each picture, from any thread
};

/// detect() over many pictures in parallel; a picture that cannot be loaded becomes a Detection that says so.
/// A damaged or unwritable cache only costs time. Loads run on several threads at once.
std::vector<Detection> detect_all(const TargetDesign& design, std::span<const PictureToDetect> pictures,
                                  const DetectAllOptions& options = {});

/// One sentence about a camera's pictures: how many show the target, what went wrong in the others and the
/// likely cause.
std::string summary(std::span<const Detection> detections);

/// A name for a file's content, whatever it is called and wherever it lies. NotFound, Io.
Result<std::string> content_key(const std::filesystem::path& file);

/// The cache's file format, exposed for tests: one text file a picture.
std::string to_text(const Detection& detection);
Result<Detection> parse_detection(std::string_view text, std::string_view name_for_errors);

}  // namespace floatstage::calib
