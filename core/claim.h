#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/file_descriptor.h"
#include "core/result.h"

namespace floatstage {

/// The right to write a file or folder that no other process has at the same time: a lock of the operating
/// system (flock(2)) on the thing itself, so that nothing is left to clear away when the holder is killed.
/// Where a file system knows no locks (some network mounts) every claim is granted
/// (docs/adr/0221-claim-then-write.md).
class Claim {
 public:
  Claim() = default;
  explicit Claim(FileDescriptor held) : held_(std::move(held)) {}

 private:
  FileDescriptor held_;
};

/// Whether a claim of a new folder made the folder: who undoes his work removes what he made.
struct NewFolder {
  Claim claim;
  bool made = false;
};

/// A folder that must not be there yet, or be empty, now ours. AlreadyExists when there is anything in it or
/// another process has claimed it; nothing is changed then. Io names the folder.
Result<NewFolder> claim_new_folder(const std::filesystem::path& folder);

enum class IfThere { Refuse, Replace };

/// temporary_name(out) as an empty file or folder, ours until it is renamed: what a killed run left there is
/// cleared away; a link there is removed and never followed. AlreadyExists when another process is writing
/// `out`, or when `out` is there and is not to be replaced; Io.
Result<Claim> claim_temporary_file(const std::filesystem::path& out, IfThere there = IfThere::Refuse);
Result<Claim> claim_temporary_folder(const std::filesystem::path& out, IfThere there = IfThere::Refuse);

/// A folder that is there, for as long as the claim lives; waits while another process has it and asks
/// `go_on` ten times a second: once it answers no, Cancelled. NotFound, Io.
Result<Claim> wait_for_folder(const std::filesystem::path& folder, const std::function<bool()>& go_on);

/// rename(2) that never replaces what is there: AlreadyExists names `to`; Io.
Result<void> rename_new(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace floatstage
