#include "apps/viewer/mattes/matte_picture.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::apps {
namespace {

using testing::ElementsAre;

std::vector<int> pixel(const Image& image, int x, int y) {
  const std::uint8_t* p = image.at(x, y);
  return {p[0], p[1], p[2]};
}

// 32x16 of one colour; opacity 0 at the left, 128 in the middle, 255 at the right. Before, all of it was half
// opaque.
MatteViewInput stripes() {
  MatteViewInput in;
  in.photograph = Image(32, 16, 3);
  in.matte = Image(32, 16, 1);
  in.before = Image(32, 16, 1, 128);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      in.photograph.at(x, y)[0] = 200, in.photograph.at(x, y)[1] = 100, in.photograph.at(x, y)[2] = 50;
      *in.matte.at(x, y) = x < 10 ? 0 : x < 20 ? 128 : 255;
    }
  return in;
}

TEST(MattePicture, ShowsThePhotographAsItIs) {
  EXPECT_EQ(matte_picture(MatteView::Photograph, stripes()), stripes().photograph);
}

TEST(MattePicture, LaysTheSubjectOverAChessboard) {
  const Image out = matte_picture(MatteView::Checker, stripes());
  EXPECT_THAT(pixel(out, 0, 0), ElementsAre(96, 96, 96));
  EXPECT_THAT(pixel(out, 8, 0), ElementsAre(160, 160, 160));
  EXPECT_THAT(pixel(out, 8, 8), ElementsAre(96, 96, 96));
  EXPECT_THAT(pixel(out, 16, 0),
              ElementsAre((128 * 200 + 127 * 96 + 127) / 255, (128 * 100 + 127 * 96 + 127) / 255,
                          (128 * 50 + 127 * 96 + 127) / 255));
  EXPECT_THAT(pixel(out, 31, 15), ElementsAre(200, 100, 50));
}

TEST(MattePicture, LaysTheSubjectOverAColour) {
  MatteViewInput in = stripes();
  in.color = {0, 0, 255};
  const Image out = matte_picture(MatteView::Color, in);
  EXPECT_THAT(pixel(out, 0, 0), ElementsAre(0, 0, 255));
  EXPECT_THAT(pixel(out, 15, 5), ElementsAre((128 * 200 + 127) / 255, (128 * 100 + 127) / 255,
                                             (128 * 50 + 127 * 255 + 127) / 255));
  EXPECT_THAT(pixel(out, 25, 5), ElementsAre(200, 100, 50));
}

TEST(MattePicture, ShowsOpacityAsGrey) {
  const Image out = matte_picture(MatteView::Matte, stripes());
  EXPECT_THAT(pixel(out, 0, 0), ElementsAre(0, 0, 0));
  EXPECT_THAT(pixel(out, 15, 0), ElementsAre(128, 128, 128));
  EXPECT_THAT(pixel(out, 25, 0), ElementsAre(255, 255, 255));
}

TEST(MattePicture, ShowsWhatCameInGreenAndWhatWentInRed) {
  MatteViewInput in = stripes();
  const Image out = matte_picture(MatteView::Difference, in);
  EXPECT_THAT(pixel(out, 0, 0), ElementsAre(128, 0, 0)) << "went";
  EXPECT_THAT(pixel(out, 15, 0), ElementsAre(64, 64, 64)) << "stayed";
  EXPECT_THAT(pixel(out, 25, 0), ElementsAre(64, 191, 64)) << "came";
  in.before = {};
  EXPECT_THAT(pixel(matte_picture(MatteView::Difference, in), 25, 0), ElementsAre(127, 127, 127))
      << "the first frame";
}

TEST(MattePicture, DimsThePhotographWhereThereIsNoMatteYet) {
  MatteViewInput in = stripes();
  EXPECT_THAT(pixel(matte_picture(MatteView::Labels, in), 3, 3), ElementsAre(66, 33, 16))
      << "nobody has divided it";
  in.matte = {};
  for (MatteView view : {MatteView::Checker, MatteView::Color, MatteView::Matte, MatteView::Difference,
                         MatteView::Components, MatteView::Labels})
    EXPECT_THAT(pixel(matte_picture(view, in), 3, 3), ElementsAre(66, 33, 16));
  in.matte = Image(4, 4, 1);
  EXPECT_THAT(pixel(matte_picture(MatteView::Matte, in), 3, 3), ElementsAre(66, 33, 16))
      << "a matte of another picture is none";
}

TEST(MattePicture, GivesEveryComponentItsColour) {
  MatteViewInput in = stripes();
  in.components.width = 8, in.components.height = 4;  // a quarter of the size
  in.components.alpha = Eigen::MatrixXf::Zero(32, 3);
  for (int p = 0; p < 32; ++p) in.components.alpha(p, p % 8 < 4 ? 0 : 2) = 1;
  const Image out = matte_picture(MatteView::Components, in);
  const double brightness = 0.35 + 0.65 * (200 + 2 * 100 + 50) / 1020.0;
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(out.at(0, 0)[c],
              static_cast<int>(component_color(0)[static_cast<std::size_t>(c)] * brightness));
    EXPECT_EQ(out.at(15, 15)[c],
              static_cast<int>(component_color(0)[static_cast<std::size_t>(c)] * brightness));
    EXPECT_EQ(out.at(16, 0)[c],
              static_cast<int>(component_color(2)[static_cast<std::size_t>(c)] * brightness));
  }
  std::set<std::array<std::uint8_t, 3>> colors;
  for (int k = 0; k < 16; ++k) colors.insert(component_color(k));
  EXPECT_EQ(colors.size(), 16u);
}

TEST(MattePicture, GivesEveryLabelItsColourWhereItIs) {
  MatteViewInput in = stripes();
  in.labels = {Image(32, 16, 1), Image(), Image(32, 16, 1)};
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      *in.labels[0].at(x, y) = x < 20 ? *in.matte.at(x, y) : 0;
      *in.labels[2].at(x, y) = x >= 24 ? 255 : 0;
    }
  const Image out = matte_picture(MatteView::Labels, in);
  const double brightness = 0.35 + 0.65 * (200 + 2 * 100 + 50) / 1020.0;
  const auto mixed = [&](int label, int alpha) {
    std::vector<int> rgb;
    for (std::size_t c = 0; c < 3; ++c)
      rgb.push_back(static_cast<int>(brightness * component_color(label)[c] * alpha / 255 +
                                     (255 - alpha) / 255.0 * std::vector{200, 100, 50}[c] / 3));
    return rgb;
  };
  EXPECT_EQ(pixel(out, 5, 5), (std::vector{66, 33, 16})) << "surroundings";
  EXPECT_EQ(pixel(out, 15, 5), mixed(0, 128)) << "half of it shows what is behind";
  EXPECT_EQ(pixel(out, 28, 5), mixed(2, 255));
  EXPECT_EQ(pixel(out, 22, 5), std::vector<int>(3, static_cast<int>(brightness * 255))) << "nobody's";
}

TEST(MattePicture, NamesItsViewsInTheirOrder) {
  ASSERT_EQ(matte_view_names().size(), 7u);
  EXPECT_EQ(matte_view_names()[static_cast<std::size_t>(MatteView::Labels)], "labels");
  EXPECT_EQ(matte_view_names()[static_cast<std::size_t>(MatteView::Checker)], "checker");
  EXPECT_EQ(matte_view_names()[static_cast<std::size_t>(MatteView::Components)], "components");
}

}  // namespace
}  // namespace floatstage::apps
