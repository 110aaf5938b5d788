#pragma once

#include <optional>
#include <string_view>

namespace floatstage::calib {

/// A marker dictionary by name, as OpenCV's number; "DICT_4X4_50" and "4x4_50" are the same. Private to
/// calib.
struct MarkerDictionary {
  const char* name;
  int opencv;   ///< cv::aruco::PREDEFINED_DICTIONARY_NAME
  int markers;  ///< how many there are
  int cells;    ///< bits across, without the border
};

const MarkerDictionary* find_dictionary(std::string_view name);

/// All of them; the largest of each size is the last of its size.
struct DictionaryRange {
  const MarkerDictionary* first;
  const MarkerDictionary* last;
  const MarkerDictionary* begin() const { return first; }
  const MarkerDictionary* end() const { return last; }
};
DictionaryRange all_dictionaries();

}  // namespace floatstage::calib
