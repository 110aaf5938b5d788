#include "pipeline/matte/matting_record.h"

#include <cstdint>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

std::filesystem::path file_of(const TakeLayout& layout) { return layout.mattes() / "matting.json"; }

constexpr struct {
  const char* name;
  std::string CameraRecord::*field;
} kFields[] = {{"method", &CameraRecord::method},
               {"chosen", &CameraRecord::chosen},
               {"key", &CameraRecord::key},
               {"guide", &CameraRecord::guide},
               {"edits", &CameraRecord::edits}};

}  // namespace

Result<std::map<std::string, CameraRecord>> load_matting(const TakeLayout& layout) {
  std::map<std::string, CameraRecord> record;
  const Result<std::string> bytes = read_file(file_of(layout));
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return record;
  if (!bytes) return forward(bytes);
  const json j = json::parse(*bytes, nullptr, false);
  const auto bad = [&] {
    return fail(ErrorCode::BadData,
                text(file_of(layout).string(),
                     " does not say how the mattes were made; run `floatstage matte` with --redo"));
  };
  if (!j.is_object()) return bad();
  for (const auto& [serial, camera] : j.items()) {
    if (!camera.is_object()) return bad();
    for (const auto& f : kFields) {
      if (!camera.contains(f.name) || !camera[f.name].is_string()) return bad();
      record[serial].*f.field = camera[f.name].get<std::string>();
    }
    if (!camera.contains("stale")) continue;
    if (!camera["stale"].is_array()) return bad();
    for (const json& frame : camera["stale"]) {
      if (!frame.is_number_integer() || frame.get<std::int64_t>() < 0 ||
          frame.get<std::int64_t>() > std::numeric_limits<int>::max())
        return bad();
      record[serial].stale.insert(frame.get<int>());
    }
  }
  return record;
}

Result<void> save_matting(const std::map<std::string, CameraRecord>& record, const TakeLayout& layout) {
  json j = json::object();
  for (const auto& [serial, camera] : record) {
    for (const auto& f : kFields) j[serial][f.name] = camera.*f.field;
    if (!camera.stale.empty()) j[serial]["stale"] = camera.stale;
  }
  return write_file(file_of(layout), j.dump(2) + "\n");
}

std::string fingerprint(const CameraEdits& edits) {
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a
  for (const char c : to_json(MatteEdits{{{"", edits}}}))
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

}  // namespace floatstage::pipeline
