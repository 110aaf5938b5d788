#include "calib/detect.h"

#include <algorithm>
#include <array>
#include <map>

#include "calib/board_detection.h"
#include "calib/detection_cache.h"
#include "calib/grey.h"
#include "core/check.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

struct FailureName {
  DetectionFailure failure;
  const char* name;
  const char* words;  // for the summary
};

constexpr FailureName kFailures[] = {
    {DetectionFailure::None, "none", "found"},
    {DetectionFailure::Unreadable, "unreadable", "could not be read"},
    {DetectionFailure::NothingLikeIt, "nothing-like-it", "show nothing like it"},
    {DetectionFailure::CutOff, "cut-off", "cut it off"},
    {DetectionFailure::PartlyHidden, "partly-hidden", "show too little of it"},
    {DetectionFailure::Blurred, "blurred", "are blurred"},
    {DetectionFailure::TooDark, "too-dark", "have no contrast"},
    {DetectionFailure::InvertedPrint, "inverted-print", "show it with black and white exchanged"},
    {DetectionFailure::MirroredPrint, "mirrored-print", "show it mirrored"},
    {DetectionFailure::SwappedRowsAndColumns, "swapped-rows-and-columns",
     "show it with rows and columns exchanged"},
    {DetectionFailure::WrongCount, "wrong-count", "show a chessboard of another size"},
    {DetectionFailure::WrongDictionary, "wrong-dictionary", "show markers of another dictionary"},
    {DetectionFailure::OtherNumbers, "other-numbers", "show markers with other numbers"},
};

const FailureName& entry(DetectionFailure failure) {
  for (const FailureName& f : kFailures)
    if (f.failure == failure) return f;
  FLOATSTAGE_CHECK(false, "a detection failure without a name");
}

// A mistake in how the target was described, not in how it was shown.
bool is_description(DetectionFailure f) {
  return f == DetectionFailure::InvertedPrint || f == DetectionFailure::MirroredPrint ||
         f == DetectionFailure::SwappedRowsAndColumns || f == DetectionFailure::WrongCount ||
         f == DetectionFailure::WrongDictionary || f == DetectionFailure::OtherNumbers;
}

}  // namespace

const char* name_of(DetectionFailure failure) { return entry(failure).name; }

std::optional<DetectionFailure> detection_failure_named(std::string_view name) {
  for (const FailureName& f : kFailures)
    if (name == f.name) return f.failure;
  return std::nullopt;
}

Detection detect(const TargetDesign& design, const Image& image, const DetectOptions& options) {
  Detection detection;
  if (image.width < 32 || image.height < 32) {
    detection.failure = DetectionFailure::Unreadable;
    detection.reason =
        text("a picture of ", image.width, "x", image.height, " px is too small for any target");
    return detection;
  }
  const cv::Mat grey = grey_of(image);
  const Wand* wand = std::get_if<Wand>(&design);
  const BoardSearch search = wand ? find_wand(grey, *wand) : find_board(grey, design, Effort::Full);
  const int least = wand ? static_cast<int>(wand->positions.size()) : options.least_points;
  if (static_cast<int>(search.points.size()) >= least) {
    for (const FoundPoint& p : search.points)
      detection.points.push_back(
          {p.id, {p.at.x + 0.5, p.at.y + 0.5}, options.sigma});  // OpenCV's first centre is 0
    return detection;
  }
  if (options.diagnose) return diagnose(grey, design, search, least);
  detection.failure =
      search.points.empty() ? DetectionFailure::NothingLikeIt : DetectionFailure::PartlyHidden;
  detection.reason = search.points.empty() ? "nothing in the picture resembles the target"
                                           : "too little of the target is visible";
  return detection;
}

std::vector<Detection> detect_all(const TargetDesign& design, std::span<const PictureToDetect> pictures,
                                  const DetectAllOptions& options) {
  std::vector<Detection> detections(pictures.size());
  const DetectionCache cache(options.cache, design, options.detect);
  parallel_for(pictures.size(), options.threads, [&](std::size_t i) {
    const PictureToDetect& picture = pictures[i];
    Detection& result = detections[i];
    if (std::optional<Detection> known = cache.find(picture.key)) {
      result = std::move(*known);
    } else if (const Result<Image> image = picture.load(); !image) {
      result.failure = DetectionFailure::Unreadable;
      result.reason = image.error().message;  // not cached: the file may be whole next time
    } else {
      result = detect(design, *image, options.detect);
      cache.store(picture.key, result);
    }
    if (options.progress) options.progress();
  });
  return detections;
}

std::string summary(std::span<const Detection> detections) {
  std::map<DetectionFailure, std::size_t> counts;
  for (const Detection& d : detections) ++counts[d.failure];
  std::string sentence = text("the target was found in ", counts[DetectionFailure::None], " of ",
                              detections.size(), " pictures");
  DetectionFailure likely = DetectionFailure::None;
  const char* between = ": ";
  for (const FailureName& f : kFailures) {
    const std::size_t count = counts[f.failure];
    if (f.failure == DetectionFailure::None || count == 0) continue;
    sentence += text(between, count, " ", f.words);
    between = ", ";
    if (is_description(f.failure) && (likely == DetectionFailure::None || count > counts[likely]))
      likely = f.failure;
  }
  // One accidental reading is no diagnosis; a description that is wrong shows in most of what was not found.
  if (likely == DetectionFailure::None || counts[likely] <= counts[DetectionFailure::None]) return sentence;
  for (const Detection& d : detections)
    if (d.failure == likely) return text(sentence, "; likely cause: ", d.reason);
  return sentence;
}

}  // namespace floatstage::calib
