#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// What a picture of a doubt shows.
struct DoubtPicture {
  std::string of;   ///< who says it: "mattes" of themselves, "hull", "labels", "silhouettes"
  std::string why;  ///< MatteDoubt::why, or in a word
  std::vector<std::string> cameras = {};
  int frame = 0;
  std::string sha256 = {};  ///< of the file: put() says it
};

/// The pictures in a folder of doubts (mattes/doubts, meshes/faults) that were drawn here, by name: its
/// made.json. Those of doubts that no longer hold go; files that it does not know by their bytes, links and
/// what links lead to are somebody's, and stay. For those who have claimed the take.
class DoubtPictures {
 public:
  /// A record that cannot be read knows no picture.
  explicit DoubtPictures(std::filesystem::path folder);

  /// Writes a picture under this name. An empty one changes nothing. Io.
  Result<void> put(const std::string& name, DoubtPicture what, const Image& picture);
  /// Moves a picture that was drawn elsewhere to this name. Io.
  Result<void> take_in(const std::filesystem::path& file, const std::string& name, DoubtPicture what);
  /// The frame of the picture that is known of a doubt, if it is still there.
  std::optional<int> frame_of(const std::string& why, const std::vector<std::string>& cameras) const;
  /// Removes pictures of `of` that no longer hold. Io.
  Result<void> keep(const std::string& of,
                    const std::function<bool(const std::string& name, const DoubtPicture&)>& holds);

 private:
  Result<void> know(const std::string& name, DoubtPicture what);
  Result<void> save() const;

  std::filesystem::path folder_;
  std::map<std::string, DoubtPicture> pictures_;
};

}  // namespace floatstage::pipeline
