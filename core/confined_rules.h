#pragma once

#include <filesystem>
#include <vector>

namespace floatstage {

/// From here on this thread, and those that it starts, write and make files below these folders only; what
/// is open already stays open. False where the kernel has no Landlock. Takes the right to gain privileges.
bool write_only_below(const std::vector<std::filesystem::path>& folders);

/// From here on this thread, and those that it starts, may compute, use memory and files, and start threads.
/// Sockets, other programs and other processes end the process by SIGSYS; what else there is fails as on a
/// kernel that does not know it. False where the kernel has no seccomp filters.
bool call_only_what_decoders_call();

}  // namespace floatstage
