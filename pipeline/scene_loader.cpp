#include "pipeline/scene_loader.h"

#include <algorithm>
#include <optional>
#include <span>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

// Nothing for a camera without a matte.
Result<Matte> load_matte(const capture::TakeReader& take, std::size_t camera,
                         const std::filesystem::path& file, bool decode, std::string& hash) {
  const RigCamera& of = take.rig().cameras[camera];
  const Result<std::string> bytes = read_file(file);
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return Matte();
  if (!bytes) return forward(bytes);
  hash = capture::sha256(*bytes);
  if (!decode) return Matte();
  const Result<Image> alpha = decode_png(std::as_bytes(std::span(*bytes)), file.string());
  if (!alpha) return forward(alpha);
  if (alpha->channels != 1 || alpha->width != of.model.width || alpha->height != of.model.height)
    return fail(ErrorCode::BadData,
                text(file.string(), " is not a grey picture of ", of.model.width, "x", of.model.height,
                     " like camera '", of.serial, "'; remove it and run `floatstage process` again"));
  FrameInfo source;
  source.camera = static_cast<int>(camera);
  return make_matte(source, *alpha);
}

// Of several files, which add up; nothing where one is missing. Its hash is that of theirs, one after the
// other (mesh_record.h has the same).
Result<Matte> load_sum(const capture::TakeReader& take, std::size_t camera,
                       const std::vector<std::filesystem::path>& files, bool decode, std::string& hash) {
  std::optional<Image> sum;
  std::vector<std::string> hashes;
  Matte first;
  for (const std::filesystem::path& file : files) {
    std::string one;
    Result<Matte> matte = load_matte(take, camera, file, decode, one);
    if (!matte) return matte;
    if (one.empty()) return Matte();
    hashes.push_back(std::move(one));
    if (matte->empty()) continue;
    if (!sum) {
      first = *matte;
      sum = to_image(*matte);
      continue;
    }
    const Image more = to_image(*matte);
    for (std::size_t p = 0; p < sum->pixels.size(); ++p)
      sum->pixels[p] = static_cast<std::uint8_t>(std::min(255, sum->pixels[p] + more.pixels[p]));
  }
  hash = hash_of_parts(hashes);
  return sum && files.size() > 1 ? make_matte(first.source, *sum) : first;
}

// What makes the meshes of these labels.
std::string process_command(const TakeLayout& layout) {
  std::string command = "floatstage process " + layout.folder().string();
  for (const std::string& label : layout.labels())
    command += (&label == &layout.labels().front() ? " --label " : ",") + label;
  return command;
}

}  // namespace

Result<std::vector<Matte>> load_sums(const capture::TakeReader& take, int frame) {
  std::vector<Result<Matte>> read(take.rig().cameras.size(), Matte());
  parallel_for(read.size(), 0, [&](std::size_t i) {
    std::string hash;
    read[i] = load_matte(take, i, take.layout().matte(take.rig().cameras[i].serial, frame), true, hash);
  });
  std::vector<Matte> mattes;
  for (Result<Matte>& one : read) {
    if (!one) return forward(one);
    mattes.push_back(std::move(*one));
  }
  return mattes;
}

Result<std::vector<Matte>> load_mattes(const capture::TakeReader& take, int frame, MatteHashes* hashes,
                                       const std::vector<bool>& cameras) {
  const Rig& rig = take.rig();
  std::vector<Result<Matte>> read(rig.cameras.size(), Matte());
  std::vector<std::string> read_hashes(read.size());
  parallel_for(read.size(), 0, [&](std::size_t i) {
    const std::vector<std::filesystem::path> files = take.layout().matte_files(rig.cameras[i].serial, frame);
    read[i] = load_sum(take, i, files, cameras.empty() || cameras[i], read_hashes[i]);
  });
  std::vector<Matte> mattes;
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (!read[i]) return forward(read[i]);
    mattes.push_back(std::move(*read[i]));
    if (hashes && !read_hashes[i].empty()) (*hashes)[rig.cameras[i].serial] = std::move(read_hashes[i]);
  }
  return mattes;
}

template <class Record, class Load>
Result<std::shared_ptr<const Record>> SceneLoader::record(Kept<Record>& kept,
                                                          const std::filesystem::path& file,
                                                          const std::filesystem::path& journal,
                                                          const Load& load) {
  const std::lock_guard lock(mutex_);
  // Before it is read: what is written meanwhile has another mark the next time.
  const FileMark file_mark = mark_of(file), journal_mark = mark_of(journal);
  if (kept.record && kept.file == file_mark && kept.journal == journal_mark) return kept.record;
  Result<Record> read = load(take_.layout());
  if (!read) return forward(read);
  kept = {file_mark, journal_mark, std::make_shared<const Record>(std::move(*read))};
  return kept.record;
}

// Of no plate or photographs: they tell what is subject, but the cast is the cloth's, which the key names.
Result<std::shared_ptr<const matting::Keyer>> SceneLoader::keyer(std::size_t camera, const std::string& key) {
  KeptKeyer& kept = keyers_[camera];
  const std::lock_guard lock(kept.making);
  if (kept.keyer && kept.key == key) return kept.keyer;
  Result<std::unique_ptr<matting::Keyer>> made = matting::make_keyer(key, {});
  if (!made)
    return fail(made.error().code,
                text("camera '", take_.rig().cameras[camera].serial, "': ", made.error().message));
  kept.key = key;
  kept.keyer = std::move(*made);
  return kept.keyer;
}

Result<void> SceneLoader::take_spill_off(FrameSet& images) {
  const TakeLayout& layout = take_.layout();
  const auto made = record(mattes_, layout.made_mattes(), layout.mattes_journal(), load_matte_record);
  if (!made) return forward(made);
  std::vector<Result<void>> cleaned(images.frames.size());
  parallel_for(cleaned.size(), 0, [&](std::size_t i) {
    Frame& frame = images.frames[i];
    const auto camera = (*made)->find(take_.rig().cameras[i].serial);
    if (frame.empty() || camera == (*made)->end() || !camera->second.key.starts_with("chroma:")) return;
    const auto backing = keyer(i, camera->second.key);
    const Result<Image> clean = backing ? (*backing)->suppress_spill(frame) : Result<Image>(forward(backing));
    if (clean)
      frame = make_frame(frame.info, *clean);
    else
      cleaned[i] = forward(clean);
  });
  for (const Result<void>& ok : cleaned)
    if (!ok) return ok;
  return {};
}

// No picture is older than its silhouettes.
Result<void> SceneLoader::check_age(int frame, const MatteHashes& mattes) {
  const TakeLayout& layout = take_.layout();
  const auto meshes = record(meshes_, layout.hull_report(), layout.meshes_journal(), load_mesh_record);
  if (!meshes) return forward(meshes);
  const auto entry = (*meshes)->meshes.find(frame);
  if (entry == (*meshes)->meshes.end()) return {};
  const std::optional<std::string> newer = newer_matte(entry->second, mattes);
  if (!newer) return {};
  const std::string folder = layout.folder().string();
  return fail(ErrorCode::NotFound,
              text("the mesh of frame ", frame, " of ", folder, " is older than the matte of camera '",
                   *newer, "'; run `", process_command(layout), "`"));
}

// Of `cameras`; of all, and `cameras` says so, when not every camera has one.
Result<FrameSet> SceneLoader::photographs(int frame, std::vector<bool>& cameras) {
  const auto here = static_cast<std::size_t>(frame);
  for (std::size_t i = 0; i < take_.rig().cameras.size() && !cameras.empty(); ++i) {
    const std::vector<FrameRow>& rows = take_.rows(static_cast<int>(i));
    if (here >= rows.size() || !rows[here].media_index) cameras.clear();
  }
  if (cameras.empty()) return take_.frame_set(frame);
  FrameSet set;
  set.frames.resize(cameras.size());
  std::vector<Result<void>> read(cameras.size());
  parallel_for(cameras.size(), 0, [&](std::size_t i) {
    if (!cameras[i]) return;
    Result<Frame> photograph = take_.frame(static_cast<int>(i), frame);
    if (photograph)
      set.frames[i] = std::move(*photograph);
    else
      read[i] = forward(photograph);
  });
  bool missing = false;
  std::optional<Timestamp> earliest;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!read[i]) return forward(read[i]);
    if (!cameras[i]) continue;
    const Timestamp exposed = set.frames[i].info.exposure_start;
    missing |= set.frames[i].empty();
    earliest = earliest ? std::min(*earliest, exposed) : exposed;
  }
  if (missing || !earliest) {
    cameras.clear();
    return take_.frame_set(frame);
  }
  set.time = *earliest;
  return set;
}

Result<SceneFrame> SceneLoader::load(int frame, const Choose& choose, bool* chosen) {
  SceneFrame scene;
  Result<Mesh> mesh = load_ply(take_.layout().mesh(frame));
  const std::string folder = take_.layout().folder().string();
  if (!mesh && mesh.error().code == ErrorCode::NotFound)
    return fail(ErrorCode::NotFound, text("frame ", frame, " of ", folder, " has no mesh yet; run `",
                                          process_command(take_.layout()), "`"));
  if (!mesh) return forward(mesh);
  scene.mesh = std::move(*mesh);
  std::vector<bool> cameras = choose && !scene.mesh.empty() ? choose(scene.mesh) : std::vector<bool>();
  Result<FrameSet> images = photographs(frame, cameras);
  if (!images) return forward(images);
  scene.images = std::move(*images);
  MatteHashes hashes;
  Result<std::vector<Matte>> mattes = load_mattes(take_, frame, &hashes, cameras);
  if (!mattes) return forward(mattes);
  if (Result<void> ok = check_age(frame, hashes); !ok) return forward(ok);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (cameras[i] && (*mattes)[i].empty()) return load(frame, {}, chosen);
  if (chosen) *chosen = !cameras.empty();
  scene.mattes = std::move(*mattes);
  if (suppress_spill_)
    if (Result<void> ok = take_spill_off(scene.images); !ok) return forward(ok);
  return scene;
}

Result<Rig> rig_with_colors(const capture::TakeReader& take) {
  const std::filesystem::path file = take.layout().colors();
  Rig rig = take.rig();
  if (!is_there(file)) return rig;
  const Result<Rig> colors = load_rig(file);
  if (!colors) return forward(colors);
  for (RigCamera& camera : rig.cameras) {
    const int index = camera_index(*colors, camera.serial);
    if (index < 0)
      return fail(ErrorCode::BadData,
                  text(file.string(), ": camera '", camera.serial,
                       "' is not in it; run `floatstage calibrate color` on the take again, or remove it"));
    camera.color = colors->cameras[static_cast<std::size_t>(index)].color;
  }
  return rig;
}

}  // namespace floatstage::pipeline
