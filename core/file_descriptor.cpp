#include "core/file_descriptor.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage {
namespace {

Unexpected cannot(const char* doing, const std::filesystem::path& file, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::NotFound : ErrorCode::Io;
  return fail(code, text("cannot ", doing, " ", file.string(), ": ", std::strerror(error_number)));
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<FileDescriptor> open_to_read(const std::filesystem::path& file) {
  // A pipe is opened without waiting for its writer, and a terminal does not become ours.
  FileDescriptor open(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!open) return cannot("open", file, errno);
  struct stat status = {};
  if (::fstat(open.get(), &status) != 0) return cannot("open", file, errno);
  if (S_ISREG(status.st_mode)) return open;
  return fail(ErrorCode::Io, text("cannot read ", file.string(), ": it is ", kind_of(status.st_mode),
                                  ", not a file; copy its contents to a file and give that"));
}

Result<std::uint64_t> size_of(const FileDescriptor& open, const std::filesystem::path& file) {
  struct stat status = {};
  if (::fstat(open.get(), &status) != 0) return cannot("read", file, errno);
  return static_cast<std::uint64_t>(status.st_size);
}

}  // namespace floatstage
