#include "core/file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage {
namespace {

Unexpected io_error(const char* doing, const std::filesystem::path& file, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::NotFound : ErrorCode::Io;
  return fail(code, text("cannot ", doing, " ", file.string(), ": ", std::strerror(error_number)));
}

}  // namespace

Result<std::string> read_file(const std::filesystem::path& file, std::uint64_t most) {
  const Result<FileDescriptor> open = open_to_read(file);
  if (!open) return forward(open);
  const Result<std::uint64_t> size = size_of(*open, file);
  if (!size) return forward(size);
  const auto too_large = [&] {
    return fail(ErrorCode::BadData, text(file.string(), " has more than ", most >> 20,
                                         " MiB; no file of its kind is that large"));
  };
  if (*size > most) return too_large();
  std::string bytes;
  bytes.resize(*size + 1);  // one more, to meet the end in the same call
  std::size_t done = 0;
  for (;;) {
    const ssize_t n = ::read(open->get(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error("read", file, errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
    if (done > most) return too_large();
    if (done == bytes.size()) bytes.resize(2 * done);  // it grew since, or it is one of /proc
  }
  bytes.resize(done);
  return bytes;
}

std::filesystem::path temporary_name(const std::filesystem::path& file) {
  return file.parent_path() / ("." + file.stem().string() + ".tmp" + file.extension().string());
}

namespace {

// A name of nobody else's, made by this call: two writers of one file do not meet in its temporary, and a
// link that somebody left there is not followed.
int make_temporary(const std::filesystem::path& file, std::filesystem::path& made) {
  static std::atomic<unsigned> count = 0;
  const std::filesystem::path shared = temporary_name(file);
  for (;;) {
    made = shared.parent_path() /
           text(shared.stem().string(), '-', ::getpid(), '-', count++, shared.extension().string());
    const int fd = ::open(made.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
}

}  // namespace

bool is_temporary(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::size_t mark = name.rfind(".tmp");
  if (!name.starts_with('.') || mark == std::string::npos || mark == 0) return false;
  const std::size_t end = name.find_first_not_of("-0123456789", mark + 4);
  return end == std::string::npos || (name[end] == '.' && name.find('.', end + 1) == std::string::npos);
}

Result<void> write_file(const std::filesystem::path& file, std::string_view bytes) {
  std::filesystem::path temporary;
  const int fd = make_temporary(file, temporary);
  if (fd < 0) return io_error("write", file, errno);
  int failure = 0;
  for (std::size_t done = 0; done < bytes.size() && !failure;) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n >= 0)
      done += static_cast<std::size_t>(n);
    else if (errno != EINTR)
      failure = errno;
  }
  if (!failure && ::fsync(fd) != 0) failure = errno;
  if (::close(fd) != 0 && !failure) failure = errno;
  if (!failure && ::rename(temporary.c_str(), file.c_str()) != 0) failure = errno;
  if (failure) {
    ::unlink(temporary.c_str());
    return io_error("write", file, failure);
  }
  return {};
}

Result<void> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(ErrorCode::Io, text("cannot make the folder ", folder.string(), ": ", error.message()));
  return {};
}

}  // namespace floatstage
