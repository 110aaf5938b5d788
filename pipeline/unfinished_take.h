#pragma once

#include <filesystem>
#include <optional>

#include "core/claim.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A take that is being made: claimed, under a temporary name beside the one that it will have, removed again
/// unless it was published.
class UnfinishedTake {
 public:
  /// Claims `out`, which must not be there or be an empty folder and stands empty until the take replaces it.
  /// InvalidArgument for what is no name; AlreadyExists; Io.
  static Result<UnfinishedTake> begin(const std::filesystem::path& out);
  UnfinishedTake(UnfinishedTake&& other) noexcept;
  UnfinishedTake(const UnfinishedTake&) = delete;
  UnfinishedTake& operator=(const UnfinishedTake&) = delete;
  UnfinishedTake& operator=(UnfinishedTake&&) = delete;
  ~UnfinishedTake();

  /// What is written to until then.
  const std::filesystem::path& folder() const { return folder_; }
  /// Gives the take its name. Io.
  Result<void> publish();

 private:
  explicit UnfinishedTake(std::filesystem::path out);

  std::filesystem::path out_, folder_;
  std::optional<NewFolder> out_claim_;
  std::optional<Claim> claim_;
  bool published_ = false;
};

}  // namespace floatstage::pipeline
