#include "pipeline/derived_files.h"

#include <vector>

#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

Result<void> clear_for_redo(const fs::path& folder, const fs::path& keep) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path() != keep) entries.push_back(entry.path());
  if (error == std::errc::no_such_file_or_directory) return {};
  for (const fs::path& entry : entries)
    if (!error) fs::remove_all(entry, error);
  if (error) return fail(ErrorCode::Io, text("cannot clear ", folder.string(), ": ", error.message()));
  return {};
}

void sweep_temporaries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> halves;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, error)) {
    const fs::path finished = entry.path().stem().stem();  // ".000012.tmp.png" → ".000012"
    if (entry.path() ==
            entry.path().parent_path() / (finished.string() + ".tmp" + entry.path().extension().string()) &&
        finished.string().starts_with('.'))
      halves.push_back(entry.path());
  }
  for (const fs::path& half : halves) fs::remove(half, error);
}

}  // namespace floatstage::pipeline
