#include "matting/known_by_plate.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr int kOutlineReach = 3;     // pixels of the cut: as far as closed form looks for its outline
constexpr double kHalfSeen = 0.5;    // of how unlike the plate its neighbours are: half opacity
constexpr float kLikelySubject = 2;  // log-odds

// Without its outermost pixels, which show a little of both sides.
Image inner(const Image& mask) {
  Image out(mask.width, mask.height, 1);
  cv::Mat to = as_mat(out);
  cv::erode(as_mat(mask), to, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return out;
}

// Where a pixel is about as unlike the plate as its neighbours are: one that shows a little of both sides, in
// hair or at an outline, is less unlike it by as much as it shows.
Image wholly_unlike(const Image& plate, const Image& picture) {
  cv::Mat apart(picture.height, picture.width, CV_32F), most;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      float sum = 0;
      for (int c = 0; c < 3; ++c) {
        const auto d = static_cast<float>(picture.at(x, y)[c] - plate.at(x, y)[c]);
        sum += d * d;
      }
      apart.at<float>(y, x) = std::sqrt(sum);
    }
  cv::dilate(apart, most, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  Image out(picture.width, picture.height, 1);
  cv::Mat to = as_mat(out);
  cv::compare(apart, kHalfSeen * most, to, cv::CMP_GE);
  return out;
}

}  // namespace

PlateWord word_of(const Plate& plate, const Image& picture) {
  const Image classes = classify(plate, picture), whole = wholly_unlike(plate.color, picture);
  PlateWord word{inner(where_is(classes, PlateClass::Subject)), inner(where_is(classes, PlateClass::Plate))};
  for (std::size_t p = 0; p < whole.pixels.size(); ++p) word.unlike.pixels[p] &= whole.pixels[p];
  return word;
}

Image known_by_plate(const PlateWord& word, const Image& cut, std::span<const float> odds) {
  FLOATSTAGE_CHECK(cut.channels == 1 && !cut.empty() && odds.size() == cut.pixels.size(),
                   "a cut has one channel and odds");
  const int w = word.unlike.width, h = word.unlike.height;
  Image subject(w, h, 1), likely = subject;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t p =
          static_cast<std::size_t>(y * cut.height / h) * static_cast<std::size_t>(cut.width) +
          static_cast<std::size_t>(x * cut.width / w);
      *subject.at(x, y) = cut.pixels[p] ? 255 : 0;
      *likely.at(x, y) = cut.pixels[p] || odds[p] >= kLikelySubject ? 255 : 0;
    }
  const double scale = static_cast<double>(w) / cut.width;
  const Image near = grown(subject, static_cast<int>(std::lround(kOutlineReach * scale)));
  Image known(w, h, 1, 128);
  for (std::size_t p = 0; p < known.pixels.size(); ++p) {
    if (word.unlike.pixels[p] && near.pixels[p] && likely.pixels[p]) known.pixels[p] = 255;
    if (word.alike.pixels[p] && !subject.pixels[p]) known.pixels[p] = 0;
  }
  return known;
}

Image unlike_within(const PlateWord& word, int width, int height) {
  Image out(width, height, 1);
  for (int y = 0; y < word.unlike.height; ++y)
    for (int x = 0; x < word.unlike.width; ++x)
      if (*word.unlike.at(x, y))
        *out.at(x * width / word.unlike.width, y * height / word.unlike.height) = 255;
  return out;
}

}  // namespace floatstage::matting
