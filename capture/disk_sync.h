#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "core/result.h"

namespace floatstage::capture {

/// Has the disk keep (fdatasync(2)) what was written to every regular file below `folder`, and the folders'
/// own entries. Links are not followed. Io names the first file for which the disk refused.
Result<void> sync_folder(const std::filesystem::path& folder);

/// Does so every `period` on a thread of its own, from the start to the end of this: what a power cut takes
/// are the last `period` and the time that the disk needed. Writers do not wait for it. A disk that refuses
/// is said once.
class DiskSync {
 public:
  DiskSync(std::filesystem::path folder, std::chrono::nanoseconds period);
  ~DiskSync();
  DiskSync(const DiskSync&) = delete;
  DiskSync& operator=(const DiskSync&) = delete;

 private:
  void run(std::chrono::nanoseconds period);

  const std::filesystem::path folder_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;  // under mutex_
  std::thread thread_;
};

}  // namespace floatstage::capture
