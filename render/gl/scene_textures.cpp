#include "render/gl/scene_textures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "core/text.h"
#include "render/gl/scene_textures_impl.h"

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

/// RGB pixels and their opacity as RGBA, colours brought to the rig's.
void with_matte(const RigCamera& camera, const Image& rgb, const std::uint8_t* alpha,
                std::vector<std::uint8_t>& out) {
  const std::size_t pixels = rgb.pixels.size() / 3;
  out.resize(4 * pixels);
  const std::uint8_t* from = rgb.pixels.data();
  std::uint8_t* to = out.data();
  if (camera.color.is_identity()) {
    for (std::size_t i = 0; i < pixels; ++i, from += 3, to += 4) {
      std::copy_n(from, 3, to);
      to[3] = alpha[i];
    }
    return;
  }
  const ColorTable table(camera.color);
  for (std::size_t i = 0; i < pixels; ++i, from += 3, to += 4) {
    table.apply(from, to);
    to[3] = alpha[i];
  }
}

/// The photograph as RGBA with its matte in alpha (opaque without one), colours brought to the rig's.
Result<Image> with_matte(const RigCamera& camera, const Frame& frame, const Matte* matte) {
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
  // Without a matte everything is subject; one in rows with padding is copied together.
  std::vector<std::uint8_t> alpha(static_cast<std::size_t>(in.width) * static_cast<std::size_t>(in.height),
                                  255);
  for (int y = 0; matte != nullptr && y < in.height; ++y)
    std::copy_n(matte->row(y), in.width, alpha.begin() + static_cast<std::ptrdiff_t>(y) * in.width);
  Image out(in.width, in.height, 4);
  with_matte(camera, in, alpha.data(), out.pixels);
  return out;
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
  std::vector<bool> seen(rig.cameras.size());
  for (const PictureTile& tile : tiles) {
    if (tile.camera < 0 || tile.camera >= static_cast<int>(seen.size()) ||
        seen[static_cast<std::size_t>(tile.camera)])
      return fail(ErrorCode::InvalidArgument,
                  text("a tile of camera ", tile.camera, ", which is not in the rig of ", seen.size(),
                       " cameras or has one already"));
    seen[static_cast<std::size_t>(tile.camera)] = true;
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

Result<void> check_fit(int width, int height, std::size_t pictures) {
  GLint largest = 0, most_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (std::max(width, height) <= largest && static_cast<int>(pictures) <= most_layers) return {};
  return fail(ErrorCode::Unsupported,
              text(pictures, " pictures of up to ", width, "x", height, " do not fit this GPU's textures (",
                   largest, " px, ", most_layers, " layers)"));
}

}  // namespace

SceneTextures::SceneTextures() : impl_(std::make_unique<Impl>()) {}
SceneTextures::SceneTextures(SceneTextures&&) noexcept = default;
SceneTextures& SceneTextures::operator=(SceneTextures&&) noexcept = default;
SceneTextures::~SceneTextures() = default;

Result<void> SceneTextures::upload(const Rig& rig, const SceneFrame& scene, const std::vector<bool>& usable) {
  if (Result<void> ok = check(rig); !ok) return ok;
  if (Result<void> ok = check_mesh(scene.mesh); !ok) return ok;
  Result<std::vector<int>> used = cameras_in_use(rig, scene, usable);
  if (!used) return forward(used);

  // Everything that can fail is done before anything of the old scene is replaced.
  std::vector<Result<Image>> pictures(used->size(), Result<Image>(Image{}));
  parallel_for(used->size(), 0, [&](std::size_t i) {
    const auto camera = static_cast<std::size_t>((*used)[i]);
    const Matte* matte =
        scene.mattes.empty() || scene.mattes[camera].empty() ? nullptr : &scene.mattes[camera];
    pictures[i] = with_matte(rig.cameras[camera], scene.images.frames[camera], matte);
  });
  int width = 0, height = 0;
  for (const Result<Image>& picture : pictures) {
    if (!picture) return forward(picture);
    width = std::max(width, picture->width);
    height = std::max(height, picture->height);
  }
  if (Result<void> ok = check_fit(width, height, pictures.size()); !ok) return ok;

  Impl& s = *impl_;
  s.cameras.clear();
  s.rig_index = *used;
  std::vector<CameraBlock> blocks;
  s.photographs.resize(GL_RGBA8, GL_LINEAR, width, height, static_cast<int>(pictures.size()));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int layer = static_cast<int>(i);
    s.cameras.push_back(rig.cameras[static_cast<std::size_t>((*used)[i])]);
    blocks.push_back(camera_block(s.cameras.back(), layer));
    const Image& picture = *pictures[i];
    glTextureSubImage3D(s.photographs.id(), 0, 0, 0, layer, picture.width, picture.height, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, picture.pixels.data());
  }

  s.ranked = s.cameras;
  s.slot.resize(s.ranked.size());
  std::iota(s.slot.begin(), s.slot.end(), 0);
  s.put_mesh(scene.mesh);
  s.put_cameras(blocks);
  return {};
}

Result<void> SceneTextures::upload(const Rig& rig, const Mesh& mesh, std::span<const PictureTile> tiles) {
  if (Result<void> ok = check(rig); !ok) return ok;
  if (Result<void> ok = check_mesh(mesh); !ok) return ok;
  if (Result<void> ok = check_tiles(rig, tiles); !ok) return ok;
  int width = 0, height = 0;
  for (const PictureTile& tile : tiles) {
    width = std::max(width, tile.picture->width);
    height = std::max(height, tile.picture->height);
  }
  if (Result<void> ok = check_fit(width, height, tiles.size()); !ok) return ok;

  Impl& s = *impl_;
  s.cameras.clear();
  s.rig_index.clear();
  s.ranked = rig.cameras;
  s.slot.assign(rig.cameras.size(), -1);
  std::vector<CameraBlock> blocks;
  // Tiles change their size with every step of the subject: storage only grows.
  s.photographs.reserve(GL_RGBA8, GL_LINEAR, width, height, static_cast<int>(tiles.size()));
  for (const PictureTile& tile : tiles) {
    const int layer = static_cast<int>(s.cameras.size());
    const auto camera = static_cast<std::size_t>(tile.camera);
    s.slot[camera] = layer;
    s.rig_index.push_back(tile.camera);
    s.cameras.push_back(rig.cameras[camera]);
    blocks.push_back(camera_block(s.cameras.back(), layer));
    const Image& picture = *tile.picture;
    blocks.back().tile = {static_cast<float>(tile.x), static_cast<float>(tile.y),
                          static_cast<float>(picture.width), static_cast<float>(picture.height)};
    with_matte(s.cameras.back(), picture, tile.matte->pixels.data(), s.staging);
    glTextureSubImage3D(s.photographs.id(), 0, 0, 0, layer, picture.width, picture.height, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, s.staging.data());
  }
  s.put_mesh(mesh);
  s.put_cameras(blocks);
  return {};
}

CameraChoice SceneTextures::Impl::choose(const View& view, int count) const {
  std::vector<bool> pictured(ranked.size());
  for (std::size_t i = 0; i < ranked.size(); ++i) pictured[i] = slot[i] >= 0;
  CameraChoice choice = choose_cameras(ranked, samples, view, count, pictured);
  for (int& camera : choice.listed) camera = slot[static_cast<std::size_t>(camera)];
  return choice;
}

void SceneTextures::Impl::put_mesh(const Mesh& source) {
  positions = source.positions;
  indices = static_cast<GLsizei>(source.triangles.size());
  box = source.empty() ? Eigen::AlignedBox3f(Eigen::Vector3f::Zero()) : bounding_box(source);
  samples = ranking_samples(source);
  gl::upload(vertex_buffer, vertex_capacity, positions.data(), positions.size() * sizeof(Eigen::Vector3f));
  gl::upload(index_buffer, index_capacity, source.triangles.data(),
             source.triangles.size() * sizeof(std::uint32_t));
  if (!mesh) mesh = gl::VertexArray::create();
  glVertexArrayVertexBuffer(mesh.id(), 0, vertex_buffer.id(), 0, sizeof(Eigen::Vector3f));
  glVertexArrayElementBuffer(mesh.id(), index_buffer.id());
  glEnableVertexArrayAttrib(mesh.id(), 0);
  glVertexArrayAttribFormat(mesh.id(), 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(mesh.id(), 0, 0);
}

void SceneTextures::Impl::put_cameras(std::vector<CameraBlock>& blocks) {
  depth_maps.plan(cameras, box, blocks);
  gl::upload(camera_buffer, camera_capacity, blocks.data(), blocks.size() * sizeof(CameraBlock));
}

}  // namespace floatstage::render
