#include "matting/keyers/added_frame.h"

#include <algorithm>
#include <utility>

namespace floatstage::matting {
namespace {

class InsideKeyer : public Keyer {
 public:
  InsideKeyer(std::unique_ptr<Keyer> keyer, const AddedContent& bars)
      : keyer_(std::move(keyer)), bars_(bars) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty() || frame.layout.format == PixelFormat::Gray8) return keyer_->key(frame);
    const auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (rgb->width <= bars_.left + bars_.right || rgb->height <= bars_.top + bars_.bottom)
      return keyer_->key(frame);
    const auto matte = keyer_->key(make_frame(frame.info, inside(*rgb, bars_)));
    if (!matte) return forward(matte);
    Image alpha(rgb->width, rgb->height, 1);
    for (int y = 0; y < matte->height; ++y)
      std::copy_n(matte->row(y), matte->width, alpha.at(bars_.left, bars_.top + y));
    return make_matte(frame.info, alpha);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override {
    return keyer_->suppress_spill(frame, rgb);
  }
  std::string spec() const override { return keyer_->spec(); }
  CleanupOptions cleanup() const override { return keyer_->cleanup(); }

 private:
  std::unique_ptr<Keyer> keyer_;
  AddedContent bars_;
};

}  // namespace

Image inside(const Image& picture, const AddedContent& bars) {
  const PixelBox box = floatstage::inside(bars, picture.width, picture.height);
  Image part(box.width, box.height, picture.channels);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(picture.at(box.x, box.y + y), static_cast<std::size_t>(part.width * part.channels),
                part.at(0, y));
  return part;
}

std::unique_ptr<Keyer> inside_keyer(std::unique_ptr<Keyer> keyer, const AddedContent& bars) {
  return std::make_unique<InsideKeyer>(std::move(keyer), bars);
}

}  // namespace floatstage::matting
