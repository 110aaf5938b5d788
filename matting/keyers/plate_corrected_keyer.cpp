#include "matting/keyers/plate_corrected_keyer.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "matting/keyers/empty_stage.h"

namespace floatstage::matting {
namespace {

class PlateCorrectedKeyer : public Keyer {
 public:
  PlateCorrectedKeyer(std::unique_ptr<Keyer> keyer, EmptyStage stage)
      : keyer_(std::move(keyer)), stage_(std::move(stage)) {}

  Result<Matte> key(const Frame& frame) const override {
    Result<Matte> key = keyer_->key(frame);
    if (!key || key->empty()) return key;
    const Result<Image> rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    Image alpha = to_image(*key);
    stage_.correct(*rgb, alpha);
    return make_matte(frame.info, alpha);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override {
    return keyer_->suppress_spill(frame, rgb);
  }
  std::string spec() const override { return keyer_->spec(); }
  CleanupOptions cleanup() const override { return keyer_->cleanup(); }
  const RowMeasure* rows() const override { return keyer_->rows(); }
  const EmptyStage* empty_stage() const override { return &stage_; }

 private:
  std::unique_ptr<Keyer> keyer_;
  EmptyStage stage_;
};

bool by_colour(const Keyer& keyer) {
  const std::string spec = keyer.spec();
  const std::string_view word = std::string_view(spec).substr(0, spec.find(':'));
  return word == "chroma" || word == "luminance";
}

bool in_colour_and_of_one_size(const std::vector<Image>& plates) {
  return !plates.empty() && std::all_of(plates.begin(), plates.end(), [&](const Image& p) {
    return p.channels == 3 && p.width == plates.front().width && p.height == plates.front().height;
  });
}

}  // namespace

Result<std::unique_ptr<Keyer>> corrected_by_plate(std::unique_ptr<Keyer> keyer,
                                                  const std::vector<Image>& plates) {
  if (!by_colour(*keyer) || !in_colour_and_of_one_size(plates)) return keyer;
  Result<Plate> plate = learn_plate(plates);
  if (!plate) return forward(plate);
  std::optional<EmptyStage> stage = EmptyStage::seen_by(*keyer, std::move(*plate));
  if (!stage) return keyer;
  return std::unique_ptr<Keyer>(new PlateCorrectedKeyer(std::move(keyer), std::move(*stage)));
}

}  // namespace floatstage::matting
