#include "studio/messages/scene_message.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/rig.h"
#include "studio/messages/byte_io.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::size_t kShaLetters = 64, kMostShortCorners = std::size_t{1} << 16;
constexpr std::size_t kLeastCamera = 1 + 1 + 8, kLongestRemark = 4096;

bool is_digest(std::string_view sha) {
  return sha.size() == kShaLetters && sha.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// What a window and a log can show.
bool is_sentence(std::string_view text) {
  return text.size() <= kLongestRemark &&
         std::none_of(text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ') || c == 127; });
}

// Why a mesh makes no sense, or nothing.
const char* fault_of(const Mesh& mesh) {
  if (mesh.positions.size() > kMostVertices || mesh.triangle_count() > kMostTriangles)
    return "a mesh that is too large";
  if (mesh.triangles.size() % 3 != 0) return "triangles without three corners";
  for (const Eigen::Vector3f& p : mesh.positions)
    if (!p.allFinite()) return "a position that is no number";
  const auto last = std::max_element(mesh.triangles.begin(), mesh.triangles.end());
  if (last != mesh.triangles.end() && *last >= mesh.positions.size())
    return "a triangle's corner that is not there";
  return nullptr;
}

template <class Corner>
void put_corners(const std::vector<std::uint32_t>& triangles, ByteWriter& out) {
  for (std::uint32_t corner : triangles) out.put(static_cast<Corner>(corner));
}

template <class Corner>
void get_corners(std::string_view bytes, std::vector<std::uint32_t>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Corner corner;
    std::memcpy(&corner, bytes.data() + i * sizeof corner, sizeof corner);
    triangles[i] = corner;
  }
}

}  // namespace

Result<std::string> encode_scene(const StudioScene& scene) {
  const auto bad = [](const char* what) {
    return fail(ErrorCode::InvalidArgument, std::string("scene: ") + what);
  };
  if (const char* fault = fault_of(scene.mesh)) return bad(fault);
  if (!is_digest(scene.rig_sha256)) return bad("no digest of its rig");
  if (scene.cameras.size() > kMostCameras) return bad("too many cameras");
  std::string payload;
  payload.reserve(256 + scene.mesh.positions.size() * 12 + scene.mesh.triangles.size() * 4);
  ByteWriter out(payload);
  out.put_bytes(scene.rig_sha256);
  out.put_varint(scene.cameras.size());
  for (const StudioScene::Camera& camera : scene.cameras) {
    if (camera.serial.size() > kLongestSerial) return bad("a serial that is too long");
    out.put(static_cast<std::uint8_t>(camera.serial.size()));
    out.put_bytes(camera.serial);
    out.put(camera.exposed.ns);
  }
  if (!is_sentence(scene.remark)) return bad("a remark that is no sentence");
  out.put_varint(scene.remark.size());
  out.put_bytes(scene.remark);
  out.put_varint(scene.mesh.positions.size());
  for (const Eigen::Vector3f& p : scene.mesh.positions)
    for (int axis = 0; axis < 3; ++axis) out.put(p[axis]);
  out.put_varint(scene.mesh.triangle_count());
  if (scene.mesh.positions.size() <= kMostShortCorners)
    put_corners<std::uint16_t>(scene.mesh.triangles, out);
  else
    put_corners<std::uint32_t>(scene.mesh.triangles, out);
  MessageHeader header;
  header.kind = MessageKind::Scene;
  header.epoch = scene.epoch;
  header.instant = header.exposed = scene.instant;
  header.produced = scene.produced;
  return seal(header, payload);
}

Result<StudioScene> decode_scene(const Message& message) {
  const auto bad = [](const char* what) { return fail(ErrorCode::BadData, std::string("scene: ") + what); };
  if (message.header.kind != MessageKind::Scene) return bad("the message is of another kind");
  StudioScene scene;
  scene.epoch = message.header.epoch;
  scene.instant = message.header.instant;
  scene.produced = message.header.produced;
  ByteReader in(message.payload);
  scene.rig_sha256 = in.get_bytes(kShaLetters);
  const std::size_t cameras = in.get_count(kLeastCamera);
  if (!is_digest(scene.rig_sha256) || cameras > kMostCameras) return bad("cut off");
  for (std::size_t i = 0; i < cameras; ++i) {
    StudioScene::Camera camera;
    camera.serial = in.get_bytes(in.get<std::uint8_t>());
    camera.exposed.ns = in.get<std::int64_t>();
    if (!is_usable_serial(camera.serial) || camera.serial.size() > kLongestSerial)
      return bad("a camera without a serial");
    scene.cameras.push_back(std::move(camera));
  }
  scene.remark = in.get_bytes(in.get_count(1));
  if (!is_sentence(scene.remark)) return bad("a remark that is no sentence");
  const std::size_t vertices = in.get_count(3 * sizeof(float));
  if (vertices > kMostVertices) return bad("a mesh that is too large");
  const std::string_view positions = in.get_bytes(vertices * 3 * sizeof(float));
  const std::size_t corner_bytes =
      vertices <= kMostShortCorners ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
  const std::size_t triangles = in.get_count(3 * corner_bytes);
  if (triangles > kMostTriangles) return bad("a mesh that is too large");
  const std::string_view corners = in.get_bytes(triangles * 3 * corner_bytes);
  if (!in.done()) return bad("of another length than announced");
  scene.mesh.positions.resize(vertices);
  for (std::size_t i = 0; i < vertices; ++i)
    std::memcpy(scene.mesh.positions[i].data(), positions.data() + i * 3 * sizeof(float), 3 * sizeof(float));
  scene.mesh.triangles.resize(triangles * 3);
  if (corner_bytes == sizeof(std::uint16_t))
    get_corners<std::uint16_t>(corners, scene.mesh.triangles);
  else
    get_corners<std::uint32_t>(corners, scene.mesh.triangles);
  if (const char* fault = fault_of(scene.mesh)) return bad(fault);
  return scene;
}

}  // namespace floatstage::studio::wire
