#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

#include <unistd.h>

#include "core/text.h"

namespace floatstage {

/// A folder of this process for what is read by name, in memory where the system has such a place; gone at
/// the end.
class FuzzFolder {
 public:
  FuzzFolder() {
    std::error_code none;
    const std::filesystem::path memory = "/dev/shm";
    path_ = (std::filesystem::is_directory(memory, none) ? memory : std::filesystem::temp_directory_path()) /
            text("floatstage-fuzz-", ::getpid());
    std::filesystem::create_directories(path_);
  }
  ~FuzzFolder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline const std::filesystem::path& fuzz_folder() {
  static const FuzzFolder folder;
  return folder.path();
}

inline std::filesystem::path fuzz_file(const std::filesystem::path& name, std::string_view bytes) {
  const std::filesystem::path file = fuzz_folder() / name;
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file;
}

}  // namespace floatstage
