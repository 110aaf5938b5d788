#include "core/synthetic/stage_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3f;

constexpr int kLamps = 40;
constexpr float kShadowBias = 0.004f;  // metres: more than the tessellation's error, less than a finger

struct Lamp {
  Vector3f direction;
  float light, cloth;
};

// Directions spread evenly (Fibonacci spiral) over the sphere: a bright soft box in front and above, a weaker
// one behind, overall light from the ceiling, and what floor and walls throw back.
std::array<Lamp, kLamps> lamps() {
  std::array<Lamp, kLamps> result;
  const Vector3f key = Vector3f(-0.8f, 0.7f, 0.7f).normalized(),
                 back = Vector3f(0.6f, -0.7f, 0.7f).normalized();
  for (int i = 0; i < kLamps; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / kLamps;
    const float azimuth = static_cast<float>(i) * std::numbers::pi_v<float> * (3 - std::sqrt(5.0f)),
                r = std::sqrt(1 - z * z);
    const Vector3f d(r * std::cos(azimuth), r * std::sin(azimuth), z);
    const float toward_key = std::max(0.0f, d.dot(key)), toward_back = std::max(0.0f, d.dot(back));
    result[static_cast<std::size_t>(i)] = {d,
                                           0.12f + 0.15f * std::max(0.0f, z) +
                                               1.5f * std::pow(toward_key, 4.0f) +
                                               0.6f * std::pow(toward_back, 4.0f),
                                           z < 0.6f ? 1.0f : 0.0f};
  }
  return result;
}

std::vector<Vector3f> vertex_normals(const std::vector<Vector3f>& positions,
                                     const std::vector<std::uint32_t>& triangles) {
  std::vector<Vector3f> normals(positions.size(), Vector3f::Zero());
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const std::uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    const Vector3f n = (positions[b] - positions[a]).cross(positions[c] - positions[a]);  // weighted by area
    for (std::uint32_t i : {a, b, c}) normals[i] += n;
  }
  for (Vector3f& n : normals) n.normalize();
  return normals;
}

}  // namespace

StageScene::StageScene(RTCDevice device, const Performer& performer, double seconds)
    : performer_(&performer), positions_(performer.positions(seconds)), scene_(rtcNewScene(device)) {
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips between two triangles
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::vector<std::uint32_t>& triangles = performer.triangles();
  void* vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(Vector3f), positions_.size());
  std::memcpy(vertices, positions_.data(), positions_.size() * sizeof(Vector3f));
  void* indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(std::uint32_t), triangles.size() / 3);
  std::memcpy(indices, triangles.data(), triangles.size() * sizeof(std::uint32_t));
  rtcCommitGeometry(mesh);
  rtcAttachGeometry(scene_.get(), mesh);
  rtcReleaseGeometry(mesh);
  rtcCommitScene(scene_.get());
  light_vertices(vertex_normals(positions_, triangles));
  light_hidden_vertices();
}

void StageScene::light_vertices(const std::vector<Vector3f>& normals) {
  const std::size_t n = positions_.size();
  light_.assign(n, 0);
  cloth_.assign(n, 0);
  openness_.assign(n, 0);
  const std::array<Lamp, kLamps> all = lamps();
  std::array<std::uint32_t, kPacket> who{};
  alignas(32) std::array<int, kPacket> valid{};
  RTCRay8 rays;
  for (const Lamp& lamp : all) {
    int count = 0;
    auto flush = [&] {
      for (int k = 0; k < kPacket; ++k) valid[static_cast<std::size_t>(k)] = k < count ? -1 : 0;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcOccluded8(valid.data(), scene_.get(), &context, &rays);
      for (int k = 0; k < count; ++k) {
        if (rays.tfar[k] < 0) continue;
        const std::uint32_t i = who[static_cast<std::size_t>(k)];
        const float cosine = normals[i].dot(lamp.direction) * 4 / kLamps;
        light_[i] += lamp.light * cosine;
        cloth_[i] += lamp.cloth * cosine;
        openness_[i] += cosine;
      }
      count = 0;
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!(normals[i].dot(lamp.direction) > 0)) continue;
      const Vector3f p = positions_[i] + kShadowBias * normals[i];
      rays.org_x[count] = p.x();
      rays.org_y[count] = p.y();
      rays.org_z[count] = p.z();
      rays.dir_x[count] = lamp.direction.x();
      rays.dir_y[count] = lamp.direction.y();
      rays.dir_z[count] = lamp.direction.z();
      rays.tnear[count] = 0;
      rays.tfar[count] = std::numeric_limits<float>::infinity();
      rays.time[count] = 0;
      rays.mask[count] = 0xFFFFFFFFu;
      rays.id[count] = 0;
      rays.flags[count] = 0;
      who[static_cast<std::size_t>(count)] = i;
      if (++count == kPacket) flush();
    }
    if (count > 0) flush();
  }
}

// A vertex inside another shell (a sleeve's end in the torso) is black; the triangles that come out from
// there would carry that black into view in saw teeth. Such vertices take the light of their neighbours
// outside.
void StageScene::light_hidden_vertices() {
  constexpr float kInside = 0.02f;
  constexpr int kRounds = 3;
  const std::vector<std::uint32_t>& triangles = performer_->triangles();
  std::vector<char> known(positions_.size());
  for (std::size_t i = 0; i < known.size(); ++i) known[i] = openness_[i] >= kInside;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> light(known.size(), 0), cloth(known.size(), 0), weight(known.size(), 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const std::uint32_t i = triangles[t];
      if (known[i]) continue;
      const std::size_t first = t - t % 3;
      for (std::size_t k = first; k < first + 3; ++k) {
        const std::uint32_t j = triangles[k];
        if (!known[j]) continue;
        light[i] += light_[j];
        cloth[i] += cloth_[j];
        weight[i] += 1;
      }
    }
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (weight[i] == 0) continue;
      light_[i] = light[i] / weight[i];
      cloth_[i] = cloth[i] / weight[i];
      known[i] = 1;
    }
  }
}

void StageScene::intersect(const Vector3f& origin, const std::array<Vector3f, kPacket>& directions, int count,
                           std::array<Hit, kPacket>& hits) const {
  alignas(32) std::array<int, kPacket> valid{};
  RTCRayHit8 packet;
  for (int k = 0; k < kPacket; ++k) {
    const Vector3f& d = directions[static_cast<std::size_t>(k < count ? k : 0)];
    valid[static_cast<std::size_t>(k)] = k < count ? -1 : 0;
    packet.ray.org_x[k] = origin.x();
    packet.ray.org_y[k] = origin.y();
    packet.ray.org_z[k] = origin.z();
    packet.ray.dir_x[k] = d.x();
    packet.ray.dir_y[k] = d.y();
    packet.ray.dir_z[k] = d.z();
    packet.ray.tnear[k] = 0;
    packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
    packet.ray.time[k] = 0;
    packet.ray.mask[k] = 0xFFFFFFFFu;
    packet.ray.id[k] = 0;
    packet.ray.flags[k] = 0;
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid.data(), scene_.get(), &context, &packet);
  for (int k = 0; k < count; ++k) {
    Hit& hit = hits[static_cast<std::size_t>(k)];
    hit = Hit{};
    if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
    const Vector3f normal(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
    const Vector3f& d = directions[static_cast<std::size_t>(k)];
    hit = {packet.hit.primID[k], packet.hit.u[k], packet.hit.v[k], packet.ray.tfar[k],
           std::abs(normal.dot(d)) / std::max(normal.norm() * d.norm(), 1e-20f)};
  }
}

Vector3f StageScene::shade(const Hit& hit, float footprint, float spill, std::uint32_t seed,
                           Dress dress) const {
  const std::uint32_t* corner = performer_->triangles().data() + 3 * static_cast<std::size_t>(hit.triangle);
  const float w[3] = {1 - hit.u - hit.v, hit.u, hit.v};
  const Part& part = performer_->part_of_triangle(hit.triangle);
  SurfacePoint point{part.material, part.variant, Vector3f::Zero(), footprint / std::max(hit.cosine, 0.25f)};
  float light = 0, cloth = 0;
  for (int k = 0; k < 3; ++k) {
    point.rest += w[k] * performer_->rest()[corner[k]];
    light += w[k] * light_[corner[k]];
    cloth += w[k] * cloth_[corner[k]];
  }
  const bool other = part.body > 0 && !performer_->alike();
  const Vector3f color = albedo(point, seed, other ? Dress::Other : dress);
  // Square root: albedo is in gamma space, where half the light is not half the value.
  const Vector3f lit = color * (0.10f + 1.12f * std::sqrt(light));
  if (spill == 0) return lit;
  // Even black cloth and hair shine a little green beside a green wall.
  const Vector3f green(0.03f, 0.24f, 0.08f);
  return lit + spill * cloth * (color + Vector3f::Constant(0.25f)).cwiseProduct(green);
}

}  // namespace floatstage::synthetic
