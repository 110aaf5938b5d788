#include "calib/color.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

struct Published {
  Eigen::Vector3d a, b;
  double delta_e;
};

// Test data of Sharma, Wu & Dalal 2005, table 1.
const Published kSharma[] = {
    {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
    {{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
    {{50, 2.8361, -74.0200}, {50, 0, -82.7485}, 3.4412},
    {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
    {{50, -1.1848, -84.8006}, {50, 0, -82.7485}, 1.0000},
    {{50, -0.9009, -85.5211}, {50, 0, -82.7485}, 1.0000},
    {{50, 0, 0}, {50, -1, 2}, 2.3669},
    {{50, -1, 2}, {50, 0, 0}, 2.3669},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}, 7.1792},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0010}, 7.1792},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0011}, 7.2195},
    {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0012}, 7.2195},
    {{50, -0.0010, 2.4900}, {50, 0.0009, -2.4900}, 4.8045},
    {{50, -0.0010, 2.4900}, {50, 0.0010, -2.4900}, 4.8045},
    {{50, -0.0010, 2.4900}, {50, 0.0011, -2.4900}, 4.7461},
    {{50, 2.5, 0}, {50, 0, -2.5}, 4.3065},
    {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
    {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
    {{50, 2.5, 0}, {56, -27, -3}, 31.9030},
    {{50, 2.5, 0}, {58, 24, 15}, 19.4535},
    {{50, 2.5, 0}, {50, 3.1736, 0.5854}, 1.0000},
    {{50, 2.5, 0}, {50, 3.2972, 0}, 1.0000},
    {{50, 2.5, 0}, {50, 1.8634, 0.5757}, 1.0000},
    {{50, 2.5, 0}, {50, 3.2592, 0.3350}, 1.0000},
    {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
    {{63.0109, -31.0961, -5.8663}, {62.8187, -29.7946, -4.0864}, 1.2630},
    {{61.2901, 3.7196, -5.3901}, {61.4292, 2.2480, -4.9620}, 1.8731},
    {{35.0831, -44.1164, 3.7933}, {35.0232, -40.0716, 1.5901}, 1.8645},
    {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
    {{36.4612, 47.8580, 18.3852}, {36.2715, 50.5065, 21.2231}, 1.4146},
    {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
    {{90.9257, -0.5406, -0.9208}, {88.6381, -0.8985, -0.7239}, 1.5381},
    {{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
    {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
};

TEST(DeltaE2000, AgreesWithThePublishedPairs) {
  for (const Published& p : kSharma)
    EXPECT_NEAR(delta_e_2000(p.a, p.b), p.delta_e, 5e-5) << p.a.transpose() << " | " << p.b.transpose();
}

TEST(DeltaE2000, IsSymmetricAndZeroForTheSame) {
  for (const Published& p : kSharma) {
    EXPECT_NEAR(delta_e_2000(p.b, p.a), delta_e_2000(p.a, p.b), 1e-12);
    EXPECT_EQ(delta_e_2000(p.a, p.a), 0);
  }
}

TEST(Lab, OfWhiteBlackAndGreyIsOnTheGreyAxis) {
  EXPECT_LT((lab_from_srgb({1, 1, 1}) - Eigen::Vector3d(100, 0, 0)).norm(), 0.02);
  EXPECT_LT(lab_from_srgb({0, 0, 0}).norm(), 1e-9);
  EXPECT_NEAR(lab_from_srgb({0.5, 0.5, 0.5}).x(), 53.389, 0.01);
}

// A camera with its own white balance, crosstalk and gamma looks at a colour that an sRGB-like camera sees as
// `rgb`.
struct OddCamera {
  Eigen::Vector3d gain, gamma;
  double crosstalk;
  Eigen::Vector3d see(const Eigen::Vector3d& rgb) const {
    Eigen::Vector3d light = rgb.array().pow(2.2);
    light = ((1 - 2 * crosstalk) * light).array() + crosstalk * (light.sum() - light.array());
    return (gain.array() * light.array()).min(1.0).pow(1 / gamma.array());
  }
};
const OddCamera kOdd[] = {{{0.8, 0.9, 0.6}, {2.2, 2.2, 2.2}, 0},
                          {{0.6, 0.85, 0.95}, {1.8, 1.8, 1.8}, 0.03},
                          {{0.9, 0.7, 0.5}, {2.5, 2.4, 2.6}, 0.05}};

TEST(FitColor, BringsOddCamerasTogetherByTheChart) {
  for (const OddCamera& camera : kOdd) {
    std::vector<ColorPair> pairs;
    for (const Eigen::Vector3d& rgb : chart_colors()) {
      Eigen::Vector3d seen = camera.see(rgb);
      for (double& v : seen) v = std::round(255 * v) / 255;  // as pictures have it
      pairs.push_back({seen, rgb});
    }
    const Result<ColorFit> fit = fit_color(pairs);
    ASSERT_THAT(fit, IsOk());
    EXPECT_LE(fit->mean_delta_e, 0.7);
    EXPECT_GT(fit->mean_before, 3);
    // What it is for: colours that are not on the chart.
    Random random(3);
    double worst = 0, mean = 0;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d rgb(random.uniform(0.15, 0.95), random.uniform(0.15, 0.95),
                                random.uniform(0.15, 0.95));
      const double off =
          delta_e_2000(lab_from_srgb(apply(fit->transform, camera.see(rgb))), lab_from_srgb(rgb));
      worst = std::max(worst, off), mean += off / 200;
    }
    EXPECT_LE(mean, 0.7);
    EXPECT_LE(worst, 1.5);
  }
}

TEST(FitColor, BearsWrongPairsFromOverlap) {
  Random random(7);
  std::vector<ColorPair> pairs;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d rgb(random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9));
    Eigen::Vector3d seen = kOdd[1].see(rgb);
    for (double& v : seen) v += 0.01 * random.normal();
    pairs.push_back({seen.cwiseMax(0.0), rgb});
    if (i % 10 == 0)
      pairs.back().wanted = {random.uniform(), random.uniform(), random.uniform()};  // another surface
  }
  const Result<ColorFit> fit = fit_color(pairs);
  ASSERT_THAT(fit, IsOk());
  double mean = 0;
  for (const Eigen::Vector3d& rgb : chart_colors())
    mean += delta_e_2000(lab_from_srgb(apply(fit->transform, kOdd[1].see(rgb))), lab_from_srgb(rgb)) / 24;
  EXPECT_LE(mean, 1.5);
}

TEST(FitColor, RefusesWhatSaysTooLittle) {
  EXPECT_THAT(fit_color(std::vector<ColorPair>(30, ColorPair{{1, 1, 1}, {0.5, 0.5, 0.5}})),
              FailsWith(ErrorCode::BadData, "exposed"));
  EXPECT_THAT(fit_color(std::vector<ColorPair>(30, ColorPair{{0.4, 0.4, 0.4}, {0.5, 0.5, 0.5}})),
              FailsWith(ErrorCode::BadData, "too much alike"));
  const double nan = std::nan("");
  EXPECT_THAT(fit_color(std::vector<ColorPair>(30, ColorPair{{nan, 0.4, 0.4}, {0.5, 0.5, 0.5}})),
              FailsWith(ErrorCode::BadData, "0 of 30"));
}

Image chart_picture(const OddCamera* camera) {
  Image image(720, 520, 3, 25);
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3d rgb = chart_colors()[static_cast<std::size_t>(i)],
                          seen = camera ? camera->see(rgb) : rgb;
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 80; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(70 + i % 6 * 100 + x, 70 + i / 6 * 100 + y)[c] =
              static_cast<std::uint8_t>(std::lround(255 * seen[c]));
  }
  return image;
}

TEST(ColorChart, IsFoundAndReadInAPicture) {
  const auto colors = find_color_chart(chart_picture(nullptr));
  ASSERT_THAT(colors, IsOk());
  for (std::size_t i = 0; i < 24; ++i) EXPECT_LT(((*colors)[i] - chart_colors()[i]).norm(), 0.02) << i;
}

TEST(ColorChart, OfTwoCamerasMakesThemAgree) {
  const auto plain = find_color_chart(chart_picture(nullptr)),
             odd = find_color_chart(chart_picture(&kOdd[0]));
  ASSERT_THAT(plain, IsOk());
  ASSERT_THAT(odd, IsOk());
  std::vector<ColorPair> pairs;
  for (std::size_t i = 0; i < 24; ++i) pairs.push_back({(*odd)[i], (*plain)[i]});
  const Result<ColorFit> fit = fit_color(pairs);
  ASSERT_THAT(fit, IsOk());
  EXPECT_LE(fit->mean_delta_e, 1.0);
  EXPECT_LE(fit->p95_delta_e, 1.5);
}

TEST(ColorChart, IsNotSeenWhereThereIsNone) {
  EXPECT_THAT(find_color_chart(Image(640, 480, 3, 90)), FailsWith(ErrorCode::NotFound, "colour chart"));
  EXPECT_THAT(find_color_chart(Image(640, 480, 1)), FailsWith(ErrorCode::InvalidArgument, "three channels"));
}

}  // namespace
}  // namespace floatstage::calib
