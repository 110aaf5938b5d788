#include "pipeline/made_files.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::pipeline {

using nlohmann::json;

Result<std::optional<std::string>> hash_of(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return std::optional<std::string>();
  if (!bytes) return forward(bytes);
  return std::optional<std::string>(capture::sha256(*bytes));
}

FileMark mark_of(const std::filesystem::path& file) {
  struct stat there {};
  if (stat(file.c_str(), &there) != 0) return {};
  const auto ns = [](const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; };
  return {there.st_dev, there.st_ino, static_cast<std::uint64_t>(there.st_size), ns(there.st_mtim),
          ns(there.st_ctim)};
}

std::vector<json> read_journal(const std::filesystem::path& file) {
  std::vector<json> entries;
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return entries;
  for (std::size_t begin = 0, end; (end = bytes->find('\n', begin)) != std::string::npos; begin = end + 1) {
    Result<json> entry = parse_json(std::string_view(*bytes).substr(begin, end - begin), file.string());
    if (entry && entry->is_object()) entries.push_back(std::move(*entry));
  }
  return entries;
}

Journal::~Journal() {
  if (descriptor_ >= 0) close(descriptor_);
}

Result<void> Journal::add(const json& entry) {
  const std::string line = entry.dump() + "\n";
  const std::lock_guard lock(mutex_);
  if (descriptor_ < 0) descriptor_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  // One call, so that a killed program leaves a whole line or one without its end.
  const ssize_t written = descriptor_ < 0 ? -1 : write(descriptor_, line.data(), line.size());
  if (written == static_cast<ssize_t>(line.size())) return {};
  const int reason = written < 0 ? errno : ENOSPC;
  if (written > 0) (void)!write(descriptor_, "\n", 1);  // what follows is not joined to what was cut off
  return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", std::strerror(reason)));
}

void Journal::remove() {
  const std::lock_guard lock(mutex_);
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
  std::error_code none;
  std::filesystem::remove(file_, none);
}

}  // namespace floatstage::pipeline
