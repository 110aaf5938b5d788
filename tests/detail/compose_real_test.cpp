// What arrives of a close photograph in the wide one, on photographs (../shared/data/detail).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/stitching.hpp>

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

/// A wide photograph and one `zoom` times as close, with other tones, cut out of one.
struct WideAndClose {
  Image truth, wide, close;
};

WideAndClose cut_out_of(const Image& photo, int zoom) {
  WideAndClose pair{cropped(photo, 1000, 300, 2048, 1536), Image(2048 / zoom, 1536 / zoom, 3), {}};
  pair.close = cropped(pair.truth, 700, 500, 800, 600);
  cv::Mat to = matrix_of(pair.wide);
  cv::resize(matrix_of(pair.truth), to, to.size(), 0, 0, cv::INTER_AREA);
  for (std::uint8_t& v : pair.close.pixels) v = static_cast<std::uint8_t>(0.9 * v + 5);
  return pair;
}

// How many of the close photograph's pixels a picture has one for, linear; 0: it is not in it.
double pixels_lost(const Image& close, const Image& picture) {
  const PhotoFeatures of_close = find_features(close), of_picture = find_features(picture);
  return relate(of_close, of_picture, nearest_both_ways(of_close, of_picture).of_a).zoom;
}

TEST(ACloseFur, KeepsItsFinestOctaveInTheWidePicture) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<Image> photo = load_photo(real_data("detail/panda/panda.jpg"));
  ASSERT_THAT(photo, IsOk());
  const WideAndClose pair = cut_out_of(*photo, 4);
  const TempFolder folder;
  ASSERT_THAT(save_png(pair.wide, folder / "wide.png"), IsOk());
  ASSERT_THAT(save_png(pair.close, folder / "close.png"), IsOk());
  const Result<PhotoGraph> graph = build_photo_graph(folder.path(), {});
  ASSERT_THAT(graph, IsOk());
  ASSERT_EQ(graph->photos[0].parent, 1);
  ComposeOptions options;
  options.zoom = 4;
  const Result<Composition> made = compose(*graph, options);
  ASSERT_THAT(made, IsOk());
  const Image inside = cropped(made->picture, 980, 680, 240, 240),
              real = cropped(pair.truth, 980, 680, 240, 240);
  const double decibels = 10 * std::log10(top_octave(inside) / top_octave(real));
  RecordProperty("decibels", text(decibels));
  RecordProperty("psnr", text(psnr(inside, real)));
  RecordProperty("lost", text(pixels_lost(pair.close, made->picture)));
  EXPECT_GT(decibels, -1);
  EXPECT_LT(decibels, 1);
  EXPECT_GT(psnr(inside, real), 30);
  EXPECT_NEAR(pixels_lost(pair.close, made->picture), 1, 0.01);
}

TEST(ACloseFur, LosesItThroughAProgramForPanoramas) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<Image> photo = load_photo(real_data("detail/panda/panda.jpg"));
  ASSERT_THAT(photo, IsOk());
  const WideAndClose pair = cut_out_of(*photo, 2);  // at four it gives up
  for (const auto mode : {cv::Stitcher::PANORAMA, cv::Stitcher::SCANS}) {
    cv::Mat stitched;
    const std::vector<cv::Mat> both = {matrix_of(pair.wide), matrix_of(pair.close)};
    const auto status = cv::Stitcher::create(mode)->stitch(both, stitched);
    const std::string name = mode == cv::Stitcher::PANORAMA ? "panorama" : "scans";
    RecordProperty(name + "_status", static_cast<int>(status));
    if (status != cv::Stitcher::OK) continue;  // it gave up: nothing arrives at all
    stitched.convertTo(stitched, CV_8U);
    Image picture(stitched.cols, stitched.rows, 3);
    stitched.copyTo(cv::Mat(matrix_of(picture)));
    const double lost = pixels_lost(pair.close, picture);
    RecordProperty(name + "_lost", text(lost));
    EXPECT_TRUE(lost == 0 || lost > 1.2) << name << " " << lost;
  }
}

}  // namespace
}  // namespace floatstage::detail
