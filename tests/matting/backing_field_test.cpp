#include "matting/keyers/backing_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/matting/pictures.h"

namespace floatstage::matting {

// What BackingField does with a picture, over whole pictures of floats and labels.
struct BackingFieldReference {
  static Image key(const BackingField& field, const Image& picture);
  static void fill_holes(const BackingField& field, const Image& picture, Image& alpha);
  static void solve_edges(const BackingField& field, const Image& picture, Image& alpha);
};

namespace {

constexpr double kLargestHole = 0.03;

float length(const float* w, float r, float g, float b) {
  const float x = w[0] * r, y = w[1] * r + w[2] * g, z = w[3] * r + w[4] * g + w[5] * b;
  return std::sqrt(x * x + y * y + z * z);
}

cv::Mat square(int radius) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
}

cv::Vec3f roots(const cv::Vec3f& c) {
  return {std::sqrt(std::max(c[0], 0.0f)), std::sqrt(std::max(c[1], 0.0f)), std::sqrt(std::max(c[2], 0.0f))};
}

// Of millions of pixels some thousand are off by chance; what is off together is a thing.
void drop_specks(cv::Mat& alpha, int least) {
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(alpha >= 128, labels, stats, centroids, 8, CV_32S);
  std::vector<std::uint8_t> small(static_cast<std::size_t>(count), 0);
  for (int i = 1; i < count; ++i)
    small[static_cast<std::size_t>(i)] = stats.ptr<int>(i)[cv::CC_STAT_AREA] < least;
  for (int y = 0; y < alpha.rows; ++y)
    for (int x = 0; x < alpha.cols; ++x)
      if (small[static_cast<std::size_t>(labels.at<int>(y, x))]) alpha.at<std::uint8_t>(y, x) = 0;
}

cv::Rect grown_box(const cv::Mat& alpha, int by) {
  const cv::Rect box = cv::boundingRect(alpha);
  if (box.empty()) return box;
  return cv::Rect(box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by) &
         cv::Rect(0, 0, alpha.cols, alpha.rows);
}

}  // namespace

Image BackingFieldReference::key(const BackingField& field, const Image& picture) {
  const std::vector<float> pixels = field.distances(picture, BackingField::Scale::Pixel),
                           cells = field.distances(picture, BackingField::Scale::Cell);
  Image alpha(picture.width, picture.height, 1), broad(picture.width, picture.height, 1);
  auto ramp = [&](float distance) {
    return static_cast<std::uint8_t>(
        std::clamp((distance / field.sigmas_ - 0.5f) * 255 + 0.5f, 0.0f, 255.0f));
  };
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
    alpha.pixels[i] = ramp(pixels[i]);
    broad.pixels[i] = ramp(cells[i]);
  }
  // The mean of a cell sees an edge half a cell before it is there.
  const cv::Mat wide(broad.height, broad.width, CV_8U, broad.pixels.data());
  cv::Mat narrow, out(alpha.height, alpha.width, CV_8U, alpha.pixels.data());
  const int size = field.cell(picture.width) | 1;
  cv::erode(wide, narrow, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
  cv::max(out, narrow, out);
  drop_specks(out, std::min(std::max(4, size * size / 4), static_cast<int>(out.total())));
  return alpha;
}

void BackingFieldReference::fill_holes(const BackingField& field, const Image& picture, Image& alpha) {
  cv::Mat key(alpha.height, alpha.width, CV_8U, alpha.pixels.data());
  const double largest = kLargestHole * cv::countNonZero(key >= 128);
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(key < 128, labels, stats, centroids, 4, CV_32S);
  if (count <= 2) return;
  const std::vector<float> off = field.distances(picture, BackingField::Scale::Cell);
  std::vector<int> far(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < key.rows; ++y)
    for (int x = 0; x < key.cols; ++x)
      far[static_cast<std::size_t>(labels.at<int>(y, x))] +=
          off[static_cast<std::size_t>(y) * static_cast<std::size_t>(key.cols) +
              static_cast<std::size_t>(x)] > 0.5f * field.sigmas_;
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const cv::Rect box(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]);
    const bool open = box.x == 0 || box.y == 0 || box.br().x == key.cols || box.br().y == key.rows;
    if (open || s[cv::CC_STAT_AREA] > largest ||
        4 * far[static_cast<std::size_t>(i)] < 3 * s[cv::CC_STAT_AREA])
      continue;
    key(box).setTo(255, labels(box) == i);
  }
}

void BackingFieldReference::solve_edges(const BackingField& field, const Image& picture, Image& alpha) {
  const cv::Mat rgb(picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.pixels.data()));
  cv::Mat key(alpha.height, alpha.width, CV_8U, alpha.pixels.data());
  const int band = field.cell(picture.width);
  const cv::Rect box = grown_box(key, 4 * band + 1);
  if (box.empty()) return;
  const cv::Mat there = key(box), subject = there >= 128;
  cv::Mat inside, around, values, mask;
  cv::erode(subject, inside, square(band));
  cv::dilate(subject, around, square(band));
  rgb(box).convertTo(values, CV_32FC3);
  inside.convertTo(mask, CV_32F, 1.0 / 255);
  cv::Mat chosen = cv::Mat::zeros(values.size(), CV_32FC3);
  values.copyTo(chosen, inside);
  // The inside that is near an outline's pixel; further in only where that is thin.
  std::array<cv::Mat, 2> sums, counts;
  for (std::size_t i = 0; i < 2; ++i) {
    const int radius = i == 0 ? band + band / 2 : 2 * band;
    const cv::Size window(2 * radius + 1, 2 * radius + 1);
    cv::boxFilter(chosen, sums[i], CV_32F, window, {-1, -1}, false, cv::BORDER_CONSTANT);
    cv::boxFilter(mask, counts[i], CV_32F, window, {-1, -1}, false, cv::BORDER_CONSTANT);
  }
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      if (!around.at<std::uint8_t>(y, x) || inside.at<std::uint8_t>(y, x)) continue;
      const auto row = static_cast<std::size_t>((box.y + y) * field.rows_ / picture.height),
                 col = static_cast<std::size_t>((box.x + x) * field.cols_ / picture.width);
      const std::size_t i = counts[0].at<float>(y, x) < 2.5f ? 1 : 0;
      if (counts[i].at<float>(y, x) < 0.5f || field.known(col, row) == 0) continue;
      float terms[FieldRow::kTerms];
      for (std::size_t k = 0; k < FieldRow::kTerms; ++k)
        terms[k] = field.terms(BackingField::Scale::Pixel, static_cast<int>(row))[k * field.stride() + col];
      const cv::Vec3f backing(terms[0], terms[1], terms[2]);
      const cv::Vec3f contrast = sums[i].at<cv::Vec3f>(y, x) / counts[i].at<float>(y, x) - backing;
      if (length(terms + 3, contrast[0], contrast[1], contrast[2]) < 2 * field.sigmas_) continue;
      const cv::Vec3f low = roots(backing), span = roots(backing + contrast) - low;
      const float a = (roots(values.at<cv::Vec3f>(y, x)) - low).dot(span) / std::max(span.dot(span), 1e-6f);
      key.at<std::uint8_t>(box.y + y, box.x + x) =
          static_cast<std::uint8_t>(std::clamp(255 * a + 0.5f, 0.0f, 255.0f));
    }
}

namespace {

// Cloth or a wall with a body before it, whose holes show the backing or something nearly as dark.
Image stage(int width, int height, double noise, bool dark, std::uint64_t seed, bool body = true) {
  Random random(seed);
  Image picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = 2.0 * x / width - 1, v = 2.0 * y / height - 1, light = 1 - 0.3 * (u * u + v * v);
      const bool in = body && u * u / 0.2 + v * v / 0.6 < 1;
      const bool hole = std::hypot(u + 0.1, v - 0.2) < 0.06, hair = std::hypot(u - 0.1, v + 0.3) < 0.07;
      std::array<double, 3> c = dark ? std::array{9 * light, 10 * light, 12 * light}
                                     : std::array{70 * light, 80 * light, 60 * light};
      if (in && !hole)
        c = hair ? std::array{c[0] + 6, c[1] + 6, c[2] + 5} : std::array{190.0, 90.0 + 60 * u, 70.0};
      for (int k = 0; k < 3; ++k)
        picture.at(x, y)[k] = static_cast<std::uint8_t>(
            std::clamp(std::lround(c[static_cast<std::size_t>(k)] + noise * random.normal()), 0L, 255L));
    }
  return picture;
}

struct Case {
  int width, height, learnt_width, learnt_height;
  double noise;
  bool dark;
};

// Sizes that are no whole vectors, smaller and larger than the field, and cells of one pixel and of many.
class BackingFieldOf : public testing::TestWithParam<Case> {
 protected:
  BackingField field() const {
    const Case& c = GetParam();
    const auto learnt = learn_field({stage(c.learnt_width, c.learnt_height, c.noise, c.dark, 2, false),
                                     stage(c.learnt_width, c.learnt_height, c.noise, c.dark, 3)},
                                    {}, {.darker_too = c.dark});
    EXPECT_TRUE(learnt);
    return *learnt;
  }
  Image picture() const {
    return stage(GetParam().width, GetParam().height, GetParam().noise, GetParam().dark, 5);
  }
};

INSTANTIATE_TEST_SUITE_P(Stages, BackingFieldOf,
                         testing::Values(Case{320, 240, 320, 240, 1.5, true},
                                         Case{320, 240, 320, 240, 4, false},
                                         Case{641, 470, 320, 240, 2, true}, Case{101, 75, 320, 240, 1, false},
                                         Case{37, 203, 37, 203, 0, true}, Case{1300, 60, 640, 480, 3, false},
                                         Case{3, 2, 90, 70, 1, true}, Case{5, 5, 5, 5, 0, true}));

TEST_P(BackingFieldOf, KeysWithTheBytesOfTheSlowMethod) {
  const BackingField field = this->field();
  EXPECT_EQ(field.key(picture()), BackingFieldReference::key(field, picture()));
}

TEST_P(BackingFieldOf, FillsTheHolesThatTheSlowMethodFills) {
  const BackingField field = this->field();
  Image alpha = field.key(picture()), expected = alpha;
  field.fill_holes(picture(), alpha);
  BackingFieldReference::fill_holes(field, picture(), expected);
  EXPECT_EQ(alpha, expected);
}

TEST_P(BackingFieldOf, SolvesEdgesWithTheBytesOfTheSlowMethod) {
  const BackingField field = this->field();
  const Image key = field.key(picture());
  Image alpha = key, expected = key;
  field.solve_edges(picture(), alpha);
  BackingFieldReference::solve_edges(field, picture(), expected);
  EXPECT_EQ(alpha, expected);

  // The same in a part of the picture only.
  BitRows left;
  left.resize(key.width, key.height);
  left.clear();
  for (int y = 0; y < key.height; ++y) left.set(y, 0, key.width / 2);
  Image half = key;
  field.solve_edges(picture(), key, left, half);
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x)
      ASSERT_EQ(*half.at(x, y), *(x < key.width / 2 ? expected : key).at(x, y)) << x << ' ' << y;
}

TEST(BackingField, KeysWhereNothingIsKnownAsSubject) {
  const Image empty = stage(320, 240, 2, false, 2, false);
  Image mask(320, 240, 1);
  for (int y = 0; y < 240; ++y) std::fill_n(mask.at(160, y), 160, std::uint8_t{255});
  const auto field = learn_field({empty}, {mask}, {.reach = 0.02});
  ASSERT_TRUE(field);
  const Image alpha = field->key(empty);
  EXPECT_EQ(*alpha.at(20, 120), 0);
  EXPECT_EQ(*alpha.at(300, 120), 255);
  EXPECT_EQ(alpha, BackingFieldReference::key(*field, empty));
}

}  // namespace
}  // namespace floatstage::matting
