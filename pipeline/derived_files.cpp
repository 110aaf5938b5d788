#include "pipeline/derived_files.h"

#include <vector>

#include "core/file.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

void sweep_temporaries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> halves;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, error))
    if (is_temporary(entry.path())) halves.push_back(entry.path());
  for (const fs::path& half : halves) fs::remove(half, error);
}

Result<void> move_file(const fs::path& from, const fs::path& to) {
  if (Result<void> ok = make_folder(to.parent_path()); !ok) return ok;
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return {};
  if (error != std::errc::cross_device_link)
    return fail(ErrorCode::Io, text("cannot write ", to.string(), ": ", error.message()));
  const Result<std::string> bytes = read_file(from);
  if (!bytes) return forward(bytes);
  if (Result<void> ok = write_file(to, *bytes); !ok) return ok;
  fs::remove(from, error);
  return {};
}

Result<Claim> claim_take(const fs::path& take, const Progress* progress) {
  bool said = false;
  return wait_for_folder(take, [&] {
    if (!said) log::info(text("another run is writing in ", take.string(), "; this one waits for it"));
    said = true;
    return !is_cancelled(progress);
  });
}

}  // namespace floatstage::pipeline
