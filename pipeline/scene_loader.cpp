#include "pipeline/scene_loader.h"

#include <span>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/keying.h"
#include "pipeline/matte_record.h"

namespace floatstage::pipeline {
namespace {

Result<void> take_spill_off(capture::TakeReader& take, FrameSet& images) {
  const Result<MatteRecord> record = load_matte_record(take.layout());
  if (!record) return forward(record);
  for (std::size_t i = 0; i < images.frames.size(); ++i) {
    Frame& frame = images.frames[i];
    const auto made = record->find(take.rig().cameras[i].serial);
    if (frame.empty() || made == record->end() || !made->second.key.starts_with("chroma:")) continue;
    Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, static_cast<int>(i), made->second.key);
    if (!keyer) return forward(keyer);
    Result<Image> clean = (*keyer)->suppress_spill(frame);
    if (!clean) return forward(clean);
    frame = make_frame(frame.info, *clean);
  }
  return {};
}

// No picture is older than its silhouettes.
Result<void> check_age(const capture::TakeReader& take, int frame, const MatteHashes& mattes) {
  const Result<MeshRecord> record = load_mesh_record(take.layout());
  if (!record) return forward(record);
  const auto entry = record->meshes.find(frame);
  if (entry == record->meshes.end()) return {};
  const std::optional<std::string> newer = newer_matte(entry->second, mattes);
  if (!newer) return {};
  return fail(ErrorCode::NotFound, text("the mesh of frame ", frame, " of ", take.layout().folder().string(),
                                        " is older than the matte of camera '", *newer,
                                        "'; run `floatstage process ", take.layout().folder().string(), "`"));
}

}  // namespace

Result<std::vector<Matte>> load_mattes(const capture::TakeReader& take, int frame, MatteHashes* hashes) {
  const Rig& rig = take.rig();
  std::vector<Matte> mattes(rig.cameras.size());
  for (std::size_t i = 0; i < mattes.size(); ++i) {
    const std::filesystem::path file = take.layout().matte(rig.cameras[i].serial, frame);
    const Result<std::string> bytes = read_file(file);
    if (!bytes && bytes.error().code == ErrorCode::NotFound) continue;
    if (!bytes) return forward(bytes);
    if (hashes) (*hashes)[rig.cameras[i].serial] = capture::sha256(*bytes);
    Result<Image> alpha = decode_png(std::as_bytes(std::span(*bytes)), file.string());
    if (!alpha) return forward(alpha);
    const CameraModel& model = rig.cameras[i].model;
    if (alpha->channels != 1 || alpha->width != model.width || alpha->height != model.height)
      return fail(ErrorCode::BadData, text(file.string(), " is not a grey picture of ", model.width, "x",
                                           model.height, " like camera '", rig.cameras[i].serial,
                                           "'; remove it and run `floatstage process` again"));
    FrameInfo source;
    source.camera = static_cast<int>(i);
    mattes[i] = make_matte(source, *alpha);
  }
  return mattes;
}

Result<SceneFrame> load_scene(capture::TakeReader& take, int frame, bool suppress_spill) {
  SceneFrame scene;
  Result<Mesh> mesh = load_ply(take.layout().mesh(frame));
  if (!mesh && mesh.error().code == ErrorCode::NotFound)
    return fail(ErrorCode::NotFound,
                text("frame ", frame, " of ", take.layout().folder().string(),
                     " has no mesh yet; run `floatstage process ", take.layout().folder().string(), "`"));
  if (!mesh) return forward(mesh);
  scene.mesh = std::move(*mesh);
  Result<FrameSet> images = take.frame_set(frame);
  if (!images) return forward(images);
  scene.images = std::move(*images);
  MatteHashes hashes;
  Result<std::vector<Matte>> mattes = load_mattes(take, frame, &hashes);
  if (!mattes) return forward(mattes);
  if (Result<void> ok = check_age(take, frame, hashes); !ok) return forward(ok);
  scene.mattes = std::move(*mattes);
  if (suppress_spill)
    if (Result<void> ok = take_spill_off(take, scene.images); !ok) return forward(ok);
  return scene;
}

Result<Rig> rig_with_colors(const capture::TakeReader& take) {
  const std::filesystem::path file = take.layout().colors();
  Rig rig = take.rig();
  if (!std::filesystem::exists(file)) return rig;
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

Result<Eigen::AlignedBox3d> subject_box(const capture::TakeReader& take) {
  Eigen::AlignedBox3d box;
  for (int frame = 0; frame < take.frame_count(); ++frame) {
    if (!std::filesystem::exists(take.layout().mesh(frame))) continue;
    Result<Mesh> mesh = load_ply(take.layout().mesh(frame));
    if (!mesh) return forward(mesh);
    if (!mesh->empty()) box.extend(bounding_box(*mesh).cast<double>());
  }
  if (box.isEmpty())
    return fail(ErrorCode::NotFound,
                text(take.layout().folder().string(), " has no mesh with a subject; run `floatstage process ",
                     take.layout().folder().string(), "` and look at its mattes"));
  return box;
}

}  // namespace floatstage::pipeline
