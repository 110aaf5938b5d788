#include <algorithm>
#include <vector>

#include "core/text.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/plate_measure.h"

namespace floatstage::matting {
namespace {

constexpr CleanupOptions kDefaultCleanup{.close_radius = 1, .smallest_island = 0.02, .smallest_hole = 0.001};
// The plate in the subject's shadow is at most this much darker, in its reflected light this much brighter.
constexpr PlateLight kLight{.darkest = 0.55f, .brightest = 1.15f};

// The median of each byte; of an even number of pictures the mean of the middle two.
Image median_of(const std::vector<Image>& pictures) {
  if (pictures.size() == 1) return pictures.front();
  Image median = pictures.front();
  std::vector<std::uint8_t> values(pictures.size());
  const std::size_t half = values.size() / 2;
  for (std::size_t i = 0; i < median.pixels.size(); ++i) {
    for (std::size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k].pixels[i];
    std::sort(values.begin(), values.end());
    median.pixels[i] = values.size() % 2
                           ? values[half]
                           : static_cast<std::uint8_t>((values[half - 1] + values[half] + 1) / 2);
  }
  return median;
}

PlateMeasure measure_of(Image plate, float threshold) {
  std::vector<float> thresholds(plate.pixels.size() / 3, threshold);
  return PlateMeasure(std::move(plate), std::move(thresholds), kLight, threshold, 0);
}

class DifferenceKeyer : public Keyer {
 public:
  DifferenceKeyer(Image plate, int threshold, const CleanupOptions& cleanup)
      : measure_(measure_of(std::move(plate), static_cast<float>(threshold))),
        threshold_(threshold),
        cleanup_(cleanup) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (rgb->width != measure_.width() || rgb->height != measure_.height())
      return fail(ErrorCode::InvalidArgument,
                  text("camera ", frame.info.camera, ": its frame is ", rgb->width, "x", rgb->height,
                       " but its clean plate is ", measure_.width(), "x", measure_.height(),
                       "; record the plate with the take's settings"));
    return make_matte(frame.info, measure_.key(*rgb, cleanup_));
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override { return to_rgb(frame, rgb); }
  std::string spec() const override { return text("difference:", threshold_); }
  CleanupOptions cleanup() const override { return cleanup_; }
  const RowMeasure* rows() const override { return &measure_; }

 private:
  PlateMeasure measure_;
  int threshold_;
  CleanupOptions cleanup_;
};

}  // namespace

Result<std::unique_ptr<Keyer>> make_difference_keyer(const KeyerRequest& request) {
  const auto threshold = threshold_of(request, "difference", 24);
  if (!threshold) return forward(threshold);
  if (request.samples.empty())
    return fail(ErrorCode::InvalidArgument,
                "the difference keyer needs a clean plate of each camera; record one of the empty stage");
  const Image& first = request.samples.front();
  for (const Image& sample : request.samples)
    if (sample.width != first.width || sample.height != first.height)
      return fail(ErrorCode::InvalidArgument,
                  text("the clean plates of a camera differ in size: ", first.width, "x", first.height,
                       " and ", sample.width, "x", sample.height, "; give plates of one size"));
  return std::unique_ptr<Keyer>(
      new DifferenceKeyer(median_of(request.samples), *threshold, request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage::matting
