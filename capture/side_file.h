#pragma once

#include <filesystem>

#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::capture {

/// A <serial>.frames.csv that is being recorded: one whole line a call, handed to the operating system at
/// once.
class SideFileWriter {
 public:
  SideFileWriter() = default;
  SideFileWriter(SideFileWriter&& other) noexcept;
  SideFileWriter& operator=(SideFileWriter&&) = delete;
  ~SideFileWriter();

  /// Creates the file, which must not exist, with its header. Io names it.
  static Result<SideFileWriter> create(const std::filesystem::path& file);
  /// Io names the file. A line that was cut short is the last one: the reader ignores it.
  Result<void> write(const FrameRow& row);

 private:
  Result<void> append(const std::string& line);
  std::filesystem::path file_;
  int fd_ = -1;
};

}  // namespace floatstage::capture
