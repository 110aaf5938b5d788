#include "capture/side_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage::capture {

SideFileWriter::SideFileWriter(SideFileWriter&& other) noexcept
    : file_(std::move(other.file_)), fd_(std::exchange(other.fd_, -1)) {}

SideFileWriter::~SideFileWriter() {
  if (fd_ >= 0) ::close(fd_);
}

Result<SideFileWriter> SideFileWriter::create(const std::filesystem::path& file) {
  SideFileWriter made;
  made.file_ = file;
  made.fd_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (made.fd_ < 0)
    return fail(ErrorCode::Io, text("cannot create ", file.string(), ": ", std::strerror(errno)));
  if (Result<void> ok = made.append(frames_csv_header()); !ok) return forward(ok);
  return made;
}

Result<void> SideFileWriter::write(const FrameRow& row) { return append(to_csv(row)); }

Result<void> SideFileWriter::append(const std::string& line) {
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t n = ::write(fd_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0)
      return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", std::strerror(errno),
                                      "; the rows before it are safe"));
    done += static_cast<std::size_t>(n);
  }
  return {};
}

}  // namespace floatstage::capture
