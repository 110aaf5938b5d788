#include "pipeline/take_fields.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "core/file.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/field_file.h"
#include "pipeline/scene_loader.h"
#include "render/renderer.h"

namespace floatstage::pipeline {
namespace {

// Why a file's fields to a neighbour are not those of this scene; null: they are.
const char* unlike(const FieldFile& file, const FieldFile::Neighbor& neighbor,
                   const render::FieldInputs& inputs, int from, int to) {
  if (file.mesh != inputs.mesh) return "another mesh";
  const auto is = [&](int camera, const std::string& hash) {
    const auto found = inputs.cameras.find(camera);
    return found != inputs.cameras.end() && found->second == hash;
  };
  return is(from, file.camera) && is(to, neighbor.made_from) ? nullptr
                                                             : "other photographs, mattes or colours";
}

// All files of an instant are of one set: that of the first that fits.
void add(const FieldFile& file, int from, const Rig& rig, const render::FieldInputs& inputs,
         render::FieldSet& set, const char*& reason) {
  if (set.fields.empty()) set.flow = file.flow;
  if (!render::same_fields(set.flow, file.flow)) return;
  for (const FieldFile::Neighbor& neighbor : file.neighbors) {
    const int to = camera_index(rig, neighbor.serial);
    // A scene of some of the photographs alone has no use for the others' fields.
    if (to < 0 || to == from || !inputs.cameras.contains(from) || !inputs.cameras.contains(to)) continue;
    if (const char* other = unlike(file, neighbor, inputs, from, to); other != nullptr) {
      reason = other;
      continue;
    }
    auto field = std::make_shared<render::CameraField>();
    field->place = file.place;
    field->width = file.width;
    field->height = file.height;
    field->uv = neighbor.uv;
    set.fields[{from, to}] = std::move(field);
  }
}

FieldFile file_of(const Rig& rig, const render::FieldInputs& inputs, const render::FieldSet& set, int from) {
  FieldFile file;
  file.flow = set.flow;
  file.mesh = inputs.mesh;
  file.camera = inputs.cameras.at(from);
  for (const auto& [pair, field] : set.fields) {
    if (pair.from != from) continue;
    file.place = field->place;
    file.width = field->width;
    file.height = field->height;
    file.neighbors.push_back(
        {rig.cameras[static_cast<std::size_t>(pair.to)].serial, inputs.cameras.at(pair.to), field->uv});
  }
  return file;
}

// Whether the file is what would be made now.
bool is_current(const std::filesystem::path& name, const Rig& rig, const render::FieldInputs& inputs,
                int from, const std::vector<render::CameraPair>& pairs, const render::FlowOptions& flow) {
  const Result<FieldFile> file = load_field_file(name);
  if (!file || !render::same_fields(file->flow, flow)) return false;
  std::vector<int> there;
  for (const FieldFile::Neighbor& n : file->neighbors) {
    const int to = camera_index(rig, n.serial);
    if (to < 0 || !inputs.cameras.contains(to) || unlike(*file, n, inputs, from, to) != nullptr) return false;
    there.push_back(to);
  }
  return std::all_of(pairs.begin(), pairs.end(), [&](const render::CameraPair& pair) {
    return std::find(there.begin(), there.end(), pair.to) != there.end();
  });
}

class Maker {
 public:
  Maker(capture::TakeReader& take, const FieldOptions& options, Rig rig)
      : take_(take), options_(options), rig_(std::move(rig)), loader_(take, true) {}

  Result<FieldReport> run() {
    const std::size_t cameras = rig_.cameras.size();
    ProgressPart progress(options_.progress, "fields", options_.frames.size() * cameras);
    for (const int frame : options_.frames)
      if (Result<void> ok = instant(frame, progress); !ok) {
        if (ok.error().code == ErrorCode::Cancelled || ok.error().code == ErrorCode::Io) return forward(ok);
        report_.failures.push_back(text("frame ", frame, ": ", ok.error().message));
      }
    return report_;
  }

 private:
  Result<void> instant(int frame, ProgressPart& progress) {
    const Result<SceneFrame> scene = loader_.load(frame);
    if (!scene) return forward(scene);
    if (scene->mesh.empty()) return {};  // nobody on stage
    if (Result<void> ok = drawn_.set(rig_, *scene); !ok) return ok;
    const render::FieldInputs inputs = render::field_inputs(drawn_);
    std::vector<bool> usable(rig_.cameras.size());
    for (const auto& [camera, hash] : inputs.cameras) usable[static_cast<std::size_t>(camera)] = true;
    std::map<int, std::vector<render::CameraPair>> wanted;
    for (const render::CameraPair& pair : render::field_pairs(rig_, scene->mesh, options_.neighbors, usable))
      wanted[pair.from].push_back(pair);
    for (const auto& [from, pairs] : wanted) {
      if (is_cancelled(options_.progress)) return cancelled();
      if (Result<void> ok = camera(frame, from, pairs, inputs); !ok) return ok;
      progress.advance();
    }
    return {};
  }

  Result<void> camera(int frame, int from, const std::vector<render::CameraPair>& pairs,
                      const render::FieldInputs& inputs) {
    const std::filesystem::path file =
        field_path(take_.layout(), rig_.cameras[static_cast<std::size_t>(from)].serial, frame);
    if (!options_.redo && is_current(file, rig_, inputs, from, pairs, options_.flow)) {
      ++report_.kept;
      return {};
    }
    render::RendererOptions how;
    how.flow = options_.flow;
    how.threads = options_.threads;
    how.given_up = [this] { return is_cancelled(options_.progress); };
    const Result<render::FieldSet> set = render::estimate_fields(drawn_, pairs, how);
    if (!set) return is_cancelled(options_.progress) ? Result<void>(cancelled()) : forward(set);
    if (Result<void> ok = save_field_file(file_of(rig_, inputs, *set, from), file); !ok) return ok;
    ++report_.made;
    return {};
  }

  capture::TakeReader& take_;
  const FieldOptions& options_;
  const Rig rig_;
  SceneLoader loader_;
  render::Scene drawn_;
  FieldReport report_;
};

}  // namespace

std::filesystem::path field_folder(const TakeLayout& layout) { return layout.folder() / "fields"; }

std::filesystem::path field_path(const TakeLayout& layout, const std::string& serial, int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "%06d.fields", frame);
  return field_folder(layout) / serial / name;
}

Result<std::shared_ptr<const render::FieldSet>> load_fields(const TakeLayout& layout, const Rig& rig,
                                                            int frame, const render::Scene& scene,
                                                            std::optional<std::string>* stale) {
  std::shared_ptr<const render::FieldSet> none;
  std::error_code error;
  if (!std::filesystem::is_directory(field_folder(layout), error)) return none;
  auto set = std::make_shared<render::FieldSet>();
  std::optional<render::FieldInputs> inputs;  // costs a look at all photographs
  const char* reason = nullptr;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const Result<FieldFile> file = load_field_file(field_path(layout, rig.cameras[i].serial, frame));
    if (!file && file.error().code == ErrorCode::NotFound) continue;
    if (!file) return forward(file);
    if (!inputs) inputs = render::field_inputs(scene);
    add(*file, static_cast<int>(i), rig, *inputs, *set, reason);
  }
  if (stale != nullptr && reason != nullptr)
    *stale = text("fields of frame ", frame, " in ", field_folder(layout).string(), " were made from ",
                  reason, "; they are estimated anew. `floatstage process ", layout.folder().string(),
                  " --fields` makes them again");
  if (set->fields.empty()) return none;
  return std::shared_ptr<const render::FieldSet>(std::move(set));
}

Result<void> give_fields(const TakeLayout& layout, const Rig& rig, int frame, render::Scene& scene) {
  std::optional<std::string> stale;
  Result<std::shared_ptr<const render::FieldSet>> fields = load_fields(layout, rig, frame, scene, &stale);
  if (!fields) return forward(fields);
  if (stale) log::warning(*stale);
  if (*fields) scene.set_fields(std::move(*fields));
  return {};
}

Result<FieldReport> make_fields(capture::TakeReader& take, const FieldOptions& options) {
  Result<Rig> rig = rig_with_colors(take);
  if (!rig) return forward(rig);
  for (const RigCamera& camera : rig->cameras) sweep_temporaries(field_folder(take.layout()) / camera.serial);
  return Maker(take, options, std::move(*rig)).run();
}

}  // namespace floatstage::pipeline
