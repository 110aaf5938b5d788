#include "pipeline/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
constexpr double kPi = std::numbers::pi;

json to_json(const Vector3d& v) { return json::array({v.x(), v.y(), v.z()}); }

// Cubic Hermite between b and c with finite-difference tangents over uneven times.
template <class T>
T spline(const T& a, const T& b, const T& c, const T& d, double ta, double tb, double tc, double td,
         double t) {
  const double h = tc - tb, s = (t - tb) / h;
  const T tangent_b = tc > ta ? T((c - a) * (h / (tc - ta))) : T(c - b);
  const T tangent_c = td > tb ? T((d - b) * (h / (td - tb))) : T(c - b);
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * b + (s3 - 2 * s2 + s) * tangent_b + (3 * s2 - 2 * s3) * c +
         (s3 - s2) * tangent_c;
}

Result<Vector3d> vector_of(const json& j, const char* key, const std::string& where) {
  if (!j.contains(key) || !j[key].is_array() || j[key].size() != 3)
    return fail(ErrorCode::BadData, text(where, ": \"", key, "\" must be three numbers"));
  Vector3d v;
  for (int i = 0; i < 3; ++i) {
    if (!j[key][i].is_number())
      return fail(ErrorCode::BadData, text(where, ": \"", key, "\" must be three numbers"));
    v[i] = j[key][i].get<double>();
  }
  if (!v.allFinite()) return fail(ErrorCode::BadData, text(where, ": \"", key, "\" is not finite"));
  return v;
}

Result<PathKey> parse_key(const json& j, const std::string& where) {
  PathKey key;
  for (auto [name, member] : {std::pair{"time", &PathKey::time}, {"fov_y", &PathKey::fov_y}}) {
    if (!j.is_object() || !j.contains(name) || !j[name].is_number())
      return fail(ErrorCode::BadData, text(where, ": \"", name, "\" must be a number"));
    key.*member = j[name].get<double>();
  }
  for (auto [name, member] :
       {std::pair{"eye", &PathKey::eye}, {"target", &PathKey::target}, {"up", &PathKey::up}}) {
    Result<Vector3d> v = vector_of(j, name, where);
    if (!v) return forward(v);
    key.*member = *v;
  }
  if (!(key.fov_y > 0.1 && key.fov_y < 170))
    return fail(ErrorCode::BadData, text(where, ": \"fov_y\" must lie between 0.1 and 170 degrees"));
  if ((key.target - key.eye).cross(key.up).norm() < 1e-9)
    return fail(ErrorCode::BadData, text(where, ": \"up\" lies along the viewing direction"));
  return key;
}

}  // namespace

PathKey sample(const CameraPath& path, double time) {
  FLOATSTAGE_CHECK(!path.keys.empty(), "sampling a path without keys");
  const std::vector<PathKey>& keys = path.keys;
  if (time <= keys.front().time) return keys.front();
  if (time >= keys.back().time) return keys.back();
  const std::size_t n = keys.size();
  std::size_t i = 0;
  while (i + 2 < n && keys[i + 1].time <= time) ++i;
  const PathKey &b = keys[i], &c = keys[i + 1], &a = keys[i > 0 ? i - 1 : i],
                &d = keys[std::min(i + 2, n - 1)];
  auto at = [&](auto member) {
    return spline(a.*member, b.*member, c.*member, d.*member, a.time, b.time, c.time, d.time, time);
  };
  return {time, at(&PathKey::eye), at(&PathKey::target), at(&PathKey::up).normalized(), at(&PathKey::fov_y)};
}

View view_of(const PathKey& key, int width, int height, const Eigen::AlignedBox3d& subject) {
  View view;
  const double f = height / (2 * std::tan(key.fov_y * kPi / 360));
  view.model = {.width = width,
                .height = height,
                .fx = f,
                .fy = f,
                .cx = width / 2.0,
                .cy = height / 2.0,
                .skew = 0,
                .lens = {}};
  view.view_from_world = look_at(key.eye, key.target, key.up);
  const double radius = subject.isEmpty() ? 1 : subject.diagonal().norm() / 2;
  const double distance =
      subject.isEmpty() ? (key.target - key.eye).norm() : (subject.center() - key.eye).norm();
  view.far_plane = distance + 1.5 * radius;
  view.near_plane = std::max(distance - 1.5 * radius, view.far_plane * 1e-3);
  return view;
}

Result<CameraPath> parse_path(std::string_view text_json, std::string_view name) {
  const Result<json> parsed = parse_json(text_json, name);
  const json j = parsed ? *parsed : json();
  if (!j.is_object() || !j.contains("floatstage_path") || !j.contains("keys") || !j["keys"].is_array())
    return fail(
        ErrorCode::BadData,
        text(name,
             ": not a camera path ({\"floatstage_path\": 1, \"keys\": […]}); `floatstage play` writes one"));
  CameraPath path;
  for (const json& k : j["keys"]) {
    Result<PathKey> key = parse_key(k, text(name, ", key ", path.keys.size()));
    if (!key) return forward(key);
    if (!path.keys.empty() && !(key->time > path.keys.back().time))
      return fail(ErrorCode::BadData, text(name, ", key ", path.keys.size(), ": times must grow"));
    path.keys.push_back(*key);
  }
  if (path.keys.empty()) return fail(ErrorCode::BadData, text(name, ": the path has no keys"));
  return path;
}

std::string to_json(const CameraPath& path) {
  json keys = json::array();
  for (const PathKey& k : path.keys)
    keys.push_back({{"time", k.time},
                    {"eye", to_json(k.eye)},
                    {"target", to_json(k.target)},
                    {"up", to_json(k.up)},
                    {"fov_y", k.fov_y}});
  return json{{"floatstage_path", 1}, {"keys", keys}}.dump(2) + "\n";
}

Result<CameraPath> load_path(const std::filesystem::path& file) {
  Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_path(*bytes, file.string());
}

Result<void> save_path(const CameraPath& path, const std::filesystem::path& file) {
  return write_file(file, to_json(path));
}

}  // namespace floatstage::pipeline
