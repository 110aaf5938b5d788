#include "pipeline/matte_record.h"

#include <iterator>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"
#include "pipeline/made_files.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;

constexpr struct {
  const char* name;
  std::string CameraRecord::*field;
} kFields[] = {{"how", &CameraRecord::how},
               {"method", &CameraRecord::method},
               {"key", &CameraRecord::key},
               {"guide", &CameraRecord::guide},
               {"inputs", &CameraRecord::inputs}};

// A camera's part of edits.json.
json to_json(const CameraEdits& edits) {
  return json::parse(floatstage::to_json(MatteEdits{{{"camera", edits}}})).at("cameras").at("camera");
}

Result<CameraEdits> edits_of(const json& j, const std::string& name) {
  const json whole = {{"floatstage_edits", 1}, {"cameras", {{"camera", j}}}};
  Result<MatteEdits> edits = parse_matte_edits(whole.dump(), name);
  if (!edits) return forward(edits);
  return std::move(edits->cameras["camera"]);
}

CameraRecord camera_of(const json& j, const std::string& name) {
  CameraRecord record;
  for (const auto& f : kFields) record.*f.field = j.at(f.name).get<std::string>();
  for (const auto& [frame, hash] : j.at("files").items()) record.files[std::stoi(frame)] = hash;
  record.stale = j.value("stale", std::set<int>());
  record.guided = j.value("guided", std::set<int>());
  const json healed = j.value("healed", json::object());
  for (const auto& [frame, h] : healed.items())
    record.healed[std::stoi(frame)] = {h.at("lost"), h.at("gained"), h.at("by")};
  const json compared = j.value("compared", json::object());
  for (const auto& [frame, hash] : compared.items()) record.compared[std::stoi(frame)] = hash;
  const json doubts = j.value("doubts", json::object());
  for (const auto& [why, frames] : doubts.items())
    if (std::set<int> of = frames; !of.empty()) record.doubts[why] = std::move(of);
  if (j.contains("edits")) {
    Result<CameraEdits> edits = edits_of(j.at("edits"), name);
    if (!edits) throw std::invalid_argument(edits.error().message);
    record.edits = std::move(*edits);
  }
  return record;
}

}  // namespace

void CameraRecord::forget(int frame) {
  stale.erase(frame);
  guided.erase(frame);
  healed.erase(frame);
  compared.erase(frame);
  for (auto of = doubts.begin(); of != doubts.end();) {
    of->second.erase(frame);
    of = of->second.empty() ? doubts.erase(of) : std::next(of);
  }
}

Result<MatteRecord> load_matte_record(const TakeLayout& layout) {
  const std::string name = layout.made_mattes().string();
  const auto bad = [&](const std::string& why) {
    return fail(ErrorCode::BadData, text(name, " does not say how the mattes were made (", why,
                                         "); remove it, and they are used as mattes of unknown origin"));
  };
  MatteRecord record;
  const Result<std::string> bytes = read_file(name);
  if (!bytes && bytes.error().code != ErrorCode::NotFound) return forward(bytes);
  try {
    if (bytes) {
      const Result<json> parsed = parse_json(*bytes, name);
      if (!parsed) return bad(parsed.error().message);
      const json& j = *parsed;
      if (const int version = j.at("floatstage_mattes"); version != kVersion)
        return fail(ErrorCode::Unsupported, text(name, ": record format ", version, " is not known here"));
      for (const auto& [serial, camera] : j.at("cameras").items()) record[serial] = camera_of(camera, name);
    }
    for (const json& line : read_journal(layout.mattes_journal())) {
      const auto camera = record.find(line.at("camera").get<std::string>());
      if (camera == record.end()) continue;
      const int frame = line.at("frame");
      const std::string hash = line.at("sha256");
      const Result<std::optional<std::string>> there = hash_of(layout.matte(camera->first, frame));
      if (!there || *there != hash) continue;  // it was said before the file was put in its place
      camera->second.files[frame] = hash;
      camera->second.forget(frame);  // the journal says nothing of healing or doubts; the next save would
    }
  } catch (const std::exception& e) {  // JSON's and stoi's
    return bad(e.what());
  }
  return record;
}

Result<void> save_matte_record(const MatteRecord& record, const TakeLayout& layout) {
  json cameras = json::object();
  for (const auto& [serial, camera] : record) {
    json& j = cameras[serial];
    for (const auto& f : kFields) j[f.name] = camera.*f.field;
    j["files"] = json::object();
    for (const auto& [frame, hash] : camera.files) j["files"][std::to_string(frame)] = hash;
    if (!camera.stale.empty()) j["stale"] = camera.stale;
    if (!camera.guided.empty()) j["guided"] = camera.guided;
    for (const auto& [frame, h] : camera.healed)
      j["healed"][std::to_string(frame)] = {{"lost", h.lost}, {"gained", h.gained}, {"by", h.by}};
    for (const auto& [frame, hash] : camera.compared) j["compared"][std::to_string(frame)] = hash;
    for (const auto& [why, frames] : camera.doubts) j["doubts"][why] = frames;
    if (camera.edits != CameraEdits()) j["edits"] = to_json(camera.edits);
  }
  const json whole = {{"floatstage_mattes", kVersion}, {"cameras", std::move(cameras)}};
  return write_file(layout.made_mattes(), whole.dump(1) + "\n");
}

}  // namespace floatstage::pipeline
