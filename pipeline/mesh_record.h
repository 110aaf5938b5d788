#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "capture/added_file.h"
#include "core/result.h"
#include "core/take_layout.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// SHA-256 of mattes, by serial.
using MatteHashes = std::map<std::string, std::string>;

/// One mesh and what it was made from.
struct MeshEntry {
  std::string mesh;    ///< SHA-256 of its file
  std::string inputs;  ///< of the rig and the hull's options
  MatteHashes mattes;  ///< of the instant, of every camera that had one
  bool operator==(const MeshEntry&) const = default;
};

/// meshes/hull.json: with which options meshes are made, and a line a frame. A mesh that it does not know, or
/// knows with other bytes, is of unknown origin.
struct MeshRecord {
  nlohmann::json options;                 ///< as describe() wrote them; null: none yet
  std::map<int, nlohmann::json> reports;  ///< by frame: volume, empty, silhouette_iou, seconds
  std::map<int, MeshEntry> meshes;        ///< by frame
};

/// With what the journal holds beside it. A record of nothing without a file. BadData names the file.
Result<MeshRecord> load_mesh_record(const TakeLayout& layout);
/// Whole or not at all; the journal is left to its owner.
Result<void> save_mesh_record(const MeshRecord& record, const TakeLayout& layout);
/// The journal's line of one frame.
nlohmann::json to_journal(int frame, const MeshEntry& entry, const nlohmann::json& report);

/// What is to be done about a mesh: it is missing, or ours and made from something else than what is there
/// now (`inputs` and the mattes); or it is as it should be; or of unknown origin, and used as it is.
enum class MeshState { ToMake, Kept, Others };
Result<MeshState> state_of_mesh(const TakeLayout& layout, const Rig& rig, const MeshRecord& record,
                                const std::string& inputs, int frame);

/// Of a matte that is the sum of files: of one file its own.
std::string hash_of_parts(const std::vector<std::string>& hashes);
/// Of an instant's mattes as they lie on disk.
Result<MatteHashes> hashes_of_mattes(const TakeLayout& layout, const Rig& rig, int frame);

/// Of an instant's mattes, all of them.
std::string hash_of_instant(const MatteHashes& mattes);

/// Of what is the same for every frame: the rig's bytes and the options.
std::string hash_of_hull_inputs(const std::string& rig_sha256, const recon::HullOptions& options,
                                const capture::AddedFile& added, const std::string& occluders);

/// The camera of a matte that is there and that the mesh was not made from: the mesh is older than it.
std::optional<std::string> newer_matte(const MeshEntry& entry, const MatteHashes& mattes);

}  // namespace floatstage::pipeline
