#pragma once

#include <filesystem>

#include "core/result.h"

namespace floatstage::apps {

/// A folder for what another program writes while it works: a given one, which stays, or one in the temporary
/// folder that goes with this object. Its name has the process in it: what a process that was killed could
/// not remove, the next one does.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::filesystem::path& given);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  bool stays() const { return stays_; }
  const Result<void>& ready() const { return ready_; }  ///< Io when none could be made

 private:
  std::filesystem::path folder_;
  bool stays_;
  Result<void> ready_;
};

}  // namespace floatstage::apps
