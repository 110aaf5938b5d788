#include "apps/calibrate/scratch_folder.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include <unistd.h>

#include "core/text.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBegin = "floatstage-scene-";

// Folders of processes that are no more.
void sweep(const fs::path& temporary) {
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::directory_iterator it(temporary, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(kBegin)) continue;
    const long process = std::atol(name.c_str() + std::string(kBegin).size());
    if (process > 0 && kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
      left.push_back(it->path());
  }
  for (const fs::path& folder : left) fs::remove_all(folder, error);
}

}  // namespace

ScratchFolder::ScratchFolder(const fs::path& given) : folder_(given), stays_(!given.empty()) {
  if (stays_) return;
  std::error_code error;
  const fs::path temporary = fs::temp_directory_path(error);
  sweep(temporary);
  std::string name = (temporary / text(kBegin, getpid(), "-XXXXXX")).string();
  if (error || mkdtemp(name.data()) == nullptr)
    ready_ = fail(ErrorCode::Io, text(name, ": cannot be made; give --workspace"));
  folder_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!stays_ && ready_) fs::remove_all(folder_, ignored);
}

}  // namespace floatstage::apps
