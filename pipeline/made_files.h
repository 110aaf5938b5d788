#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"

namespace floatstage::pipeline {

/// What tells files that we made from files of unknown origin: records keep the hash of every file
/// (docs/adr/0185-files-are-known-by-their-bytes.md).

/// SHA-256 of a file's bytes, in hexadecimal; nothing where there is no file. Io.
Result<std::optional<std::string>> hash_of(const std::filesystem::path& file);

/// A file as it lies there now, for those who have read it and want to know whether to read it again. Two
/// marks of a name are equal when it was neither written, replaced nor removed in between.
struct FileMark {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t written = 0, changed = 0;  ///< ns; all 0: there is no file
  bool operator==(const FileMark&) const = default;
};
FileMark mark_of(const std::filesystem::path& file);

/// The entries that a job added to a record's journal and that no record holds yet, oldest first; a line that
/// was cut off is none. No file is no entries.
std::vector<nlohmann::json> read_journal(const std::filesystem::path& file);

/// Entries added one by one while a job runs, one line of JSON each: what a killed job had finished is known
/// without writing the whole record after every file. Whoever saves the record removes the journal. Thread
/// safe.
class Journal {
 public:
  /// The file is made by the first add().
  explicit Journal(std::filesystem::path file) : file_(std::move(file)) {}
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// The line is in the file when this returns. Io names the file and the reason.
  Result<void> add(const nlohmann::json& entry);
  /// Its entries are in the record now.
  void remove();

 private:
  std::filesystem::path file_;
  std::mutex mutex_;
  int descriptor_ = -1;
};

}  // namespace floatstage::pipeline
