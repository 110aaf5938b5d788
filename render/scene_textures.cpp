#include "render/scene_textures.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/text.h"
#include "render/scene_textures_impl.h"

namespace floatstage {
namespace {

constexpr std::size_t kRankingSamples = 96;

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
  const bool recolor = !camera.color.is_identity();
  const ColorTable table(camera.color);
  Image out(in.width, in.height, 4);
  for (int y = 0; y < in.height; ++y) {
    const std::uint8_t* from = in.at(0, y);
    const std::uint8_t* alpha = matte != nullptr ? matte->row(y) : nullptr;
    std::uint8_t* to = out.at(0, y);
    for (int x = 0; x < in.width; ++x, from += 3, to += 4) {
      if (recolor) {
        table.apply(from, to);
      } else {
        std::copy_n(from, 3, to);
      }
      to[3] = alpha != nullptr ? alpha[x] : 255;
    }
  }
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
  GLint largest = 0, most_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (std::max(width, height) > largest || static_cast<int>(pictures.size()) > most_layers)
    return fail(ErrorCode::Unsupported,
                text(pictures.size(), " pictures of up to ", width, "x", height,
                     " do not fit this GPU's textures (", largest, " px, ", most_layers, " layers)"));

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

  s.positions = scene.mesh.positions;
  s.indices = static_cast<GLsizei>(scene.mesh.triangles.size());
  s.box = scene.mesh.empty() ? Eigen::AlignedBox3f(Eigen::Vector3f::Zero()) : bounding_box(scene.mesh);
  s.samples.clear();
  const std::size_t stride = std::max<std::size_t>(1, scene.mesh.triangle_count() / kRankingSamples);
  for (std::size_t t = 0; t < scene.mesh.triangle_count(); t += stride)
    s.samples.push_back(s.positions[scene.mesh.triangles[3 * t]]);
  gl::upload(s.vertex_buffer, s.vertex_capacity, s.positions.data(),
             s.positions.size() * sizeof(Eigen::Vector3f));
  gl::upload(s.index_buffer, s.index_capacity, scene.mesh.triangles.data(),
             scene.mesh.triangles.size() * sizeof(std::uint32_t));
  if (!s.mesh) s.mesh = gl::VertexArray::create();
  glVertexArrayVertexBuffer(s.mesh.id(), 0, s.vertex_buffer.id(), 0, sizeof(Eigen::Vector3f));
  glVertexArrayElementBuffer(s.mesh.id(), s.index_buffer.id());
  glEnableVertexArrayAttrib(s.mesh.id(), 0);
  glVertexArrayAttribFormat(s.mesh.id(), 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(s.mesh.id(), 0, 0);

  s.depth_maps.plan(s.cameras, s.box, blocks);
  gl::upload(s.camera_buffer, s.camera_capacity, blocks.data(), blocks.size() * sizeof(CameraBlock));
  return {};
}

}  // namespace floatstage
