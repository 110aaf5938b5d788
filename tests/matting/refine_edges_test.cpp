#include "matting/refine_edges.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/random.h"

namespace floatstage::matting {
namespace {

// refine_edges() on bytes and labels of whole boxes.
namespace slow {

constexpr int kSubject = 128, kFaint = 24;  // alpha: subject; possibly subject
constexpr int kEdge = 2;                    // px on either side of the key's edge that are solved
constexpr int kHair = 20;                   // px from the subject in which hair is looked for
constexpr int kNear = 4, kFar = 14;  // px: windows in which the two sides are looked for, first the near one

cv::Mat square(int radius) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
}

// The mean of a measure over the masked pixels in a window around any pixel, by summed-area tables: few
// pixels ask.
class LocalMean {
 public:
  LocalMean(const cv::Mat& measure, const cv::Mat& mask) {
    cv::Mat chosen = cv::Mat::zeros(measure.size(), CV_32F);
    measure.copyTo(chosen, mask);
    cv::integral(chosen, sums_, CV_64F);
    cv::integral(mask, counts_, CV_32S);  // times 255
  }

  // False, and 0, when no window holds a masked pixel.
  bool at(int x, int y, float& mean) const {
    return window(x, y, kNear, 3, mean) || window(x, y, kFar, 1, mean);
  }

 private:
  bool window(int x, int y, int radius, int at_least, float& mean) const {
    const int x0 = std::max(x - radius, 0), x1 = std::min(x + radius + 1, sums_.cols - 1);
    const int y0 = std::max(y - radius, 0), y1 = std::min(y + radius + 1, sums_.rows - 1);
    const int count = box<int>(counts_, x0, y0, x1, y1) / 255;
    mean = count > 0 ? static_cast<float>(box<double>(sums_, x0, y0, x1, y1) / count) : 0;
    return count >= at_least;
  }

  template <class T>
  static T box(const cv::Mat& table, int x0, int y0, int x1, int y1) {
    const T *top = table.ptr<T>(y0), *bottom = table.ptr<T>(y1);
    return bottom[x1] - bottom[x0] - top[x1] + top[x0];
  }

  cv::Mat sums_, counts_;
};

// The doubtful pixels that hang together with the subject and are not far from it.
cv::Mat hair_of(const cv::Mat& subject, const cv::Mat& doubt) {
  cv::Mat reach, labels;
  cv::dilate(subject, reach, square(kHair));
  const cv::Mat candidates = (doubt | subject) & reach;
  const int count = cv::connectedComponents(candidates, labels, 8, CV_32S, cv::CCL_SAUF);
  std::vector<std::uint8_t> touched(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < labels.rows; ++y) {
    const std::uint8_t* in = subject.ptr<std::uint8_t>(y);
    const int* label = labels.ptr<int>(y);
    for (int x = 0; x < labels.cols; ++x)
      if (in[x]) touched[static_cast<std::size_t>(label[x])] = 255;
  }
  touched[0] = 0;
  cv::Mat hair(labels.size(), CV_8U);
  for (int y = 0; y < labels.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    std::uint8_t* out = hair.ptr<std::uint8_t>(y);
    for (int x = 0; x < labels.cols; ++x) out[x] = touched[static_cast<std::size_t>(label[x])];
  }
  return hair;
}

// Off the edge, a little opacity is noise of the cloth; half opacity stays half.
float without_noise(float a) { return a >= 0.5f ? a : std::max(0.0f, (a - 0.25f) * 2); }

void refine_edges(const BackingMeasure& measure, float contrast, const Image& doubt, Image& alpha) {
  if (alpha.empty()) return;
  cv::Mat whole(alpha.height, alpha.width, CV_8U, alpha.pixels.data());
  const cv::Mat whole_doubt(alpha.height, alpha.width, CV_8U, const_cast<std::uint8_t*>(doubt.pixels.data()));
  cv::Rect box = cv::boundingRect(whole);
  if (box.empty()) return;
  constexpr int reach = kHair + kFar;
  box = cv::Rect(box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach) &
        cv::Rect(0, 0, whole.cols, whole.rows);
  cv::Mat key = whole(box);

  const cv::Mat subject = key >= kSubject, hair = hair_of(subject, whole_doubt(box));
  cv::Mat inside, edge, values(box.size(), CV_32F);
  cv::erode(subject, inside, square(kEdge));
  cv::dilate(key >= kFaint, edge, square(kEdge));
  const cv::Mat outside = ~(edge | hair);
  for (int y = 0; y < box.height; ++y) measure(box.y + y, box.x, box.width, values.ptr<float>(y));
  const LocalMean of_inside(values, inside), of_outside(values, outside);

  for (int y = 0; y < box.height; ++y) {
    std::uint8_t* row = key.ptr<std::uint8_t>(y);
    const std::uint8_t *in = inside.ptr<std::uint8_t>(y), *out = outside.ptr<std::uint8_t>(y),
                       *on_edge = edge.ptr<std::uint8_t>(y);
    for (int x = 0; x < box.width; ++x) {
      if (in[x]) row[x] = 255;
      if (in[x] || out[x]) continue;
      float f, b;
      if (!of_outside.at(x, y, b)) continue;
      of_inside.at(x, y, f);
      if (std::abs(f - b) < contrast) continue;
      const float solved = (values.at<float>(y, x) - b) / (f - b);
      const float opacity = on_edge[x] ? solved : without_noise(solved);
      row[x] = static_cast<std::uint8_t>(std::clamp(255 * opacity + 0.5f, 0.0f, 255.0f));
    }
  }
}

}  // namespace slow

// A dark subject on the left of column `edge`, which it covers by `share`; the measure is 100 on the cloth.
struct HalfPlane {
  int edge = 30;
  double share = 0.3;
  float subject = 0, cloth = 100;

  float measure(int x) const {
    const double a = x < edge ? 1 : x == edge ? share : 0;
    return static_cast<float>(a * subject + (1 - a) * cloth);
  }
  // A key that knows only sides, and errs by `offset` columns.
  Image key(int offset = 0) const {
    Image alpha(64, 32, 1);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < edge + offset; ++x) *alpha.at(x, y) = 255;
    return alpha;
  }
  Image refined(Image alpha, const Image& doubt = Image(64, 32, 1), float contrast = 5) const {
    refine_edges(
        [this](int, int x0, int count, float* out) {
          for (int x = x0; x < x0 + count; ++x) *out++ = measure(x);
        },
        contrast, doubt, alpha);
    return alpha;
  }
};

TEST(RefineEdges, SolvesTheShareOfAMixedPixelHoweverTheKeyErred) {
  for (double share : {0.1, 0.5, 0.8}) {
    for (int offset : {-1, 0, 1, 2}) {
      const HalfPlane plane{.share = share};
      const Image alpha = plane.refined(plane.key(offset));
      EXPECT_EQ(*alpha.at(29, 16), 255) << share << ' ' << offset;
      EXPECT_NEAR(*alpha.at(30, 16), 255 * share, 1) << share << ' ' << offset;
      EXPECT_EQ(*alpha.at(31, 16), 0) << share << ' ' << offset;
    }
  }
}

TEST(RefineEdges, UsesTheSubjectsOwnMeasure) {
  const HalfPlane plane{.share = 0.5, .subject = 40};  // spill
  EXPECT_NEAR(*plane.refined(plane.key()).at(30, 16), 128, 1);
}

TEST(RefineEdges, KeepsTheKeyWhereTheSidesLookAlike) {
  const HalfPlane plane{.subject = 97};
  EXPECT_EQ(plane.refined(plane.key()), plane.key());
}

TEST(RefineEdges, MakesTheInsideOpaque) {
  HalfPlane plane;
  Image key = plane.key();
  for (int y = 10; y < 20; ++y) *key.at(10, y) = 150;
  EXPECT_EQ(*plane.refined(key).at(10, 15), 255);
}

TEST(RefineEdges, FindsAHairThatHangsTogetherWithTheSubjectByItsDoubt) {
  Image key(64, 48, 1), doubt(64, 48, 1);
  for (int y = 30; y < 48; ++y)
    for (int x = 20; x < 44; ++x) *key.at(x, y) = 255;
  for (int y = 10; y < 30; ++y) *doubt.at(32, y) = *doubt.at(50, y) = 255;
  auto measure = [](int y, int x0, int count, float* out) {
    for (int x = x0; x < x0 + count; ++x) {
      const bool subject = y >= 30 && x >= 20 && x < 44, hair = y >= 10 && y < 30 && (x == 32 || x == 50);
      *out++ = subject ? 0.0f : hair ? 30.0f : 100.0f;
    }
  };
  refine_edges(measure, 5, doubt, key);
  EXPECT_NEAR(*key.at(32, 14), 255 * 0.7, 1);
  EXPECT_EQ(*key.at(50, 14), 0) << "this one is nobody's";
  EXPECT_EQ(*key.at(34, 14), 0);
}

TEST(RefineEdges, LeavesAnEmptyAndAFullMatteAlone) {
  const HalfPlane plane;
  EXPECT_EQ(plane.refined(Image(64, 32, 1)), Image(64, 32, 1));
  EXPECT_EQ(plane.refined(Image(64, 32, 1, 255)), Image(64, 32, 1, 255));
}

TEST(RefineEdges, GivesTheBytesOfTheSlowMethod) {
  Random random(4);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(65, 20), std::pair(150, 110)})
    for (int trial = 0; trial < 6; ++trial) {
      Image alpha(width, height, 1), doubt(width, height, 1);
      std::vector<float> measures;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const double off =
              std::hypot(x - width / 2.0, y - height / 2.0) - height / 4.0 + 2 * random.normal();
          *alpha.at(x, y) = static_cast<std::uint8_t>(std::clamp(128 - 40 * off, 0.0, 255.0));
          *doubt.at(x, y) = off < 3 * trial || random.uniform() < 0.1 * trial ? 255 : 0;
          measures.push_back(static_cast<float>(std::clamp(8 * off, 0.0, 90.0) + 4 * random.normal()));
        }
      const auto measure = [&](int y, int x0, int count, float* out) {
        std::copy_n(measures.begin() + y * width + x0, count, out);
      };
      Image expected = alpha;
      slow::refine_edges(measure, 5, doubt, expected);
      refine_edges(measure, 5, doubt, alpha);
      EXPECT_EQ(alpha, expected) << width << ' ' << trial;
    }
}

}  // namespace
}  // namespace floatstage::matting
