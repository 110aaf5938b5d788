#include "tests/support/burnt_in.h"

#include <algorithm>
#include <span>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "core/jpeg.h"

namespace floatstage {

PixelBox burn_in(const Stamp& stamp, Image& picture) {
  cv::Mat rgb(picture.height, picture.width, CV_8UC3, picture.pixels.data());
  const int tall = std::max(7, static_cast<int>(stamp.size * picture.height));
  const double scale = cv::getFontScaleFromHeight(stamp.font, tall, 1);
  const int thick = std::max(1, tall / 12),
            around = stamp.look == StampLook::Plain ? 0 : std::max(2, tall / 5);
  int below = 0;
  const cv::Size size = cv::getTextSize(stamp.words, stamp.font, scale, thick, &below);
  const cv::Point corner(static_cast<int>(stamp.x * picture.width),
                         static_cast<int>(stamp.y * picture.height));
  const cv::Point foot(corner.x + around, corner.y + around + size.height);
  const cv::Rect all(corner.x, corner.y, size.width + 2 * around, size.height + below + 2 * around);
  const cv::Scalar black(0, 0, 0), white(255, 255, 255);
  if (stamp.look == StampLook::Boxed) cv::rectangle(rgb, all, black, cv::FILLED);
  if (stamp.look == StampLook::Outlined)
    cv::putText(rgb, stamp.words, foot, stamp.font, scale, black, thick + 2, cv::LINE_AA);
  cv::putText(rgb, stamp.words, foot, stamp.font, scale, stamp.look == StampLook::Dark ? black : white, thick,
              cv::LINE_AA);
  const cv::Rect in = all & cv::Rect(0, 0, picture.width, picture.height);
  return {in.x, in.y, in.width, in.height};
}

Image with_bars(Image picture, const AddedContent& bars, std::uint8_t grey) {
  const PixelBox part = inside(bars, picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (x < part.x || y < part.y || x >= part.x + part.width || y >= part.y + part.height)
        std::fill_n(picture.at(x, y), picture.channels, grey);
  return picture;
}

Image coded(const Image& picture, int quality) {
  const std::string jpeg = encode_jpeg(picture, quality);
  Result<Image> read = decode_jpeg(std::as_bytes(std::span(jpeg)), picture.width, picture.height);
  FLOATSTAGE_CHECK(read.has_value(), "a JPEG of our own is read");
  return *read;
}

}  // namespace floatstage
