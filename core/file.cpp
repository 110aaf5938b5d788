#include "core/file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage {
namespace {

Unexpected io_error(const char* doing, const std::filesystem::path& file, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::NotFound : ErrorCode::Io;
  return fail(code, text("cannot ", doing, " ", file.string(), ": ", std::strerror(error_number)));
}

}  // namespace

Result<std::string> read_file(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return io_error("open", file, errno);
  std::string bytes;
  char buffer[1 << 16];
  for (;;) {
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int e = errno;
      ::close(fd);
      return io_error("read", file, e);
    }
    if (n == 0) break;
    bytes.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(fd);
  return bytes;
}

std::filesystem::path temporary_name(const std::filesystem::path& file) {
  return file.parent_path() / ("." + file.stem().string() + ".tmp" + file.extension().string());
}

Result<void> write_file(const std::filesystem::path& file, std::string_view bytes) {
  const std::filesystem::path temporary = temporary_name(file);
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
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
