#include "calib/marker_dictionary.h"

#include <algorithm>
#include <cctype>
#include <string>

#include <opencv2/aruco.hpp>

#include "calib/board.h"

namespace floatstage::calib {
namespace {

namespace ar = cv::aruco;

constexpr MarkerDictionary kDictionaries[] = {
    {"4x4_50", ar::DICT_4X4_50, 50, 4},
    {"4x4_100", ar::DICT_4X4_100, 100, 4},
    {"4x4_250", ar::DICT_4X4_250, 250, 4},
    {"4x4_1000", ar::DICT_4X4_1000, 1000, 4},
    {"5x5_50", ar::DICT_5X5_50, 50, 5},
    {"5x5_100", ar::DICT_5X5_100, 100, 5},
    {"5x5_250", ar::DICT_5X5_250, 250, 5},
    {"5x5_1000", ar::DICT_5X5_1000, 1000, 5},
    {"6x6_50", ar::DICT_6X6_50, 50, 6},
    {"6x6_100", ar::DICT_6X6_100, 100, 6},
    {"6x6_250", ar::DICT_6X6_250, 250, 6},
    {"6x6_1000", ar::DICT_6X6_1000, 1000, 6},
    {"7x7_50", ar::DICT_7X7_50, 50, 7},
    {"7x7_100", ar::DICT_7X7_100, 100, 7},
    {"7x7_250", ar::DICT_7X7_250, 250, 7},
    {"7x7_1000", ar::DICT_7X7_1000, 1000, 7},
    {"aruco_original", ar::DICT_ARUCO_ORIGINAL, 1024, 5},
    {"apriltag_16h5", ar::DICT_APRILTAG_16h5, 30, 4},
    {"apriltag_25h9", ar::DICT_APRILTAG_25h9, 35, 5},
    {"apriltag_36h10", ar::DICT_APRILTAG_36h10, 2320, 6},
    {"apriltag_36h11", ar::DICT_APRILTAG_36h11, 587, 6},
};

std::string plain(std::string_view name) {
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (lower.starts_with("dict_")) lower.erase(0, 5);
  return lower;
}

}  // namespace

const MarkerDictionary* find_dictionary(std::string_view name) {
  const std::string wanted = plain(name);
  for (const MarkerDictionary& d : kDictionaries)
    if (wanted == d.name) return &d;
  return nullptr;
}

DictionaryRange all_dictionaries() { return {std::begin(kDictionaries), std::end(kDictionaries)}; }

std::vector<std::string> marker_dictionaries() {
  std::vector<std::string> names;
  for (const MarkerDictionary& d : kDictionaries) names.push_back(d.name);
  return names;
}

}  // namespace floatstage::calib
