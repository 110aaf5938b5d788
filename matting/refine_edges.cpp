// Method:  the opacity of mixed pixels from a measure that is
//          linear in the subject's share
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996, eq. 1, along one axis
// Differs: both ends of the axis are means over what is near: no second backing is needed
// ADR:     0043

#include "matting/refine_edges.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace floatstage::matting {
namespace {

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

}  // namespace

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

}  // namespace floatstage::matting
