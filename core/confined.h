#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage {

/// What a confined child may have.
struct Confinement {
  std::string what;                                  ///< names its work where no file is known
  std::vector<std::filesystem::path> writable = {};  ///< folders that are there: it writes below these only
  std::uint64_t memory = 0;    ///< bytes more than now; 0: as much as the machine has free
  double decode_seconds = 60;  ///< of processor time for what one WorkingOn embraces
  double ending_seconds = 0;   ///< how long it may go on once asked_to_end()
};

/// How a child speaks to its parent while it works. Any thread.
using Tell = std::function<void(std::string_view)>;

/// Runs `work` in a child process (fork without exec) that can do little: no network, no other program, no
/// other process, nothing written outside `writable`, no more memory than stated, no core file
/// (docs/adr/0229-foreign-media-in-a-confined-child.md). It is for decoders of foreign files: one that is
/// taken over or crashes takes its child with it. The child has one thread, this one, and what this process
/// knew; what it changes in memory is lost. What `work` gives is returned, and its error.
///
/// `watch` gets what the child tells, in order, and an empty word ten times a second; when it fails the child
/// is ended and that error returned: at once, or where `ending_seconds` are given once it has been asked to
/// end and has done so, with its own error, or has not within them. What it is told is a stranger's word.
///
/// A child that dies is an error which names the files that it was decoding (WorkingOn), or `what`: BadData
/// when it crashed, did what no decoder does, wanted more memory or time than it may have; Io when somebody
/// else ended it or no process can be made. An exception in it is thrown here, a CheckFailure as itself.
Result<std::string> run_confined(const Confinement& limits,
                                 const std::function<Result<std::string>(const Tell&)>& work,
                                 const std::function<Result<void>(std::string_view)>& watch);

/// From inside of `work`: no more memory than so many bytes beyond what the child began with, where that is
/// less than it may have now.
void confine_memory(std::uint64_t bytes);

/// From inside of `work`: whether it is to end by itself. Any thread.
bool asked_to_end();

/// Whether this kernel keeps a child from writing elsewhere (Landlock) and from calls that are not its
/// business (seccomp). Where it cannot, run_confined() goes on with what there is, and says so once.
struct ConfiningKernel {
  bool landlock = false, seccomp = false;
};
ConfiningKernel confining_kernel();

}  // namespace floatstage
