#include "render/scene.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "core/text.h"
#include "render/scene_impl.h"

namespace floatstage::render {
namespace {

Result<void> check_mesh(const Mesh& mesh) {
  if (mesh.triangles.size() % 3 != 0)
    return fail(ErrorCode::BadData,
                text("the mesh has ", mesh.triangles.size(), " indices, not three a triangle"));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    if (!mesh.positions[i].allFinite())
      return fail(ErrorCode::BadData,
                  text("vertex ", i, " of the mesh is not a finite point; rebuild the mesh"));
  for (std::uint32_t index : mesh.triangles)
    if (index >= mesh.positions.size())
      return fail(ErrorCode::BadData,
                  text("the mesh refers to vertex ", index, " but has ", mesh.positions.size()));
  return {};
}

/// RGB pixels and their opacity (null: opaque) as a tile, colours brought to the rig's.
template <class AlphaRow>
void make_tile(const RigCamera& camera, const Image& rgb, AlphaRow alpha_row, SceneTile& tile) {
  tile.resize(rgb.width, rgb.height);
  const bool same_colors = camera.color.is_identity();
  const std::optional<ColorTable> table =
      same_colors ? std::nullopt : std::optional<ColorTable>(camera.color);
  for (int y = 0; y < rgb.height; ++y) {
    const std::uint8_t *from = rgb.at(0, y), *alpha = alpha_row(y);
    std::uint8_t* to = tile.at(0, y);
    if (same_colors)
      for (int x = 0; x < rgb.width; ++x) {
        to[4 * x] = from[3 * x];
        to[4 * x + 1] = from[3 * x + 1];
        to[4 * x + 2] = from[3 * x + 2];
      }
    else
      for (int x = 0; x < rgb.width; ++x) table->apply(from + 3 * x, to + 4 * x);
    for (int x = 0; x < rgb.width; ++x) to[4 * x + 3] = alpha != nullptr ? alpha[x] : 255;
  }
  tile.repeat_border();
}

/// The photograph with its matte in alpha (opaque without one).
Result<void> make_tile(const RigCamera& camera, const Frame& frame, const Matte* matte, SceneTile& tile) {
  Result<Image> rgb = to_rgb(frame);
  if (!rgb) return fail(rgb.error().code, text("camera '", camera.serial, "': ", rgb.error().message));
  const Image& in = *rgb;
  if (in.width != camera.model.width || in.height != camera.model.height)
    return fail(ErrorCode::BadData, text("camera '", camera.serial, "': the picture is ", in.width, "x",
                                         in.height, " but the rig says ", camera.model.width, "x",
                                         camera.model.height, "; calibrate at the recorded size"));
  if (matte != nullptr && (matte->width != in.width || matte->height != in.height))
    return fail(ErrorCode::BadData, text("camera '", camera.serial, "': the matte is ", matte->width, "x",
                                         matte->height, " but the picture is ", in.width, "x", in.height));
  make_tile(
      camera, in, [&](int y) { return matte != nullptr ? matte->row(y) : nullptr; }, tile);
  return {};
}

/// The cameras that have a picture and may be used.
Result<std::vector<int>> cameras_in_use(const Rig& rig, const SceneFrame& scene,
                                        const std::vector<bool>& usable) {
  const std::size_t count = rig.cameras.size();
  if (scene.images.frames.size() != count)
    return fail(ErrorCode::InvalidArgument, text("the rig has ", count, " cameras but the scene has ",
                                                 scene.images.frames.size(), " pictures"));
  if (!scene.mattes.empty() && scene.mattes.size() != count)
    return fail(ErrorCode::InvalidArgument,
                text("the rig has ", count, " cameras but the scene has ", scene.mattes.size(), " mattes"));
  if (!usable.empty() && usable.size() != count)
    return fail(ErrorCode::InvalidArgument,
                text("the rig has ", count, " cameras but ", usable.size(), " are said to be usable or not"));
  std::vector<int> used;
  for (std::size_t i = 0; i < count; ++i)
    if (!scene.images.frames[i].empty() && (usable.empty() || usable[i])) used.push_back(static_cast<int>(i));
  if (used.empty())
    return fail(ErrorCode::InvalidArgument,
                "no camera with a picture is left to draw from; keep at least one");
  return used;
}

Result<void> check_tiles(const Rig& rig, std::span<const PictureTile> tiles) {
  if (tiles.empty())
    return fail(ErrorCode::InvalidArgument,
                "no camera with a picture is left to draw from; keep at least one");
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const PictureTile& tile = tiles[i];
    const auto same = [&](const PictureTile& other) { return other.camera == tile.camera; };
    const auto before = tiles.first(i);
    if (tile.camera < 0 || tile.camera >= static_cast<int>(rig.cameras.size()) ||
        std::any_of(before.begin(), before.end(), same))
      return fail(ErrorCode::InvalidArgument,
                  text("a tile of camera ", tile.camera, ", which is not in the rig of ", rig.cameras.size(),
                       " cameras or has one already"));
    const RigCamera& camera = rig.cameras[static_cast<std::size_t>(tile.camera)];
    const Image *picture = tile.picture, *matte = tile.matte;
    const bool whole = picture != nullptr && matte != nullptr && !picture->empty() &&
                       picture->channels == 3 && matte->channels == 1 && picture->width == matte->width &&
                       picture->height == matte->height;
    if (!whole || tile.x < 0 || tile.y < 0 || tile.x + picture->width > camera.model.width ||
        tile.y + picture->height > camera.model.height)
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", camera.serial, "': its tile is no part of a ", camera.model.width, "x",
                       camera.model.height, " photograph with a matte of the same size"));
  }
  return {};
}

}  // namespace

void SceneTile::resize(int w, int h) {
  width = w;
  height = h;
  rgba.resize(4 * static_cast<std::size_t>(stride()) * static_cast<std::size_t>(h + 2 * kApron));
}

void SceneTile::repeat_border() {
  for (int y = 0; y < height; ++y)
    for (int a = 1; a <= kApron; ++a) {
      std::copy_n(at(0, y), 4, at(-a, y));
      std::copy_n(at(width - 1, y), 4, at(width - 1 + a, y));
    }
  const int row = 4 * stride();
  for (int a = 1; a <= kApron; ++a) {
    std::copy_n(at(-kApron, 0), row, at(-kApron, -a));
    std::copy_n(at(-kApron, height - 1), row, at(-kApron, height - 1 + a));
  }
}

Scene::Scene() : impl_(std::make_unique<Impl>()) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Result<void> Scene::set(const Rig& rig, const SceneFrame& scene, const std::vector<bool>& usable) {
  if (Result<void> ok = check(rig); !ok) return ok;
  if (Result<void> ok = check_mesh(scene.mesh); !ok) return ok;
  Result<std::vector<int>> used = cameras_in_use(rig, scene, usable);
  if (!used) return forward(used);

  // Everything that can fail is done before anything of the old scene is replaced.
  std::vector<SceneTile> tiles(used->size());
  std::vector<Result<void>> made(used->size(), Result<void>());
  parallel_for(used->size(), 0, [&](std::size_t i) {
    const auto camera = static_cast<std::size_t>((*used)[i]);
    const Matte* matte =
        scene.mattes.empty() || scene.mattes[camera].empty() ? nullptr : &scene.mattes[camera];
    made[i] = make_tile(rig.cameras[camera], scene.images.frames[camera], matte, tiles[i]);
  });
  for (const Result<void>& ok : made)
    if (!ok) return ok;

  Impl& s = *impl_;
  s.begin(used->size(), scene.mesh);
  s.tiles = std::move(tiles);
  for (int camera : *used) s.add(rig.cameras[static_cast<std::size_t>(camera)], camera);
  s.ranked = s.cameras;
  s.slot.resize(s.ranked.size());
  std::iota(s.slot.begin(), s.slot.end(), 0);
  s.finish();
  return {};
}

Result<void> Scene::set(const Rig& rig, const Mesh& mesh, std::span<const PictureTile> tiles) {
  if (Result<void> ok = check(rig); !ok) return ok;
  if (Result<void> ok = check_mesh(mesh); !ok) return ok;
  if (Result<void> ok = check_tiles(rig, tiles); !ok) return ok;
  Impl& s = *impl_;
  s.begin(tiles.size(), mesh);
  s.ranked = rig.cameras;
  s.slot.assign(rig.cameras.size(), -1);
  s.tiles.resize(std::max(s.tiles.size(), tiles.size()));
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const PictureTile& tile = tiles[i];
    const auto camera = static_cast<std::size_t>(tile.camera);
    s.slot[camera] = static_cast<int>(i);
    s.add(rig.cameras[camera], tile.camera);
    s.blocks.back().tile = {static_cast<float>(tile.x), static_cast<float>(tile.y),
                            static_cast<float>(tile.picture->width),
                            static_cast<float>(tile.picture->height)};
  }
  parallel_for(tiles.size(), 0, [&](std::size_t i) {
    const Image& matte = *tiles[i].matte;
    make_tile(
        s.cameras[i], *tiles[i].picture, [&](int y) { return matte.at(0, y); }, s.tiles[i]);
  });
  s.finish();
  return {};
}

void Scene::set_fields(std::shared_ptr<const FieldSet> fields) {
  impl_->given_fields = std::move(fields);
  impl_->fields.clear();
}

CameraChoice Scene::Impl::choose(const View& view, int count) const {
  CameraChoice choice = choose_cameras(ranking, view, count, pictured);
  for (int& camera : choice.listed) camera = slot[static_cast<std::size_t>(camera)];
  return choice;
}

void Scene::Impl::begin(std::size_t count, const Mesh& source) {
  cameras.resize(count);
  rig_index.clear();
  given_fields.reset();
  fields.clear();
  blocks.clear();
  mesh.positions.assign(source.positions.begin(), source.positions.end());
  mesh.triangles.assign(source.triangles.begin(), source.triangles.end());
  vertex_blocks.set(mesh.positions);
  box = source.empty() ? Eigen::AlignedBox3f(Eigen::Vector3f::Zero()) : vertex_blocks.box;
}

void Scene::Impl::add(const RigCamera& camera, int index) {
  const std::size_t place = rig_index.size();
  rig_index.push_back(index);
  blocks.push_back(camera_block(camera, static_cast<int>(place)));
  cameras[place] = camera;
}

void Scene::Impl::finish() {
  depth_windows.resize(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    depth_windows[i] = depth_window(cameras[i], box);
    blocks[i].depth = depth_windows[i].place;
  }
  pictured.resize(ranked.size());
  for (std::size_t i = 0; i < ranked.size(); ++i) pictured[i] = slot[i] >= 0;
  ranking.set(ranked, ranking_samples(mesh));
  ++version;
}

}  // namespace floatstage::render
