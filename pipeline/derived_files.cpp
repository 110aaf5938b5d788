#include "pipeline/derived_files.h"

#include <vector>

namespace floatstage::pipeline {

namespace fs = std::filesystem;

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
