#include <cmath>
#include <cstring>
#include <numbers>
#include <sstream>

#include <tiny_gltf.h>

#include "core/file.h"
#include "core/mesh_io.h"
#include "core/text.h"

namespace floatstage {
namespace {

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

void add_mesh(tinygltf::Model& model, const Mesh& mesh) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float), "positions go into the buffer as they are");
  model.buffers.emplace_back();
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
  tinygltf::Accessor indices;
  indices.bufferView = add_view(model, mesh.triangles.data(), mesh.triangles.size() * sizeof(std::uint32_t),
                                TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  indices.type = TINYGLTF_TYPE_SCALAR;
  indices.count = mesh.triangles.size();
  model.accessors = {positions, indices};

  tinygltf::Primitive primitive;
  primitive.attributes["POSITION"] = 0;
  primitive.indices = 1;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  model.meshes.emplace_back().primitives.push_back(primitive);
}

}  // namespace

Result<void> save_glb(const Mesh& mesh, const std::filesystem::path& file) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "floatstage";
  tinygltf::Node node;
  node.name = "stage";
  node.rotation = {-std::numbers::sqrt2 / 2, 0, 0,
                   std::numbers::sqrt2 / 2};  // x y z w: our z up becomes y up
  if (!mesh.empty()) {                        // glTF knows no empty mesh: then the node stands alone
    add_mesh(model, mesh);
    node.mesh = 0;
  }
  model.nodes.push_back(node);
  model.scenes.emplace_back().nodes.push_back(0);
  model.defaultScene = 0;

  std::ostringstream out;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, out, false, true))
    return fail(ErrorCode::Io, text("cannot encode ", file.string(), " as GLB"));
  return write_file(file, std::move(out).str());
}

}  // namespace floatstage
