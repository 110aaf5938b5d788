#include "matting/select_connected_components.h"

#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace floatstage::matting {
namespace {

constexpr int kSubject = 128;
constexpr int kSoftEdge = 6;  // px around an island that belong to its soft edge and hair

cv::Mat as_mat(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()));
}

struct Island {
  long area = 0, near_previous = 0;
  bool subject = false, background = false;
};

}  // namespace

Image select_connected_components(const Image& key, const Image& previous, const Image& said, int reach) {
  FLOATSTAGE_CHECK(key.channels == 1, "a key has one channel");
  for (const Image* map : {&previous, &said})
    FLOATSTAGE_CHECK(
        map->empty() || (map->channels == 1 && map->width == key.width && map->height == key.height),
        "maps of the key's size");
  const cv::Mat alpha = as_mat(key);
  cv::Mat labels;
  const int count = cv::connectedComponents(alpha >= kSubject, labels, 8, CV_32S, cv::CCL_SAUF);
  std::vector<Island> islands(static_cast<std::size_t>(count));
  cv::Mat near;
  long previous_area = 0, touched = 0;
  if (!previous.empty()) {
    const cv::Mat before = as_mat(previous) >= kSubject;
    previous_area = cv::countNonZero(before);
    const int size = 2 * reach + 1;
    cv::dilate(before, near, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
  }
  for (int y = 0; y < key.height; ++y) {
    const int* label = labels.ptr<int>(y);
    for (int x = 0; x < key.width; ++x) {
      Island& island = islands[static_cast<std::size_t>(label[x])];
      ++island.area;
      if (!near.empty() && near.at<std::uint8_t>(y, x)) ++island.near_previous;
      if (said.empty()) continue;
      island.subject |= *said.at(x, y) == 255;
      island.background |= *said.at(x, y) == 0;
    }
  }
  for (int i = 1; i < count; ++i) touched += islands[static_cast<std::size_t>(i)].subject;
  std::vector<std::uint8_t> stays(islands.size());
  for (int i = 1; i < count; ++i) {
    const Island& island = islands[static_cast<std::size_t>(i)];
    const bool follows = previous_area > 0 && (4 * island.near_previous >= island.area ||
                                               4 * island.near_previous >= previous_area);
    const bool unasked = previous.empty() && touched == 0;
    stays[static_cast<std::size_t>(i)] =
        island.subject || (!island.background && (follows || unasked)) ? 255 : 0;
  }
  cv::Mat kept(alpha.size(), CV_8U), reached;
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x)
      kept.at<std::uint8_t>(y, x) = stays[static_cast<std::size_t>(labels.at<int>(y, x))];
  const int size = 2 * kSoftEdge + 1;
  cv::dilate(kept, reached, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
  Image out = key;
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x) {
      const bool other_island = labels.at<int>(y, x) != 0 && !kept.at<std::uint8_t>(y, x);
      if (other_island || !reached.at<std::uint8_t>(y, x)) *out.at(x, y) = 0;
    }
  return out;
}

}  // namespace floatstage::matting
