#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "core/result.h"

namespace floatstage {

/// An open file of the operating system, closed when this goes.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileDescriptor();

  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_ = -1;
};

/// Opens a regular file for reading. Everything else (a pipe hangs until somebody writes, a device may never
/// end, a folder has no bytes) is refused without waiting. NotFound or Io, naming the file and the reason.
Result<FileDescriptor> open_to_read(const std::filesystem::path& file);

/// Bytes in the open file. Io names `file`.
Result<std::uint64_t> size_of(const FileDescriptor& open, const std::filesystem::path& file);

}  // namespace floatstage
