#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace floatstage {

/// A new empty folder that is removed with everything in it.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  /// Writes a file in here as another program would, and returns its path.
  std::filesystem::path write(const std::string& name, std::string_view bytes) const;
  /// What lies in the folder, hidden and temporary names too, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

}  // namespace floatstage
