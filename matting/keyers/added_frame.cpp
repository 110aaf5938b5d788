// Method:  even rows and columns at the sides, told from the stage by the step behind them

#include "matting/keyers/added_frame.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace floatstage::matting {
namespace {

constexpr int kEven = 4;       // 8-bit steps that codecs leave of one colour, up and down
constexpr int kMostShare = 4;  // a quarter of the picture a side

// The lines of one side, from the outside in.
struct Side {
  const Image* picture;
  bool columns, from_end;

  int lines() const { return columns ? picture->width : picture->height; }
  int length() const { return columns ? picture->height : picture->width; }
  const std::uint8_t* at(int line, int i) const {
    const int l = from_end ? lines() - 1 - line : line;
    return columns ? picture->at(l, i) : picture->at(i, l);
  }
  // How many pixels of a line are off the colour of the outermost one.
  int off(int line) const {
    const std::uint8_t* colour = at(0, length() / 2);
    int count = 0;
    for (int i = 0; i < length(); ++i) {
      const std::uint8_t* p = at(line, i);
      bool differs = false;
      for (int c = 0; c < 3; ++c) differs = differs || std::abs(p[c] - colour[c]) > kEven;
      count += differs;
    }
    return count;
  }
  int added() const {
    const int most = lines() / kMostShare;
    int even = 0;
    while (even <= most && off(even) == 0) ++even;
    return even > most || 2 * off(even) < length() ? 0 : even;
  }
};

class InsideKeyer : public Keyer {
 public:
  InsideKeyer(std::unique_ptr<Keyer> keyer, const AddedFrame& frame)
      : keyer_(std::move(keyer)), frame_(frame) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty() || frame.layout.format == PixelFormat::Gray8) return keyer_->key(frame);
    const auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (rgb->width <= frame_.left + frame_.right || rgb->height <= frame_.top + frame_.bottom)
      return keyer_->key(frame);
    const auto matte = keyer_->key(make_frame(frame.info, inside(*rgb, frame_)));
    if (!matte) return forward(matte);
    Image alpha(rgb->width, rgb->height, 1);
    for (int y = 0; y < matte->height; ++y)
      std::copy_n(matte->row(y), matte->width, alpha.at(frame_.left, frame_.top + y));
    return make_matte(frame.info, alpha);
  }

  Result<Image> suppress_spill(const Frame& frame) const override { return keyer_->suppress_spill(frame); }
  std::string spec() const override { return keyer_->spec(); }
  CleanupOptions cleanup() const override { return keyer_->cleanup(); }

 private:
  std::unique_ptr<Keyer> keyer_;
  AddedFrame frame_;
};

}  // namespace

AddedFrame added_frame(const std::vector<Image>& pictures) {
  AddedFrame all;
  bool first = true;
  for (const Image& p : pictures) {
    if (p.width != pictures.front().width || p.height != pictures.front().height) continue;
    const AddedFrame one{.left = Side{&p, true, false}.added(),
                         .top = Side{&p, false, false}.added(),
                         .right = Side{&p, true, true}.added(),
                         .bottom = Side{&p, false, true}.added()};
    if (first) all = one;
    first = false;
    for (int AddedFrame::*side :
         {&AddedFrame::left, &AddedFrame::top, &AddedFrame::right, &AddedFrame::bottom})
      all.*side = std::min(all.*side, one.*side);
  }
  return all;
}

Image inside(const Image& picture, const AddedFrame& f) {
  Image part(picture.width - f.left - f.right, picture.height - f.top - f.bottom, picture.channels);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(picture.at(f.left, f.top + y), static_cast<std::size_t>(part.width * part.channels),
                part.at(0, y));
  return part;
}

std::unique_ptr<Keyer> inside_keyer(std::unique_ptr<Keyer> keyer, const AddedFrame& frame) {
  return std::make_unique<InsideKeyer>(std::move(keyer), frame);
}

}  // namespace floatstage::matting
