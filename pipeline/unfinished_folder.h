#pragma once

#include <filesystem>
#include <optional>

#include "core/claim.h"

namespace floatstage::pipeline {

/// A folder that is written under a temporary name beside its own and appears whole, or not at all: removed
/// unless it was published (docs/adr/0221-claim-then-write.md).
class UnfinishedFolder {
 public:
  /// `out` may end in a slash. Nothing is touched before prepare().
  explicit UnfinishedFolder(const std::filesystem::path& out);
  UnfinishedFolder(const UnfinishedFolder&) = delete;
  UnfinishedFolder& operator=(const UnfinishedFolder&) = delete;
  ~UnfinishedFolder();

  /// Where to write until publish().
  const std::filesystem::path& folder() const { return folder_; }

  /// Claims `out`, which stands empty until the folder replaces it, and what is written until then.
  /// InvalidArgument when it is no name for a new folder; errors of claim_new_folder().
  Result<void> prepare();
  Result<void> publish();

 private:
  std::filesystem::path out_, folder_;
  std::optional<NewFolder> out_claim_;
  std::optional<Claim> claim_;
  bool published_ = false;
};

}  // namespace floatstage::pipeline
