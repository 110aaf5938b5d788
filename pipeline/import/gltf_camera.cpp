// glTF 2.0 (Khronos, 2021): §3.5 scenes and nodes, §3.6 buffers, §3.10 cameras, §3.11 animations, appendix C
// interpolation. Nothing but what moves a camera is looked at.
#include "pipeline/import/gltf_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/text.h"
#include "pipeline/import/gltf_file.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;

constexpr double kStep = 1.0 / 25;  // seconds: between keys that are farther apart cameras are added
constexpr double kSquare = 1e-3;    // sines of angles of axes that are square to one another
constexpr double kFarthest = 1e9;   // metres
constexpr double kLongest = 86400;  // seconds
constexpr double kSameTime = 1e-9;  // seconds

// What one channel does to one of a node's values.
struct Curve {
  std::vector<double> times, values;
  std::size_t width = 3;
  std::string interpolation = "LINEAR";

  Eigen::Vector4d value(std::size_t key, std::size_t part = 0) const {
    const std::size_t stride = interpolation == "CUBICSPLINE" ? 3 : 1;
    Eigen::Vector4d v = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < width; ++i)
      v[static_cast<Eigen::Index>(i)] = values[((stride * key) + (stride == 3 ? part : 0)) * width + i];
    return v;
  }
  Eigen::Vector4d at(double time) const {
    constexpr std::size_t kIn = 0, kValue = 1, kOut = 2;
    if (time <= times.front()) return value(0, kValue);
    if (time >= times.back()) return value(times.size() - 1, kValue);
    const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) -
                                                times.begin()),
               before = after - 1;
    const double h = times[after] - times[before], s = (time - times[before]) / h;
    const Eigen::Vector4d a = value(before, kValue), b = value(after, kValue);
    if (interpolation == "STEP") return a;
    if (interpolation == "CUBICSPLINE") {
      const double s2 = s * s, s3 = s2 * s;
      return (2 * s3 - 3 * s2 + 1) * a + h * (s3 - 2 * s2 + s) * value(before, kOut) + (3 * s2 - 2 * s3) * b +
             h * (s3 - s2) * value(after, kIn);
    }
    if (width == 3) return a + s * (b - a);
    const Quaterniond turned = Quaterniond(a).normalized().slerp(s, Quaterniond(b).normalized());
    return turned.coeffs();
  }
};

struct Node {
  Vector3d translation = Vector3d::Zero(), scale = Vector3d::Ones();
  Quaterniond rotation = Quaterniond::Identity();
  std::optional<Eigen::Matrix4d> matrix;
  int parent = -1, camera = -1;
  std::string name;
  std::map<std::string, Curve> curves;  // by path

  Eigen::Matrix4d at(double time) const {
    if (matrix && curves.empty()) return *matrix;
    const auto moved = [&](const char* path, const Eigen::Vector4d& still) {
      const auto curve = curves.find(path);
      return curve == curves.end() ? still : curve->second.at(time);
    };
    const Eigen::Vector4d t = moved("translation", translation.homogeneous()),
                          s = moved("scale", scale.homogeneous()), q = moved("rotation", rotation.coeffs());
    Eigen::Affine3d m = Eigen::Affine3d::Identity();
    m.translate(t.head<3>()).rotate(Quaterniond(q).normalized()).scale(s.head<3>());
    return m.matrix();
  }
};

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

Vector3d three(const json& j) {
  const auto v = j.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

Node node_of(const json& j) {
  Node node;
  node.name = j.value("name", "");
  node.camera = j.value("camera", -1);
  if (j.contains("translation")) node.translation = three(j["translation"]);
  if (j.contains("scale")) node.scale = three(j["scale"]);
  if (j.contains("rotation")) {
    const auto q = j["rotation"].get<std::array<double, 4>>();
    node.rotation = Quaterniond(q[3], q[0], q[1], q[2]);
  }
  if (j.contains("matrix")) {
    const auto m = j["matrix"].get<std::array<double, 16>>();
    node.matrix = Eigen::Map<const Eigen::Matrix4d>(m.data());
  }
  return node;
}

std::vector<Node> nodes_of(const GltfFile& file) {
  std::vector<Node> nodes;
  for (const json& j : file.list("nodes")) nodes.push_back(node_of(j));
  int parent = 0;
  for (const json& j : file.list("nodes")) {
    if (j.contains("children"))
      for (const json& child : j["children"]) nodes.at(child.get<std::uint32_t>()).parent = parent;
    ++parent;
  }
  return nodes;
}

Curve curve_of(const GltfFile& file, const json& sampler, const std::string& path) {
  Curve curve;
  curve.interpolation = sampler.value("interpolation", "LINEAR");
  GltfNumbers times = file.numbers(sampler.at("input").get<std::uint32_t>()),
              values = file.numbers(sampler.at("output").get<std::uint32_t>());
  const bool cubic = curve.interpolation == "CUBICSPLINE";
  if (!cubic && curve.interpolation != "LINEAR" && curve.interpolation != "STEP")
    refuse(text("an animation goes by ", curve.interpolation, ", which glTF does not know"));
  curve.width = path == "rotation" ? 4 : 3;
  if (times.width != 1 || values.width != curve.width ||
      values.values.size() != times.values.size() * curve.width * (cubic ? 3 : 1))
    refuse(text("an animation of a ", path, " has ", values.values.size(), " numbers for ",
                times.values.size(), " times"));
  for (std::size_t i = 0; i < times.values.size(); ++i)
    if (!(times.values[i] <= kLongest) || (i > 0 && !(times.values[i] > times.values[i - 1])))
      refuse(text("an animation's times do not grow: ", times.values[i], " s at key ", i));
  curve.times = std::move(times.values);
  curve.values = std::move(values.values);
  return curve;
}

// A camera's node and those above it, the camera's first.
std::vector<const Node*> chain_of(const std::vector<Node>& nodes, std::size_t node) {
  std::vector<const Node*> chain;
  for (int at = static_cast<int>(node); at >= 0; at = nodes[static_cast<std::size_t>(at)].parent) {
    if (chain.size() > nodes.size()) refuse("a node lies below itself");
    chain.push_back(&nodes[static_cast<std::size_t>(at)]);
  }
  return chain;
}

bool moves(const std::vector<const Node*>& chain) {
  return std::any_of(chain.begin(), chain.end(), [](const Node* n) { return !n->curves.empty(); });
}

// Of its keys, in order.
std::vector<double> key_times(const std::vector<const Node*>& chain) {
  std::set<double> keys;
  for (const Node* node : chain)
    for (const auto& [path, curve] : node->curves) keys.insert(curve.times.begin(), curve.times.end());
  std::vector<double> times;
  for (const double key : keys)
    if (times.empty() || key - times.back() >= kSameTime) times.push_back(key);
  return times;
}

// With times between those that are far apart.
std::vector<double> densely(const std::vector<double>& keys) {
  std::vector<double> times;
  for (const double key : keys) {
    const double from = times.empty() ? key : times.back();
    const auto pieces = static_cast<int>(std::ceil((key - from) / kStep - 1e-3));
    for (int i = 1; i < pieces; ++i) times.push_back(from + (key - from) * i / pieces);
    times.push_back(key);
  }
  return times;
}

Rigid3 cam_from_world(const std::vector<const Node*>& chain, double time, bool z_up) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (const Node* node : chain) m = node->at(time) * m;
  Eigen::Matrix3d axes = m.topLeftCorner<3, 3>();
  for (int i = 0; i < 3; ++i) axes.col(i).normalize();
  Vector3d center = m.topRightCorner<3, 1>();
  if (!axes.allFinite() || !(center.norm() < kFarthest) || !((axes.transpose() * axes).isIdentity(kSquare)) ||
      axes.determinant() < 0)
    refuse(text("the camera is sheared, mirrored, of no size or nowhere at ", time, " s"));
  if (!z_up) {  // (x, y, z) there is (x, -z, y) here
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()).toRotationMatrix();
    axes = turn * axes;
    center = turn * center;
  }
  axes.col(1) *= -1, axes.col(2) *= -1;  // it looks along -z, y upwards
  return Rigid3{Quaterniond(axes).normalized(), center}.inverse();
}

// What to_gltf() adds for us; null where it does not fit so many keys, or is not there.
json extras_of(const GltfFile& file, std::size_t keys) {
  for (const json& animation : file.list("animations")) {
    if (!animation.contains("extras") || !animation["extras"].is_object()) continue;
    json ours = animation["extras"].value("floatstage", json());
    const bool fit = ours.is_object() && std::all_of(ours.begin(), ours.end(), [&](const json& values) {
                       return values.is_array() && values.size() == keys;
                     });
    if (fit) return ours;
  }
  return {};
}

void add_extras(const json& ours, std::vector<FilmCamera>& cameras) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (ours.contains("fov_y")) cameras[i].fov_y = ours["fov_y"][i];
    if (ours.contains("distance")) cameras[i].distance = ours["distance"][i];
    if (ours.contains("take_time")) cameras[i].take_time = ours["take_time"][i];
  }
}

struct Chosen {
  std::vector<const Node*> chain;
  const json* lens = nullptr;
};

Result<Chosen> choose(const GltfFile& file, const std::vector<Node>& nodes, std::string_view wanted,
                      const std::string& name) {
  std::vector<Chosen> fit;
  std::string all;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].camera < 0) continue;
    const json& lens = file.list("cameras").at(static_cast<std::size_t>(nodes[i].camera));
    const std::string lens_name = lens.value("name", "");
    all += text(all.empty() ? "" : ", ", nodes[i].name.empty() ? lens_name : nodes[i].name);
    Chosen chosen{chain_of(nodes, i), &lens};
    if (wanted.empty() ? moves(chosen.chain) : nodes[i].name == wanted || lens_name == wanted)
      fit.push_back(std::move(chosen));
  }
  if (all.empty()) return fail(ErrorCode::NotFound, text(name, ": there is no camera in it"));
  if (fit.empty() && !wanted.empty())
    return fail(ErrorCode::NotFound, text(name, ": there is no camera '", wanted, "'; there are: ", all));
  if (fit.empty())
    return fail(ErrorCode::InvalidArgument,
                text(name, ": no camera of it moves (", all, "); a path needs two times"));
  if (fit.size() > 1)
    return fail(ErrorCode::InvalidArgument,
                text(name, ": several cameras move; name one with --camera: ", all));
  return std::move(fit.front());
}

Result<std::vector<FilmCamera>> read(const GltfFile& file, const std::string& name, bool z_up,
                                     std::string_view wanted) {
  std::vector<Node> nodes = nodes_of(file);
  for (const json& animation : file.list("animations"))
    for (const json& channel : animation.at("channels")) {
      const json& target = channel.at("target");
      const std::string path = target.at("path");
      if (!target.contains("node") || (path != "translation" && path != "rotation" && path != "scale"))
        continue;
      Node& node = nodes.at(target["node"].get<std::uint32_t>());
      const json& sampler = animation.at("samplers").at(channel.at("sampler").get<std::uint32_t>());
      // Of several animations the first counts.
      if (!node.curves.contains(path)) node.curves[path] = curve_of(file, sampler, path);
    }
  const Result<Chosen> chosen = choose(file, nodes, wanted, name);
  if (!chosen) return forward(chosen);
  if (chosen->lens->value("type", "") != "perspective")
    return fail(ErrorCode::Unsupported, text(name, ": the camera is not a perspective one"));
  const double fov = chosen->lens->at("perspective").at("yfov").get<double>() * 180 / std::numbers::pi;
  std::vector<FilmCamera> cameras;
  const std::vector<double> keys = key_times(chosen->chain);
  const json ours = extras_of(file, keys.size());
  for (const double time : ours.is_null() ? densely(keys) : keys)  // ours are a spline's
    cameras.push_back({time, cam_from_world(chosen->chain, time, z_up), fov, {}, {}});
  if (!ours.is_null()) add_extras(ours, cameras);
  return cameras;
}

}  // namespace

Result<std::vector<FilmCamera>> parse_gltf_camera(std::string_view bytes, std::string_view name,
                                                  const std::filesystem::path& folder, bool z_up,
                                                  std::string_view camera) {
  try {
    return read(GltfFile(bytes, name, folder), std::string(name), z_up, camera);
  } catch (const std::invalid_argument& e) {
    const std::string what = e.what();  // that of its JSON names it already
    return fail(ErrorCode::BadData, what.starts_with(name) ? what : text(name, ": ", what));
  } catch (const json::exception& e) {
    return fail(ErrorCode::BadData, text(name, ": it is no glTF 2.0 as Khronos describes it: ", e.what()));
  } catch (const std::out_of_range&) {
    return fail(ErrorCode::BadData, text(name, ": something is named by a number that there is not"));
  }
}

}  // namespace floatstage::pipeline
