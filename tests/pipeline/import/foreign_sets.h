#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace floatstage {

using Words = std::vector<std::string>;

/// Exit codes (docs/exit-codes.md).
inline constexpr int kInvalidArgument = 3, kNotFound = 4, kBadData = 6, kUnsupported = 7;

/// Which of a lens' terms a format has.
enum class LensTerms { None, Radial2, Radial2Tangential, Five };

/// Where camera `i` of the sets, 0 or 1, sees a point by OpenCV's formula, in our pixels, which count from
/// the corner.
Eigen::Vector2d by_opencv(int i, const Eigen::Vector3d& point, LensTerms lens);

/// A text in a file of the set becomes another one.
struct Change {
  std::string file, from, to;
  int code = kBadData;
  std::string words = {};  ///< of the sentence, beside the file's name
  std::function<void(const std::filesystem::path& folder)> do_it = {};  ///< instead
};

/// A row of the table.
struct Format {
  std::string name, written_by;
  std::function<void(const std::filesystem::path&)> write;  ///< the set, with pictures
  LensTerms lens;
  std::vector<std::string> files;     ///< that are cut off, one at a time
  std::vector<std::string> pictures;  ///< that are taken away
  std::optional<Change> version, model, zero;
  Words more = {};                                                        ///< options
  std::function<Eigen::Vector2d(int, const Eigen::Vector3d&)> seen = {};  ///< instead of OpenCV's formula
  int without_pictures = kNotFound;
};

/// One for each format that is imported: two cameras, written as its documentation says or by another
/// program.
const std::vector<Format>& foreign_sets();

/// A file and its folders.
void put(const std::filesystem::path& file, const std::string& content);

/// The same cameras as Middlebury has them, for "a.png" and "b.png".
std::string middlebury();

}  // namespace floatstage
