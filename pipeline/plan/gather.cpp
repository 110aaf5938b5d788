#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "pipeline/derived_files.h"
#include "pipeline/made_files.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/mesh_record.h"
#include "pipeline/plan/take_view.h"
#include "pipeline/process/silhouette_faults.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

enum class Place { Ours, Others };

// Whose the name is in the take: ours where nothing is, or what the record knows, or what we are about to put
// there.
Result<Place> place_of(const fs::path& file, const std::string* known, const std::string& coming) {
  const Result<std::optional<std::string>> there = hash_of(file);
  if (!there) return forward(there);
  const bool ours = !*there || **there == coming || (known && **there == *known);
  return ours ? Place::Ours : Place::Others;
}

template <class Map>
const std::string* find_in(const Map& hashes, int frame) {
  const auto found = hashes.find(frame);
  return found == hashes.end() ? nullptr : &found->second;
}

// What the record of a run says of one of its frames.
void take_over(const CameraRecord& from, int frame, CameraRecord& to) {
  to.forget(frame);
  to.files[frame] = from.files.at(frame);
  if (const auto healed = from.healed.find(frame); healed != from.healed.end())
    to.healed[frame] = healed->second;
  if (const auto compared = from.compared.find(frame); compared != from.compared.end())
    to.compared[frame] = compared->second;
  if (from.guided.contains(frame)) to.guided.insert(frame);
  for (const auto& [why, frames] : from.doubts)
    if (frames.contains(frame)) to.doubts[why].insert(frame);
}

// One matte of a delivery; whether it is in the take now.
Result<bool> gather_matte(MatteStore& store, const TakeLayout& delivery, const std::string& serial, int frame,
                          const CameraRecord& from) {
  const std::string& hash = from.files.at(frame);
  CameraRecord& camera = store.camera(serial);
  const fs::path source = delivery.matte(serial, frame), target = store.layout().matte(serial, frame);
  const Result<Place> place = place_of(target, find_in(camera.files, frame), hash);
  if (!place) return forward(place);
  if (*place == Place::Others) return false;
  if (is_there(source)) {
    if (Result<void> ok = store.adopt(serial, frame, source, hash); !ok) return forward(ok);
  } else if (!is_there(target)) {
    return false;
  }
  take_over(from, frame, camera);
  return true;
}

// What a camera's mattes are made from, whichever of them.
void take_way(const CameraRecord& from, CameraRecord& to) {
  to.how = from.how, to.method = from.method, to.key = from.key, to.guide = from.guide;
  to.inputs = from.inputs, to.edits = from.edits;
}

Result<bool> gather_mesh(Journal& journal, const TakeLayout& take, const TakeLayout& delivery, int frame,
                         const MeshRecord& from, MeshRecord& record) {
  const MeshEntry& entry = from.meshes.at(frame);
  const fs::path source = delivery.mesh(frame), target = take.mesh(frame);
  const auto known = record.meshes.find(frame);
  const Result<Place> place =
      place_of(target, known == record.meshes.end() ? nullptr : &known->second.mesh, entry.mesh);
  if (!place) return forward(place);
  if (*place == Place::Others) return false;
  if (is_there(source)) {
    if (Result<void> ok = journal.add(to_journal(frame, entry, from.reports.at(frame))); !ok)
      return forward(ok);
    if (Result<void> ok = move_file(source, target); !ok) return forward(ok);
  } else if (!is_there(target)) {
    return false;
  }
  record.meshes[frame] = entry;
  record.reports[frame] = from.reports.at(frame);
  return true;
}

Result<void> gather_faults(const TakeLayout& take, const std::vector<fs::path>& done,
                           const MeshRecord& record) {
  const HullDoubts doubts = doubts_in(record.reports, {});
  DoubtPictures pictures(take.meshes() / "faults");
  for (const SilhouetteFault& fault : doubts.faults) {
    const std::string name = picture_name(fault.serial, fault.worst);
    for (const fs::path& folder : done)
      if (const fs::path picture = TakeLayout(folder).with_labels(take.labels()).meshes() / "faults" / name;
          is_there(picture))
        if (Result<void> ok = pictures.take_in(picture, name, picture_of_fault(fault.serial, fault.worst));
            !ok)
          return ok;
  }
  return keep_pictures(doubts.faults, take.meshes() / "faults");
}

}  // namespace

Result<int> gather_mattes(const TakeLayout& take, const std::vector<fs::path>& done,
                          const std::map<std::string, std::set<int>>& stale) {
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open(take);
  if (!store) return forward(store);
  if (Result<void> ok = make_folder(take.mattes()); !ok) return forward(ok);
  int put = 0;
  std::set<std::string> serials;
  for (const fs::path& folder : done) {
    const TakeLayout delivery(folder);
    const Result<MatteRecord> record = load_matte_record(delivery);
    if (!record) return forward(record);
    for (const auto& [serial, from] : *record) {
      if (!is_folder(delivery.mattes() / serial)) continue;  // it was there before
      CameraRecord& camera = (*store)->camera(serial);
      take_way(from, camera);
      serials.insert(serial);
      for (const auto& [frame, hash] : from.files) {
        const Result<bool> ours = gather_matte(**store, delivery, serial, frame, from);
        if (!ours) return forward(ours);
        put += *ours;
      }
      camera.stale.insert(from.stale.begin(), from.stale.end());
    }
  }
  for (const auto& [serial, frames] : stale)
    if (serials.contains(serial)) (*store)->camera(serial).stale.insert(frames.begin(), frames.end());
  if (Result<void> ok = (*store)->save({serials.begin(), serials.end()}); !ok) return forward(ok);
  return put;
}

Result<int> gather_meshes(const TakeLayout& take, const std::vector<fs::path>& done) {
  if (done.empty()) return 0;
  if (Result<void> ok = make_folder(take.meshes()); !ok) return forward(ok);
  Result<MeshRecord> record = load_mesh_record(take);
  if (!record) return forward(record);
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open(take);
  if (!store) return forward(store);
  Journal journal(take.meshes_journal());
  int put = 0;
  std::set<std::string> compared;
  for (const fs::path& folder : done) {
    const TakeLayout delivery = TakeLayout(folder).with_labels(take.labels());
    const Result<MatteRecord> mattes = load_matte_record(delivery);
    const Result<MeshRecord> meshes = load_mesh_record(delivery);
    if (!mattes) return forward(mattes);
    if (!meshes) return forward(meshes);
    for (const auto& [serial, from] : *mattes)
      for (const auto& [frame, instant] : from.compared) {  // those that were healed, and the others
        const Result<bool> ours = gather_matte(**store, delivery, serial, frame, from);
        if (!ours) return forward(ours);
        if (*ours) compared.insert(serial);
      }
    record->options = meshes->options;
    for (const auto& [frame, entry] : meshes->meshes) {
      const Result<bool> ours = gather_mesh(journal, take, delivery, frame, *meshes, *record);
      if (!ours) return forward(ours);
      put += *ours;
    }
  }
  if (!compared.empty())
    if (Result<void> ok = (*store)->save({compared.begin(), compared.end()}); !ok) return forward(ok);
  if (Result<void> ok = save_mesh_record(*record, take); !ok) return forward(ok);
  journal.remove();
  if (Result<void> ok = gather_faults(take, done, *record); !ok) return forward(ok);
  return put;
}

}  // namespace floatstage::pipeline
