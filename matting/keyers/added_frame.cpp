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
    Image rgb;  // unless it is that already, and is looked at where it lies
    if (frame.layout.format != PixelFormat::Rgb8)
      if (Result<void> ok = to_rgb(frame, rgb); !ok) return forward(ok);
    const int width = frame.layout.width, height = frame.layout.height;
    PixelBox box = floatstage::inside(bars_, width, height);
    if (box.empty()) return keyer_->key(frame);
    const auto part = crop(rgb.empty() ? frame : borrowed_frame(frame.info, rgb), box);
    if (!part) return forward(part);
    const auto matte = keyer_->key(*part);
    if (!matte) return forward(matte);
    Image alpha(width, height, 1);
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
