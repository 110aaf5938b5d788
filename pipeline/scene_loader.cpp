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

constexpr int kShared = 2;  // px about a part whose pixels' colours are made of their neighbours', too

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

// Where there is none all of a photograph is opaque.
Image part_of(const Matte& matte, const PixelBox& box) {
  Image alpha(box.width, box.height, 1, 255);
  if (matte.empty()) return alpha;
  for (int y = 0; y < box.height; ++y) std::copy_n(matte.row(box.y + y) + box.x, box.width, alpha.at(0, y));
  return alpha;
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

// Null where the cloth's cast stays.
Result<std::shared_ptr<const MatteRecord>> SceneLoader::spill() {
  if (!suppress_spill_) return std::shared_ptr<const MatteRecord>();
  const TakeLayout& layout = take_.layout();
  return record(mattes_, layout.made_mattes(), layout.mattes_journal(), load_matte_record);
}

bool SceneLoader::has_spill(const std::shared_ptr<const MatteRecord>& made, std::size_t camera) const {
  if (!made) return false;
  const auto entry = made->find(take_.rig().cameras[camera].serial);
  return entry != made->end() && entry->second.key.starts_with("chroma:");
}

Result<Image> SceneLoader::clean(const MatteRecord& made, std::size_t camera, const Frame& frame) {
  const auto backing = keyer(camera, made.find(take_.rig().cameras[camera].serial)->second.key);
  return backing ? (*backing)->suppress_spill(frame) : Result<Image>(forward(backing));
}

Result<void> SceneLoader::take_spill_off(FrameSet& images) {
  const Result<std::shared_ptr<const MatteRecord>> made = spill();
  if (!made) return forward(made);
  std::vector<Result<void>> cleaned(images.frames.size());
  parallel_for(cleaned.size(), 0, [&](std::size_t i) {
    Frame& frame = images.frames[i];
    if (frame.empty() || !has_spill(*made, i)) return;
    const Result<Image> clear = clean(**made, i, frame);
    if (clear)
      frame = make_frame(frame.info, *clear);
    else
      cleaned[i] = forward(clear);
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

Result<Mesh> SceneLoader::mesh(int frame) const {
  Result<Mesh> mesh = load_ply(take_.layout().mesh(frame));
  if (!mesh && mesh.error().code == ErrorCode::NotFound)
    return fail(ErrorCode::NotFound, text("frame ", frame, " of ", take_.layout().folder().string(),
                                          " has no mesh yet; run `", process_command(take_.layout()), "`"));
  return mesh;
}

Result<SceneFrame> SceneLoader::load(int frame) {
  Result<Mesh> mesh = this->mesh(frame);
  if (!mesh) return forward(mesh);
  Result<FrameSet> images = take_.frame_set(frame);
  if (!images) return forward(images);
  MatteHashes hashes;
  Result<std::vector<Matte>> mattes = load_mattes(take_, frame, &hashes);
  if (!mattes) return forward(mattes);
  if (Result<void> ok = check_age(frame, hashes); !ok) return forward(ok);
  if (Result<void> ok = take_spill_off(*images); !ok) return forward(ok);
  return SceneFrame{std::move(*images), std::move(*mattes), std::move(*mesh)};
}

bool SceneLoader::all_have_pictures(int frame) const {
  const auto here = static_cast<std::size_t>(frame);
  for (std::size_t i = 0; i < take_.rig().cameras.size(); ++i) {
    const std::vector<FrameRow>& rows = take_.rows(static_cast<int>(i));
    if (here >= rows.size() || !rows[here].media_index) return false;
  }
  return true;
}

// Without its matte, and without a picture where that is damaged.
Result<PhotographPart> SceneLoader::part(int frame, std::size_t camera, std::vector<PixelBox> boxes,
                                         const std::shared_ptr<const MatteRecord>& made) {
  const PixelFormat format = take_.manifest().cameras[camera].format;
  if (format != PixelFormat::Gray8 && format != PixelFormat::Rgb8)
    for (PixelBox& box : boxes)
      box = {box.x - kShared, box.y - kShared, box.width + 2 * kShared, box.height + 2 * kShared};
  PhotographPart part;
  part.camera = static_cast<int>(camera);
  const Result<Frame> pixels = take_.part(part.camera, frame, boxes, part.box);
  if (!pixels) return forward(pixels);
  if (pixels->empty()) return part;
  Result<Image> photograph = has_spill(made, camera) ? clean(*made, camera, *pixels) : to_rgb(*pixels);
  if (!photograph) return forward(photograph);
  part.photograph = std::move(*photograph);
  return part;
}

Result<DrawnScene> SceneLoader::load_parts(int frame, const Choose& choose) {
  const auto whole = [&]() -> Result<DrawnScene> {
    Result<SceneFrame> scene = load(frame);
    if (!scene) return forward(scene);
    return DrawnScene(std::move(*scene));
  };
  Result<Mesh> mesh = this->mesh(frame);
  if (!mesh) return forward(mesh);
  if (mesh->empty() || !all_have_pictures(frame)) return whole();
  const std::vector<std::vector<PixelBox>> boxes = choose(*mesh);
  std::vector<bool> cameras;
  for (const std::vector<PixelBox>& of_one : boxes) cameras.push_back(!of_one.empty());
  MatteHashes hashes;
  const Result<std::vector<Matte>> mattes = load_mattes(take_, frame, &hashes, cameras);
  if (!mattes) return forward(mattes);
  if (Result<void> ok = check_age(frame, hashes); !ok) return forward(ok);
  const Result<std::shared_ptr<const MatteRecord>> made = spill();
  if (!made) return forward(made);
  std::vector<Result<PhotographPart>> read(boxes.size(), PhotographPart());
  parallel_for(boxes.size(), 0, [&](std::size_t i) {
    if (cameras[i]) read[i] = part(frame, i, boxes[i], *made);
  });
  SceneParts parts;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!cameras[i]) continue;
    if (!read[i]) return forward(read[i]);
    if (read[i]->photograph.empty()) return whole();
    read[i]->matte = part_of((*mattes)[i], read[i]->box);
    parts.photographs.push_back(std::move(*read[i]));
  }
  parts.mesh = std::move(*mesh);
  return DrawnScene(std::move(parts));
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
