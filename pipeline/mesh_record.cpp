#include "pipeline/mesh_record.h"

#include "capture/sha256.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"
#include "pipeline/hull_record.h"
#include "pipeline/made_files.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

// A frame's line, with or without hashes: those of before had none.
void take_line(int frame, json line, MeshRecord& record) {
  if (line.contains("mesh"))
    record.meshes[frame] = {line.at("mesh"), line.at("inputs"), line.at("mattes").get<MatteHashes>()};
  for (const char* hash : {"mesh", "inputs", "mattes"}) line.erase(hash);
  record.reports[frame] = std::move(line);
}

json line_of(const MeshEntry* entry, json line) {
  if (entry) line["mesh"] = entry->mesh, line["inputs"] = entry->inputs, line["mattes"] = entry->mattes;
  return line;
}

}  // namespace

Result<MeshRecord> load_mesh_record(const TakeLayout& layout) {
  MeshRecord record;
  const Result<std::string> bytes = read_file(layout.hull_report());
  if (!bytes && bytes.error().code != ErrorCode::NotFound) return forward(bytes);
  try {
    if (bytes) {
      const Result<json> parsed = parse_json(*bytes, layout.hull_report().string());
      if (!parsed) throw std::invalid_argument(parsed.error().message);
      const json& j = *parsed;
      record.options = j.value("options", json());
      if (j.contains("frames"))
        for (const auto& [frame, line] : j.at("frames").items()) take_line(std::stoi(frame), line, record);
    }
    for (json& line : read_journal(layout.meshes_journal())) {
      const int frame = line.at("frame");
      const Result<std::optional<std::string>> there = hash_of(layout.mesh(frame));
      if (!there || *there != line.at("mesh")) continue;  // said before the file was put in its place
      line.erase("frame");
      take_line(frame, std::move(line), record);
    }
  } catch (const std::exception& e) {  // JSON's and stoi's
    return fail(ErrorCode::BadData,
                text(layout.hull_report().string(), " does not say how the meshes were made (", e.what(),
                     "); remove it, and they are used as they are"));
  }
  return record;
}

Result<void> save_mesh_record(const MeshRecord& record, const TakeLayout& layout) {
  json frames = json::object();
  for (const auto& [frame, report] : record.reports) {
    const auto entry = record.meshes.find(frame);
    frames[std::to_string(frame)] = line_of(entry == record.meshes.end() ? nullptr : &entry->second, report);
  }
  return write_file(layout.hull_report(),
                    json{{"options", record.options}, {"frames", std::move(frames)}}.dump(2) + "\n");
}

json to_journal(int frame, const MeshEntry& entry, const json& report) {
  json line = line_of(&entry, report);
  line["frame"] = frame;
  return line;
}

Result<MeshState> state_of_mesh(const TakeLayout& layout, const Rig& rig, const MeshRecord& record,
                                const std::string& inputs, int frame) {
  const Result<std::optional<std::string>> there = hash_of(layout.mesh(frame));
  if (!there) return forward(there);
  if (!*there) return MeshState::ToMake;
  const auto known = record.meshes.find(frame);
  if (known == record.meshes.end() || known->second.mesh != **there) return MeshState::Others;
  if (known->second.inputs != inputs) return MeshState::ToMake;
  const Result<MatteHashes> mattes = hashes_of_mattes(layout, rig, frame);
  if (!mattes) return forward(mattes);
  return known->second.mattes == *mattes ? MeshState::Kept : MeshState::ToMake;
}

std::string hash_of_parts(const std::vector<std::string>& hashes) {
  if (hashes.size() == 1) return hashes.front();
  std::string all;
  for (const std::string& hash : hashes) all += hash;
  return capture::sha256(all);
}

Result<MatteHashes> hashes_of_mattes(const TakeLayout& layout, const Rig& rig, int frame) {
  MatteHashes all;
  for (const RigCamera& camera : rig.cameras) {
    std::vector<std::string> hashes;
    const std::vector<std::filesystem::path> files = layout.matte_files(camera.serial, frame);
    for (const std::filesystem::path& file : files) {
      const Result<std::optional<std::string>> hash = hash_of(file);
      if (!hash) return forward(hash);
      if (*hash) hashes.push_back(**hash);
    }
    if (hashes.size() == files.size()) all[camera.serial] = hash_of_parts(hashes);
  }
  return all;
}

std::string hash_of_instant(const MatteHashes& mattes) {
  std::string all;
  for (const auto& [serial, hash] : mattes) all += serial + " " + hash + "\n";
  return capture::sha256(all);
}

std::string hash_of_hull_inputs(const std::string& rig_sha256, const recon::HullOptions& options,
                                const capture::AddedFile& added, const std::string& occluders) {
  json bars = json::object();
  for (const auto& [serial, all] : added.cameras)
    if (const AddedContent c = added.of(serial); c.bars()) bars[serial] = {c.left, c.top, c.right, c.bottom};
  return capture::sha256(rig_sha256 + describe(options).dump() + (bars.empty() ? "" : bars.dump()) +
                         occluders);
}

std::optional<std::string> newer_matte(const MeshEntry& entry, const MatteHashes& mattes) {
  for (const auto& [serial, hash] : mattes) {
    const auto used = entry.mattes.find(serial);
    if (used == entry.mattes.end() || used->second != hash) return serial;
  }
  return std::nullopt;
}

}  // namespace floatstage::pipeline
