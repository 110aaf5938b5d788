// glTF 2.0 (Khronos, 2021), §3.10 cameras and §3.11 animations; a camera looks along its -z, y upwards.
#include "pipeline/export/export_path.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "calib/colmap_model.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/export/web_frame.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kPi = std::numbers::pi;
constexpr int kFloat = 5126;

// The buffer of a glTF and its accessors.
class Floats {
 public:
  int add(const std::vector<float>& values, const char* type, int width) {
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(float)}});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    json accessor = {{"bufferView", views_.size() - 1},
                     {"componentType", kFloat},
                     {"count", values.size() / static_cast<std::size_t>(width)},
                     {"type", type}};
    if (width == 1)
      accessor["min"] = json::array({values.front()}), accessor["max"] = json::array({values.back()});
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }
  const std::string& bytes() const { return bytes_; }
  const json& views() const { return views_; }
  const json& accessors() const { return accessors_; }

 private:
  std::string bytes_;
  json views_ = json::array(), accessors_ = json::array();
};

void put(std::string& out, std::uint32_t value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string glb(const json& document, std::string buffer) {
  std::string words = document.dump();
  words.resize((words.size() + 3) / 4 * 4, ' ');
  buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  std::string out = "glTF";
  put(out, 2);
  put(out, static_cast<std::uint32_t>(12 + 8 + words.size() + 8 + buffer.size()));
  put(out, static_cast<std::uint32_t>(words.size()));
  out += "JSON" + words;
  put(out, static_cast<std::uint32_t>(buffer.size()));
  out.append("BIN\0", 4);
  return out + buffer;
}

json channel(int sampler, const char* path) {
  return {{"sampler", sampler}, {"target", {{"node", 1}, {"path", path}}}};
}

Result<void> write_colmap(const std::vector<FilmCamera>& cameras, int width, int height,
                          const fs::path& out) {
  Rig rig;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    char serial[32] = "";
    std::snprintf(serial, sizeof serial, "frame_%06zu", i);
    const double f = height / (2 * std::tan(cameras[i].fov_y * kPi / 360));
    rig.cameras.push_back({serial, {}, cameras[i].cam_from_world, {}});
    CameraModel& model = rig.cameras.back().model;
    model.width = width, model.height = height;
    model.fx = model.fy = f;
    model.cx = width / 2.0, model.cy = height / 2.0;
    names.push_back(std::string(serial) + ".png");
  }
  Result<UnfinishedFolder> folder = UnfinishedFolder::begin(out);
  if (!folder) return forward(folder);
  if (Result<void> ok = calib::write_colmap_model(rig, names, {}, folder->folder()); !ok) return ok;
  return folder->publish();
}

}  // namespace

std::string to_gltf(const std::vector<FilmCamera>& cameras, bool z_up, bool binary) {
  std::vector<float> times, places, turns;
  json fields = json::array(), distances = json::array(), shown = json::array();
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  for (const FilmCamera& camera : cameras) {
    times.push_back(static_cast<float>(camera.time));
    const Eigen::Vector3f center = camera.cam_from_world.center().cast<float>();
    places.insert(places.end(), center.data(), center.data() + 3);
    // Its y and z point the other way.
    Eigen::Quaterniond q = camera.cam_from_world.rotation.conjugate() * Eigen::Quaterniond(0, 1, 0, 0);
    if (q.dot(last) < 0) q.coeffs() = -q.coeffs();  // or it would go the long way round
    last = q;
    for (const double v : {q.x(), q.y(), q.z(), q.w()}) turns.push_back(static_cast<float>(v));
    fields.push_back(camera.fov_y);
    distances.push_back(camera.distance.value_or(1));
    if (camera.take_time) shown.push_back(*camera.take_time);
  }
  Floats floats;
  const int input = floats.add(times, "SCALAR", 1), translation = floats.add(places, "VEC3", 3),
            rotation = floats.add(turns, "VEC4", 4);
  json extras = {{"fov_y", std::move(fields)}, {"distance", std::move(distances)}};
  if (shown.size() == cameras.size()) extras["take_time"] = std::move(shown);
  const double half = std::numbers::sqrt2 / 2;
  json stage = {{"name", "stage"}, {"children", json::array({1})}};
  if (!z_up) stage["rotation"] = json::array({-half, 0, 0, half});
  json node = {{"name", "camera"},
               {"camera", 0},
               {"translation", json::array({places[0], places[1], places[2]})},
               {"rotation", json::array({turns[0], turns[1], turns[2], turns[3]})}};
  const auto sampler = [&](int output) {
    return json{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}};
  };
  json animation = {{"name", "path"},
                    {"channels", json::array({channel(0, "translation"), channel(1, "rotation")})},
                    {"samplers", json::array({sampler(translation), sampler(rotation)})},
                    {"extras", {{"floatstage", std::move(extras)}}}};
  json document = {
      {"asset", {{"version", "2.0"}, {"generator", "floatstage"}}},
      {"scene", 0},
      {"scenes", json::array({json{{"nodes", json::array({0})}}})},
      {"cameras",
       json::array({json{{"name", "film"},
                         {"type", "perspective"},
                         {"perspective", {{"yfov", cameras.front().fov_y * kPi / 180}, {"znear", 0.01}}}}})},
      {"nodes", json::array({std::move(stage), std::move(node)})},
      {"animations", json::array({std::move(animation)})},
      {"accessors", floats.accessors()},
      {"bufferViews", floats.views()}};
  json buffer = {{"byteLength", floats.bytes().size()}};
  if (!binary) buffer["uri"] = "data:application/octet-stream;base64," + base64(floats.bytes());
  document["buffers"] = json::array({std::move(buffer)});
  return binary ? glb(document, floats.bytes()) : document.dump(1) + "\n";
}

bool names_a_gltf(const fs::path& file) { return file.extension() == ".gltf" || file.extension() == ".glb"; }

Result<void> export_path(const std::vector<FilmCamera>& cameras, int width, int height, bool z_up,
                         const fs::path& out) {
  if (cameras.size() < 2)
    return fail(ErrorCode::InvalidArgument,
                text(out.string(), ": the path has one key, or lasts no time: a camera that moves has two"));
  if (!names_a_gltf(out)) return write_colmap(cameras, width, height, out);
  if (is_there(out))
    return fail(ErrorCode::AlreadyExists,
                text(out.string(), ": is there already, and is left as it is; give another --out"));
  return write_file(out, to_gltf(cameras, z_up, out.extension() == ".glb"));
}

}  // namespace floatstage::pipeline
