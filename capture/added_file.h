#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/added_content.h"
#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::capture {

/// added.json of a take: what lies over its pictures that no lens has seen, and whether readers hide it.
/// {"floatstage_added": 1, "hidden": true, "cameras": [{"serial", "bars": [left, top, right, bottom],
/// "overlays": [[x, y, width, height], …]}]}, px; cameras to whose pictures nothing was added are not in it.
/// May be edited, and be deleted: then it is looked for again.
struct AddedFile {
  bool hidden = true;
  std::map<std::string, AddedContent> cameras = {};  ///< by serial
  bool operator==(const AddedFile&) const = default;

  /// Of one camera what readers hide; nothing where they do not.
  AddedContent of(const std::string& serial) const;
};

std::filesystem::path added_file(const TakeLayout& take);
std::string to_json(const AddedFile& added);
/// BadData for what makes no sense: negative sizes, numbers beyond any picture.
Result<AddedFile> parse_added(std::string_view json, std::string_view name_for_errors);
/// Nothing added where the take has no such file.
Result<AddedFile> load_added(const TakeLayout& take);
Result<void> save_added(const AddedFile& added, const TakeLayout& take);

}  // namespace floatstage::capture
