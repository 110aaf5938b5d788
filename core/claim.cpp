#include "core/claim.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

enum class Lock { Ours, Others };

Unexpected cannot(const char* doing, const fs::path& path, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::NotFound : ErrorCode::Io;
  return fail(code, text("cannot ", doing, " ", path.string(), ": ", std::strerror(error_number)));
}

// Any other failure than a lock of somebody else's means that this file system has none.
Lock lock(const FileDescriptor& open) {
  return ::flock(open.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK ? Lock::Others : Lock::Ours;
}

// Whether the name still means what is open: its former holder may have renamed or removed it meanwhile.
bool is_still(const fs::path& path, const FileDescriptor& open) {
  struct stat named = {}, held = {};
  return ::lstat(path.c_str(), &named) == 0 && ::fstat(open.get(), &held) == 0 &&
         named.st_dev == held.st_dev && named.st_ino == held.st_ino;
}

FileDescriptor open_folder(const fs::path& folder, int more_flags) {
  return FileDescriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | more_flags));
}

Unexpected being_written(const fs::path& out) {
  return fail(ErrorCode::AlreadyExists,
              text(out.string(), " is being written by another run; wait for it, or choose another name"));
}

Result<void> refuse_existing(const fs::path& out) {
  struct stat there = {};
  if (::lstat(out.c_str(), &there) != 0) return {};
  return fail(ErrorCode::AlreadyExists,
              text(out.string(), " exists already and is never overwritten; choose another name"));
}

// `open_or_make` gives the open temporary, or errno: ELOOP and ENOTDIR and EEXIST say that something else has
// its name.
template <class OpenOrMake>
Result<Claim> claim_temporary(const fs::path& out, const OpenOrMake& open_or_make) {
  const fs::path temporary = temporary_name(out);
  for (;;) {
    FileDescriptor open = open_or_make(temporary);
    if (!open) {
      if (errno != ELOOP && errno != ENOTDIR && errno != EISDIR)
        return fail(ErrorCode::Io, text("cannot write ", out.string(), ": ", std::strerror(errno)));
      std::error_code error;
      fs::remove_all(temporary, error);  // removes a link, not what it leads to
      if (error)
        return fail(ErrorCode::Io, text("cannot remove ", temporary.string(), ": ", error.message()));
      continue;
    }
    if (lock(open) == Lock::Others) return being_written(out);
    if (is_still(temporary, open)) return Claim(std::move(open));
  }
}

}  // namespace

Result<NewFolder> claim_new_folder(const fs::path& folder) {
  const auto cannot_make = [&](const std::string& why) {
    return fail(ErrorCode::Io, text("cannot make the folder ", folder.string(), ": ", why));
  };
  for (;;) {
    std::error_code error;
    if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), error);
    if (error) return cannot_make(error.message());
    const bool made = ::mkdir(folder.c_str(), 0777) == 0;
    if (!made && errno != EEXIST) return cannot_make(std::strerror(errno));
    FileDescriptor open = open_folder(folder, 0);
    if (!open && errno == ENOENT) continue;  // its former holder gave it up
    if (!open) return cannot_make(std::strerror(errno));
    if (lock(open) == Lock::Others) return being_written(folder);
    struct stat named = {}, held = {};
    if (::stat(folder.c_str(), &named) != 0 || ::fstat(open.get(), &held) != 0 ||
        named.st_ino != held.st_ino || named.st_dev != held.st_dev)
      continue;
    const bool empty = fs::is_empty(folder, error);
    if (error)
      return fail(ErrorCode::Io, text("cannot read the folder ", folder.string(), ": ", error.message()));
    if (!empty)
      return fail(
          ErrorCode::AlreadyExists,
          text(folder.string(), " is not empty; a take needs a new folder, nothing is ever overwritten"));
    return NewFolder{Claim(std::move(open)), made};
  }
}

Result<Claim> claim_temporary_file(const fs::path& out, IfThere there) {
  Result<Claim> claim = claim_temporary(out, [](const fs::path& temporary) {
    return FileDescriptor(
        ::open(temporary.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, 0644));
  });
  if (!claim) return claim;
  std::error_code error;
  if (Result<void> ok = refuse_existing(out); !ok && there == IfThere::Refuse) {
    fs::remove(temporary_name(out), error);
    return forward(ok);
  }
  fs::resize_file(temporary_name(out), 0, error);
  if (error) return fail(ErrorCode::Io, text("cannot write ", out.string(), ": ", error.message()));
  return claim;
}

Result<Claim> claim_temporary_folder(const fs::path& out, IfThere there) {
  if (out.has_parent_path())
    if (Result<void> ok = make_folder(out.parent_path()); !ok) return forward(ok);
  Result<Claim> claim = claim_temporary(out, [](const fs::path& temporary) {
    if (::mkdir(temporary.c_str(), 0777) != 0 && errno != EEXIST) return FileDescriptor();
    return open_folder(temporary, O_NOFOLLOW);
  });
  if (!claim) return claim;
  const fs::path temporary = temporary_name(out);
  std::error_code error;
  for (const fs::directory_entry& left : fs::directory_iterator(temporary, error))
    if (fs::remove_all(left.path(), error); error) break;
  if (error) return fail(ErrorCode::Io, text("cannot clear ", temporary.string(), ": ", error.message()));
  if (Result<void> ok = refuse_existing(out); !ok && there == IfThere::Refuse) {
    fs::remove(temporary, error);
    return forward(ok);
  }
  return claim;
}

Result<Claim> wait_for_folder(const fs::path& folder, const std::function<bool()>& go_on) {
  FileDescriptor open = open_folder(folder, 0);
  if (!open) return cannot("read the folder", folder, errno);
  while (lock(open) == Lock::Others) {
    if (!go_on())
      return fail(ErrorCode::Cancelled, text("interrupted while another run worked on ", folder.string()));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return Claim(std::move(open));
}

Result<void> rename_new(const fs::path& from, const fs::path& to) {
  int failed = ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE);
  if (failed != 0 && (errno == EINVAL || errno == ENOSYS)) {  // not on this file system
    if (Result<void> ok = refuse_existing(to); !ok) return ok;
    failed = ::rename(from.c_str(), to.c_str());
  }
  if (failed == 0) return {};
  const int why = errno;
  if (Result<void> ok = refuse_existing(to); !ok && why == EEXIST) return ok;
  return cannot("name", to, why);
}

}  // namespace floatstage
