// glTF 2.0 as one binary file (Khronos, 2021), by tinygltf.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <sstream>

#include <tiny_gltf.h>

#include "core/file.h"
#include "core/glb_scene.h"
#include "core/mesh_io.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr std::uint64_t kLargestGlb = std::uint64_t{0xffffffff};

// Appends `bytes` to the model's one buffer and returns the index of a view of them.
int add_view(tinygltf::Model& model, const void* data, std::size_t bytes, int target) {
  std::vector<unsigned char>& buffer = model.buffers.front().data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = buffer.size();
  view.byteLength = bytes;
  view.target = target;
  buffer.resize(buffer.size() + bytes);
  std::memcpy(buffer.data() + view.byteOffset, data, bytes);
  model.bufferViews.push_back(view);
  return static_cast<int>(model.bufferViews.size()) - 1;
}

int add_accessor(tinygltf::Model& model, tinygltf::Accessor accessor) {
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

int add_positions(tinygltf::Model& model, const Mesh& mesh) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float), "positions go into the buffer as they are");
  const Eigen::AlignedBox3f box = bounding_box(mesh);
  tinygltf::Accessor positions;
  positions.bufferView =
      add_view(model, mesh.positions.data(), mesh.positions.size() * sizeof(Eigen::Vector3f),
               TINYGLTF_TARGET_ARRAY_BUFFER);
  positions.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  positions.type = TINYGLTF_TYPE_VEC3;
  positions.count = mesh.positions.size();
  for (int i = 0; i < 3; ++i) {
    positions.minValues.push_back(box.min()[i]);
    positions.maxValues.push_back(box.max()[i]);
  }
  return add_accessor(model, std::move(positions));
}

int add_indices(tinygltf::Model& model, const Mesh& mesh) {
  tinygltf::Accessor indices;
  indices.bufferView = add_view(model, mesh.triangles.data(), mesh.triangles.size() * sizeof(std::uint32_t),
                                TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  indices.type = TINYGLTF_TYPE_SCALAR;
  indices.count = mesh.triangles.size();
  return add_accessor(model, std::move(indices));
}

// Vertex colours are light in glTF, so the sRGB curve (IEC 61966-2-1) comes off; in 16 bits the dark ones
// keep their steps. A fourth channel keeps vertices on multiples of four bytes.
int add_colors(tinygltf::Model& model, const std::vector<std::array<std::uint8_t, 3>>& colors) {
  std::array<std::uint16_t, 256> light{};
  for (std::size_t v = 0; v < light.size(); ++v) {
    const double c = static_cast<double>(v) / 255;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    light[v] = static_cast<std::uint16_t>(std::lround(linear * 65535));
  }
  std::vector<std::uint16_t> rgba;
  rgba.reserve(colors.size() * 4);
  for (const std::array<std::uint8_t, 3>& c : colors)
    rgba.insert(rgba.end(), {light[c[0]], light[c[1]], light[c[2]], 65535});
  tinygltf::Accessor accessor;
  accessor.bufferView =
      add_view(model, rgba.data(), rgba.size() * sizeof(std::uint16_t), TINYGLTF_TARGET_ARRAY_BUFFER);
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  accessor.type = TINYGLTF_TYPE_VEC4;
  accessor.normalized = true;
  accessor.count = colors.size();
  return add_accessor(model, std::move(accessor));
}

// The one material of coloured meshes, made for the first.
int unlit(tinygltf::Model& model) {
  if (!model.materials.empty()) return 0;
  tinygltf::Material material;
  material.name = "photographs";
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 1;
  material.extensions["KHR_materials_unlit"] = tinygltf::Value(tinygltf::Value::Object());
  model.materials.push_back(std::move(material));
  model.extensionsUsed.emplace_back("KHR_materials_unlit");
  return 0;
}

// glTF knows no empty mesh: -1 then.
int add_mesh(tinygltf::Model& model, const ColoredMesh& colored) {
  if (colored.mesh.empty()) return -1;
  tinygltf::Primitive primitive;
  primitive.attributes["POSITION"] = add_positions(model, colored.mesh);
  primitive.indices = add_indices(model, colored.mesh);
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  if (!colored.colors.empty()) {
    primitive.attributes["COLOR_0"] = add_colors(model, colored.colors);
    primitive.material = unlit(model);
  }
  model.meshes.emplace_back().primitives.push_back(primitive);
  return static_cast<int>(model.meshes.size()) - 1;
}

int add_floats(tinygltf::Model& model, const std::vector<float>& values, int type) {
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, values.data(), values.size() * sizeof(float), 0);
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.type = type;
  accessor.count = values.size() / (type == TINYGLTF_TYPE_VEC3 ? 3 : 1);
  if (type == TINYGLTF_TYPE_SCALAR) {  // times: readers want to know how long it takes
    accessor.minValues = {values.front()};
    accessor.maxValues = {values.back()};
  }
  return add_accessor(model, std::move(accessor));
}

// `node` is there from one time to the next, of an animation that begins at 0.
void show_between(tinygltf::Model& model, int node, double from, double to, double end) {
  std::vector<float> times, scales;
  const auto key = [&](double time, float scale) {
    times.push_back(static_cast<float>(time));
    scales.insert(scales.end(), 3, scale);
  };
  if (from > 0) key(0, 0);
  key(from, 1);
  key(to, to < end ? 0.F : 1.F);  // the last one stays
  tinygltf::Animation& animation = model.animations.front();
  tinygltf::AnimationSampler sampler;
  sampler.interpolation = "STEP";
  sampler.input = add_floats(model, times, TINYGLTF_TYPE_SCALAR);
  sampler.output = add_floats(model, scales, TINYGLTF_TYPE_VEC3);
  animation.samplers.push_back(sampler);
  tinygltf::AnimationChannel channel;
  channel.sampler = static_cast<int>(animation.samplers.size()) - 1;
  channel.target_node = node;
  channel.target_path = "scale";
  animation.channels.push_back(channel);
}

void add_frames(tinygltf::Model& model, std::span<const ColoredMesh> frames, double frame_rate) {
  model.animations.emplace_back().name = "take";
  const double end = static_cast<double>(frames.size()) / frame_rate;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    tinygltf::Node node;
    node.name = text("frame ", i);
    node.mesh = add_mesh(model, frames[i]);
    if (i > 0) node.scale = {0, 0, 0};  // viewers without animation show the first
    model.nodes.push_back(node);
    const int index = static_cast<int>(model.nodes.size()) - 1;
    model.nodes.front().children.push_back(index);
    show_between(model, index, static_cast<double>(i) / frame_rate, static_cast<double>(i + 1) / frame_rate,
                 end);
  }
}

std::uint64_t size_of(std::span<const ColoredMesh> frames) {
  std::uint64_t bytes = 0;
  for (const ColoredMesh& f : frames)
    bytes += f.mesh.positions.size() * 12 + f.mesh.triangles.size() * 4 + f.colors.size() * 8 + 1024;
  return bytes;
}

}  // namespace

Result<void> save_glb(std::span<const ColoredMesh> frames, double frame_rate, GlbUp up,
                      const std::filesystem::path& file) {
  if (size_of(frames) > kLargestGlb)
    return fail(ErrorCode::InvalidArgument,
                text(file.string(),
                     " would be larger than 4 GiB, which no GLB is; take fewer frames, or "
                     "coarser ones"));
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "floatstage";
  model.nodes.emplace_back().name = "stage";
  if (up == GlbUp::Y)  // x y z w: our z up becomes y up
    model.nodes.front().rotation = {-std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2};
  const bool any = std::any_of(frames.begin(), frames.end(), [](const auto& f) { return !f.mesh.empty(); });
  if (any || frames.size() > 1) model.buffers.emplace_back();
  if (frames.size() == 1) {
    model.nodes.front().mesh = add_mesh(model, frames.front());
  } else if (frames.size() > 1) {
    add_frames(model, frames, frame_rate);
  }
  model.scenes.emplace_back().nodes.push_back(0);
  model.defaultScene = 0;
  std::ostringstream out;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, out, false, true))
    return fail(ErrorCode::Io, text("cannot encode ", file.string(), " as GLB"));
  return write_file(file, std::move(out).str());
}

Result<void> save_glb(const Mesh& mesh, const std::filesystem::path& file) {
  const ColoredMesh plain{mesh, {}};
  return save_glb(std::span(&plain, 1), 0, GlbUp::Y, file);
}

}  // namespace floatstage
