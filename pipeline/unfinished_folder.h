#pragma once

#include <filesystem>
#include <optional>

#include "core/claim.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A folder that is being made: claimed, under a temporary name beside the one that it will have, removed
/// again unless it was published.
class UnfinishedFolder {
 public:
  /// Claims `out`, which must not be there or be an empty folder and stands empty until the folder replaces
  /// it. InvalidArgument for what is no name; AlreadyExists; Io.
  static Result<UnfinishedFolder> begin(const std::filesystem::path& out);
  UnfinishedFolder(UnfinishedFolder&& other) noexcept;
  UnfinishedFolder(const UnfinishedFolder&) = delete;
  UnfinishedFolder& operator=(const UnfinishedFolder&) = delete;
  UnfinishedFolder& operator=(UnfinishedFolder&&) = delete;
  ~UnfinishedFolder();

  /// What is written to until then.
  const std::filesystem::path& folder() const { return folder_; }
  /// Gives the folder its name. Io.
  Result<void> publish();

 private:
  explicit UnfinishedFolder(std::filesystem::path out);

  std::filesystem::path out_, folder_;
  std::optional<NewFolder> out_claim_;
  std::optional<Claim> claim_;
  bool published_ = false;
};

}  // namespace floatstage::pipeline
