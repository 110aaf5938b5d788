#include "capture/disk_sync.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "core/file_descriptor.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

Result<void> sync(const fs::path& path, int flags) {
  const FileDescriptor open(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | flags));
  if (!open) return {};  // it has gone, or is a link: not what was written
  if (::fdatasync(open.get()) == 0) return {};
  return fail(ErrorCode::Io, text("the disk does not keep ", path.string(), ": ", std::strerror(errno)));
}

}  // namespace

Result<void> sync_folder(const fs::path& folder) {
  if (Result<void> ok = sync(folder, O_DIRECTORY); !ok) return ok;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::file_status status = entry.symlink_status(error);
    Result<void> ok;
    if (fs::is_directory(status)) ok = sync_folder(entry.path());
    if (fs::is_regular_file(status)) ok = sync(entry.path(), O_NONBLOCK);
    if (!ok) return ok;
  }
  return {};
}

DiskSync::DiskSync(fs::path folder, std::chrono::nanoseconds period)
    : folder_(std::move(folder)), thread_([this, period] { run(period); }) {}

DiskSync::~DiskSync() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void DiskSync::run(std::chrono::nanoseconds period) {
  bool said = false;
  for (bool last = false; !last;) {
    {
      std::unique_lock lock(mutex_);
      last = wake_.wait_for(lock, period, [&] { return ending_; });
    }
    const Result<void> kept = sync_folder(folder_);
    if (!kept && !std::exchange(said, true)) log::warning(kept.error().message);
  }
}

}  // namespace floatstage::capture
