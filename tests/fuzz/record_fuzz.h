#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include <unistd.h>

#include "core/check.h"
#include "core/file.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage {

/// Whatever `file` of a take says, load(layout) refuses it by name, or save(record, layout) writes it so that
/// it is loaded as same(a, b).
template <class File, class Load, class Save, class Same>
void claim_refused_or_kept(std::string_view bytes, const File& file_of, const Load& load, const Save& save,
                           const Same& same) {
  static const TakeLayout layout(std::filesystem::temp_directory_path() /
                                 text("floatstage-fuzz-", ::getpid()));
  const std::filesystem::path file = file_of(layout);
  std::filesystem::create_directories(file.parent_path());
  FLOATSTAGE_CHECK(write_file(file, bytes).has_value(), "the folder for temporary files takes none");
  if (const auto record = load(layout)) {
    FLOATSTAGE_CHECK(save(*record, layout).has_value(), "what was read is not written");
    const auto again = load(layout);
    FLOATSTAGE_CHECK(again && same(*again, *record), "a record that changes by being written");
  } else {
    FLOATSTAGE_CHECK(record.error().message.find(file.filename().string()) != std::string::npos,
                     "a file that is not named");
  }
  std::filesystem::remove_all(layout.folder());
}

}  // namespace floatstage
