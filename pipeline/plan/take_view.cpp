#include "pipeline/plan/take_view.h"

#include <algorithm>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/label_record.h"
#include "pipeline/matte_record.h"
#include "pipeline/mesh_record.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

Result<void> done_or(const std::error_code& error, const char* doing, const fs::path& path) {
  if (!error) return {};
  return fail(ErrorCode::Io, text("cannot ", doing, " ", path.string(), ": ", error.message()));
}

// A link to what is there; nothing where nothing is.
Result<void> link(const fs::path& from, const fs::path& to) {
  if (!is_there(from)) return {};
  if (Result<void> ok = make_folder(to.parent_path()); !ok) return ok;
  std::error_code error;
  fs::create_symlink(from, to, error);
  return done_or(error, "link", to);
}

// Derived files are linked one by one; plans and films in the making are nobody's business.
bool is_recorded(const fs::path& name) {
  return name != "mattes" && name != "meshes" && name.extension() != ".plan" && name.extension() != ".parts";
}

Result<void> link_recording(const fs::path& take, const fs::path& view) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(take, error))
    if (is_recorded(entry.path().filename()))
      if (Result<void> ok = link(entry.path(), view / entry.path().filename()); !ok) return ok;
  return done_or(error, "list", take);
}

template <class Map>
void keep_only(Map& by_frame, const std::set<int>& frames) {
  for (auto it = by_frame.begin(); it != by_frame.end();)
    it = frames.contains(it->first) ? std::next(it) : by_frame.erase(it);
}

Result<void> copy_records(const TakeLayout& take, const std::set<int>& frames, const TakeLayout& view) {
  Result<MatteRecord> mattes = load_matte_record(take);
  if (!mattes) return forward(mattes);
  for (auto& [serial, camera] : *mattes) {
    keep_only(camera.files, frames);
    keep_only(camera.healed, frames);
    keep_only(camera.compared, frames);
    for (std::set<int>* of : {&camera.stale, &camera.guided})
      std::erase_if(*of, [&](int frame) { return !frames.contains(frame); });
    for (auto& [why, of] : camera.doubts)
      std::erase_if(of, [&](int frame) { return !frames.contains(frame); });
    std::erase_if(camera.doubts, [](const auto& doubt) { return doubt.second.empty(); });
  }
  if (!mattes->empty())
    if (Result<void> ok = save_matte_record(*mattes, view); !ok) return ok;
  Result<MeshRecord> meshes = load_mesh_record(take);
  if (!meshes) return forward(meshes);
  if (meshes->options.is_null()) return {};
  keep_only(meshes->reports, frames);
  keep_only(meshes->meshes, frames);
  return save_mesh_record(*meshes, view);
}

// What the take's labels are made from, of these frames, where some of them were chosen.
Result<void> copy_label_record(const TakeLayout& take, const std::set<int>& frames, const TakeLayout& view) {
  if (take.labels().empty()) return {};
  Result<LabelRecord> record = load_label_record(take);
  if (!record) return forward(record);
  for (auto& [serial, of] : record->sums) keep_only(of, frames);
  for (auto& [label, files] : record->files)
    for (auto& [serial, of] : files) keep_only(of, frames);
  return save_label_record(*record, view);
}

// Files of a folder that are no links, in order of their names.
std::vector<fs::path> written_in(const fs::path& folder, const char* extension) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
    if (!entry.is_symlink(none) && entry.is_regular_file(none) && entry.path().extension() == extension &&
        !is_temporary(entry.path()))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> written_in(const TakeLayout& view) {
  std::vector<fs::path> files;
  const auto add = [&](const fs::path& folder, const char* extension) {
    for (fs::path& file : written_in(folder, extension)) files.push_back(std::move(file));
  };
  std::error_code none;
  for (const fs::directory_entry& camera : fs::directory_iterator(view.mattes(), none))
    if (camera.is_directory(none) && !camera.is_symlink(none) && camera.path().filename() != "doubts")
      add(camera.path(), ".png");
  add(view.meshes(), ".ply");
  add(view.meshes() / "faults", ".png");
  for (const fs::path& record : {view.made_mattes(), view.hull_report()})
    if (is_there(record)) files.push_back(record);
  return files;
}

}  // namespace

Result<void> make_view(const TakeLayout& take, const ViewPart& part, const fs::path& view) {
  std::error_code error;
  const fs::path folder = fs::canonical(take.folder(), error);
  const TakeLayout from = TakeLayout(folder).with_labels(take.labels()),
                   to = TakeLayout(view).with_labels(take.labels());
  if (error) return done_or(error, "open", take.folder());
  if (Result<void> ok = link_recording(from.folder(), view); !ok) return ok;
  if (Result<void> ok = link(from.edits(), to.edits()); !ok) return ok;
  if (Result<void> ok = link(from.mattes() / "given", to.mattes() / "given"); !ok) return ok;
  for (const int frame : part.frames) {
    for (const std::string& serial : part.cameras) {
      if (Result<void> ok = link(from.matte(serial, frame), to.matte(serial, frame)); !ok) return ok;
      for (const std::string& label : from.labels())
        if (Result<void> ok =
                link(from.label_matte(serial, label, frame), to.label_matte(serial, label, frame));
            !ok)
          return ok;
    }
    if (Result<void> ok = link(from.mesh(frame), to.mesh(frame)); !ok) return ok;
  }
  const std::set<int> frames(part.frames.begin(), part.frames.end());
  if (Result<void> ok = copy_label_record(from, frames, to); !ok) return ok;
  return copy_records(from, frames, to);
}

Result<std::uint64_t> deliver(const TakeLayout& view, const fs::path& done) {
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  const fs::path half = done.parent_path() / text(".", done.filename().string(), ".", host, ".", getpid());
  std::error_code error;
  fs::remove_all(half, error);
  std::uint64_t bytes = 0;
  Result<void> ok = make_folder(half);
  for (const fs::path& file : ok ? written_in(view) : std::vector<fs::path>()) {
    bytes += fs::file_size(file, error);
    ok = move_file(file, half / fs::relative(file, view.folder(), error));
    if (!ok) break;
  }
  if (ok && !is_there(done)) {
    fs::rename(half, done, error);
    if (!is_there(done)) ok = done_or(error, "write", done);
  }
  fs::remove_all(half, error);
  if (!ok) return forward(ok);
  return bytes;
}

}  // namespace floatstage::pipeline
