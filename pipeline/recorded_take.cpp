#include "pipeline/recorded_take.h"

#include <mutex>

namespace floatstage::pipeline {
namespace {

/// Bytes from several threads as whole MiB.
class Mebibytes {
 public:
  Mebibytes(Progress* progress, const char* what, const std::filesystem::path& take)
      : progress_(progress), part_(progress, what, (capture::recorded_bytes(take) >> 20) + 1) {}

  bool read(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    bytes_ += bytes;
    if (bytes_ >> 20 > said_) part_.advance((bytes_ >> 20) - said_);
    said_ = bytes_ >> 20;
    return !is_cancelled(progress_);
  }

 private:
  Progress* const progress_;
  std::mutex mutex_;  // guards what follows
  ProgressPart part_;
  std::uint64_t bytes_ = 0, said_ = 0;
};

}  // namespace

Result<void> seal_take(const std::filesystem::path& take, Progress* progress) {
  Mebibytes part(progress, "seal", take);
  return capture::seal_take(take, [&](std::uint64_t bytes) { return part.read(bytes); });
}

Result<capture::TakeCheck> check_take(const std::filesystem::path& take, Progress* progress) {
  Mebibytes part(progress, "verify", take);
  return capture::check_take(take, [&](std::uint64_t bytes) { return part.read(bytes); });
}

}  // namespace floatstage::pipeline
