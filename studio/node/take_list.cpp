#include "studio/node/take_list.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/take_layout.h"

namespace floatstage::studio {
namespace {

namespace fs = std::filesystem;

// The last row of a side file tells the length without reading the rest.
double length_of(const fs::path& frames_csv, double frame_rate) {
  const Result<std::string> bytes = read_file(frames_csv);
  if (!bytes || frame_rate <= 0) return 0;
  const auto lines = std::count(bytes->begin(), bytes->end(), '\n');
  return static_cast<double>(std::max<std::ptrdiff_t>(lines - 1, 0)) / frame_rate;
}

}  // namespace

std::optional<NodeTake> look_at_take(const fs::path& folder) {
  const TakeLayout layout(folder);
  const Result<std::string> bytes = read_file(layout.manifest());
  if (!bytes) return std::nullopt;
  const Result<TakeManifest> manifest = parse_manifest(*bytes, layout.manifest().string());
  if (!manifest) return std::nullopt;
  NodeTake take;
  take.name = folder.filename().string();
  take.created = manifest->created;
  take.complete = manifest->complete;
  take.cameras = static_cast<int>(manifest->cameras.size());
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (std::error_code ignored; entry.is_regular_file(ignored)) take.bytes += entry.file_size(ignored);
  if (!manifest->cameras.empty())
    take.seconds = length_of(layout.frames_csv(manifest->cameras.front().serial), manifest->frame_rate);
  if (const Result<std::string> quality = read_file(layout.quality())) {
    const Result<nlohmann::json> json = parse_json(*quality, layout.quality().string());
    if (json && json->is_object() && json->contains("verdict") && json->at("verdict").is_string())
      take.verdict = json->at("verdict").get<std::string>();
  }
  return take;
}

std::vector<NodeTake> list_takes(const fs::path& folder, std::size_t most) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (std::error_code ignored; entry.is_directory(ignored)) folders.push_back(entry.path());
  std::sort(folders.rbegin(), folders.rend());
  std::vector<NodeTake> takes;
  for (const fs::path& candidate : folders) {
    if (takes.size() == most) break;
    if (std::optional<NodeTake> take = look_at_take(candidate)) takes.push_back(std::move(*take));
  }
  return takes;
}

}  // namespace floatstage::studio
