// What arrives of a close photograph in the wide one, on photographs (../shared/data/detail).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/png.h"
#include "detail/compose.h"
#include "detail/float_picture.h"
#include "detail/photo_file.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

Image cropped(const Image& image, int x, int y, int width, int height) {
  Image out(width, height, 3);
  for (int row = 0; row < height; ++row) std::copy_n(image.at(x, y + row), 3 * width, out.at(0, row));
  return out;
}

cv::Mat matrix_of(const Image& image) {
  return {image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data())};
}

// Power between a quarter and half a cycle a pixel: what only the close photograph can have.
double top_octave(const Image& image) {
  cv::Mat grey, window;
  cv::cvtColor(matrix_of(image), grey, cv::COLOR_RGB2GRAY);
  grey.convertTo(grey, CV_32F);
  cv::createHanningWindow(window, grey.size(), CV_32F);
  grey = (grey - cv::mean(grey)[0]).mul(window);
  cv::Mat spectrum;
  cv::dft(grey, spectrum, cv::DFT_COMPLEX_OUTPUT);
  double power = 0;
  for (int y = 0; y < spectrum.rows; ++y)
    for (int x = 0; x < spectrum.cols; ++x) {
      const double fx = std::min(x, spectrum.cols - x) / static_cast<double>(spectrum.cols),
                   fy = std::min(y, spectrum.rows - y) / static_cast<double>(spectrum.rows);
      const double f = std::hypot(fx, fy);
      if (f < 0.25 || f > 0.5) continue;
      const auto& c = spectrum.at<cv::Vec2f>(y, x);
      power += static_cast<double>(c[0] * c[0] + c[1] * c[1]);
    }
  return power;
}

TEST(ACloseFur, KeepsItsFinestOctaveInTheWidePicture) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<Image> photo = load_photo(real_data("detail/panda/panda.jpg"));
  ASSERT_THAT(photo, IsOk());
  const Image truth = cropped(*photo, 1000, 300, 2048, 1536);
  Image wide(512, 384, 3), close = cropped(truth, 700, 500, 800, 600);
  cv::Mat to = matrix_of(wide);
  cv::resize(matrix_of(truth), to, to.size(), 0, 0, cv::INTER_AREA);
  for (std::uint8_t& v : close.pixels) v = static_cast<std::uint8_t>(0.9 * v + 5);
  const TempFolder folder;
  ASSERT_THAT(save_png(wide, folder / "wide.png"), IsOk());
  ASSERT_THAT(save_png(close, folder / "close.png"), IsOk());
  const Result<PhotoGraph> graph = build_photo_graph(folder.path(), {});
  ASSERT_THAT(graph, IsOk());
  ASSERT_EQ(graph->photos[0].parent, 1);
  ComposeOptions options;
  options.zoom = 4;
  const Result<Composition> made = compose(*graph, options);
  ASSERT_THAT(made, IsOk());
  const Image inside = cropped(made->picture, 980, 680, 240, 240), real = cropped(truth, 980, 680, 240, 240);
  const double decibels = 10 * std::log10(top_octave(inside) / top_octave(real));
  RecordProperty("decibels", text(decibels));
  RecordProperty("psnr", text(psnr(inside, real)));
  EXPECT_GT(decibels, -1);
  EXPECT_LT(decibels, 1);
  EXPECT_GT(psnr(inside, real), 30);
}

}  // namespace
}  // namespace floatstage::detail
