#include <cmath>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"
#include "pipeline/camera_path.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr int kVersion = 2;
constexpr double kLongest = 1e6;  // seconds: eleven days
constexpr int kMostTurns = 1000;

json to_json(const Vector3d& v) { return json::array({v.x(), v.y(), v.z()}); }

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

Result<void> number_of(const json& j, const char* key, double least, double most, const std::string& where,
                       double& value) {
  if (!j.contains(key)) return {};
  if (!j[key].is_number() || !(j[key].get<double>() >= least && j[key].get<double>() <= most))
    return fail(ErrorCode::BadData,
                text(where, ": \"", key, "\" must be a number from ", least, " to ", most));
  value = j[key].get<double>();
  return {};
}

// What version 1 had not.
Result<void> parse_more(const json& j, const std::string& where, PathKey& key) {
  double take_time = 0, turns = 0;
  if (Result<void> ok = number_of(j, "take_time", -kLongest, kLongest, where, take_time); !ok) return ok;
  if (j.contains("take_time")) key.take_time = take_time;
  if (Result<void> ok = number_of(j, "ease_in", 0, 1, where, key.ease_in); !ok) return ok;
  if (Result<void> ok = number_of(j, "ease_out", 0, 1, where, key.ease_out); !ok) return ok;
  if (Result<void> ok = number_of(j, "orbit", -kMostTurns, kMostTurns, where, turns); !ok) return ok;
  if (j.contains("orbit")) key.orbit = static_cast<int>(std::lround(turns));
  if (j.contains("follow") && !j["follow"].is_boolean())
    return fail(ErrorCode::BadData, text(where, ": \"follow\" must be true or false"));
  key.follow = j.contains("follow") && j["follow"].get<bool>();
  return {};
}

Result<PathKey> parse_key(const json& j, const std::string& where) {
  PathKey key;
  for (auto [name, member] : {std::pair{"time", &PathKey::time}, {"fov_y", &PathKey::fov_y}}) {
    if (!j.is_object() || !j.contains(name) || !j[name].is_number())
      return fail(ErrorCode::BadData, text(where, ": \"", name, "\" must be a number"));
    key.*member = j[name].get<double>();
  }
  if (!(std::abs(key.time) <= kLongest))
    return fail(ErrorCode::BadData, text(where, ": \"time\" is beyond ", kLongest, " seconds"));
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
  if (Result<void> ok = parse_more(j, where, key); !ok) return forward(ok);
  return key;
}

json to_json(const PathKey& k) {
  json j = {{"time", k.time},
            {"eye", to_json(k.eye)},
            {"target", to_json(k.target)},
            {"up", to_json(k.up)},
            {"fov_y", k.fov_y}};
  if (k.take_time) j["take_time"] = *k.take_time;
  if (k.ease_in != 0) j["ease_in"] = k.ease_in;
  if (k.ease_out != 0) j["ease_out"] = k.ease_out;
  if (k.follow) j["follow"] = true;
  if (k.orbit) j["orbit"] = *k.orbit;
  return j;
}

}  // namespace

Result<CameraPath> parse_path(std::string_view text_json, std::string_view name) {
  const Result<json> parsed = parse_json(text_json, name);
  const json j = parsed ? *parsed : json();
  if (!j.is_object() || !j.contains("floatstage_path") || !j.contains("keys") || !j["keys"].is_array())
    return fail(
        ErrorCode::BadData,
        text(name,
             ": not a camera path ({\"floatstage_path\": 2, \"keys\": […]}); `floatstage play` writes one"));
  if (const json& version = j["floatstage_path"];
      !version.is_number_integer() || version.get<double>() < 1 || version.get<double>() > kVersion)
    return fail(ErrorCode::Unsupported,
                text(name, ": path format ", version.dump(),
                     " is not known here; this program reads formats 1 to ", kVersion));
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
  for (const PathKey& k : path.keys) keys.push_back(to_json(k));
  return json{{"floatstage_path", kVersion}, {"keys", keys}}.dump(2) + "\n";
}

Result<CameraPath> load_path(const std::filesystem::path& file) {
  Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_path(*bytes, file.string());
}

Result<CameraPath> load_path_without_take(const std::filesystem::path& file) {
  Result<CameraPath> path = load_path(file);
  if (path && path->follows())
    return fail(ErrorCode::InvalidArgument,
                text(file.string(),
                     " follows the subject of a take, which is not known here; take keys that "
                     "stand (`play`: untick \"follows the subject\")"));
  return path;
}

Result<void> save_path(const CameraPath& path, const std::filesystem::path& file) {
  return write_file(file, to_json(path));
}

}  // namespace floatstage::pipeline
