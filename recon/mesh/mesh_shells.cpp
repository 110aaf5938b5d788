// Method:  shells are kept by the radius of the largest ball that can be in them, in pixels
// Paper:   none: for a convex body r <= 3 V / A, since the cones over its faces from the ball's centre fill
// it ADR:     0176

#include "recon/mesh/mesh_shells.h"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr double kMargin = 1;  // px: what lies at the very border of a picture is not seen

bool sees(const RigCamera& camera, const Vector3d& point) {
  const auto pixel = project(camera.model, camera.cam_from_world * point);
  return pixel && pixel->x() > kMargin && pixel->y() > kMargin && pixel->x() < camera.model.width - kMargin &&
         pixel->y() < camera.model.height - kMargin;
}

/// Pixels a metre at a point, in the camera that sees it smallest; 0 when none sees it.
double smallest_scale(const Rig& rig, const HullInput& input, const Vector3d& point) {
  double scale = 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    if (!input.knows(c) || !sees(camera, point)) continue;
    const double here = std::min(camera.model.fx, camera.model.fy) / (camera.cam_from_world * point).z();
    scale = scale > 0 ? std::min(scale, here) : here;
  }
  return scale;
}

}  // namespace

std::uint32_t ShellFilter::root_of(std::uint32_t vertex) {
  while (root_[vertex] != vertex) vertex = root_[vertex] = root_[root_[vertex]];
  return vertex;
}

void ShellFilter::find_shells(const Mesh& mesh) {
  root_.resize(mesh.positions.size());
  std::iota(root_.begin(), root_.end(), 0u);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    root_[root_of(mesh.triangles[t])] = root_of(mesh.triangles[t + 1]);
    root_[root_of(mesh.triangles[t + 1])] = root_of(mesh.triangles[t + 2]);
  }
  shells_.clear();
  shell_of_.assign(root_.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t root = root_of(mesh.triangles[t]);
    if (shell_of_[root] < 0) {
      shell_of_[root] = static_cast<int>(shells_.size());
      shells_.emplace_back();
    }
    Shell& shell = shells_[static_cast<std::size_t>(shell_of_[root])];
    // From a vertex of its own: a small shell far from the origin would lose its volume to rounding.
    const Vector3d origin = mesh.positions[root].cast<double>();
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.positions[mesh.triangles[t + k]].cast<double>();
      shell.box.extend(p[k]);
      shell_of_[mesh.triangles[t + k]] = shell_of_[root];
    }
    shell.volume += (p[0] - origin).dot((p[1] - origin).cross(p[2] - origin)) / 6;
    shell.area += (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2;
  }
}

void ShellFilter::count_witnesses(const Rig& rig, const HullInput& input, const Mesh& mesh, int enough) {
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (shell_of_[v] < 0) continue;
    Shell& shell = shells_[static_cast<std::size_t>(shell_of_[v])];
    if (shell.witnesses >= enough) continue;
    int count = 0;
    for (std::size_t c = 0; c < rig.cameras.size() && count < enough; ++c)
      count += input.knows(c) && sees(rig.cameras[c], mesh.positions[v].cast<double>());
    shell.witnesses = std::max(shell.witnesses, count);
  }
}

void ShellFilter::keep_those_within(const StageFinder& stage, const Mesh& mesh) {
  for (Shell& shell : shells_) shell.within = false;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (shell_of_[v] < 0) continue;
    Shell& shell = shells_[static_cast<std::size_t>(shell_of_[v])];
    shell.within = shell.within || stage.holds(mesh.positions[v].cast<double>());
  }
  for (Shell& shell : shells_) shell.keep = shell.keep && shell.within;
}

void ShellFilter::drop_orphaned_cavities() {
  for (Shell& cavity : shells_) {
    if (cavity.volume >= 0 || !cavity.keep) continue;
    cavity.keep = std::any_of(shells_.begin(), shells_.end(), [&](const Shell& around) {
      return around.keep && around.volume > 0 && around.box.contains(cavity.box);
    });
  }
}

void ShellFilter::compact(Mesh& mesh, std::vector<HullFaceSource>& sources) {
  std::uint32_t vertices = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (shell_of_[v] < 0 || !shells_[static_cast<std::size_t>(shell_of_[v])].keep) continue;
    mesh.positions[vertices] = mesh.positions[v];
    root_[v] = vertices++;
  }
  std::size_t triangles = 0;
  for (std::size_t t = 0; t < mesh.triangles.size() / 3; ++t) {
    if (!shells_[static_cast<std::size_t>(shell_of_[mesh.triangles[3 * t]])].keep) continue;
    for (std::size_t k = 0; k < 3; ++k) mesh.triangles[3 * triangles + k] = root_[mesh.triangles[3 * t + k]];
    if (!sources.empty()) sources[triangles] = sources[t];
    ++triangles;
  }
  mesh.positions.resize(vertices);
  mesh.triangles.resize(3 * triangles);
  if (!sources.empty()) sources.resize(triangles);
}

ShellCount ShellFilter::apply(const Rig& rig, const HullInput& input, const ShellRules& rules, Mesh& mesh,
                              std::vector<HullFaceSource>& sources) {
  ShellCount count;
  find_shells(mesh);
  if (rules.cameras > 0) {
    count_witnesses(rig, input, mesh, rules.cameras);
    for (Shell& shell : shells_) shell.keep = shell.witnesses >= rules.cameras;
  }
  if (rules.stage) keep_those_within(*rules.stage, mesh);
  if (rules.uncertainty > 0 && shells_.size() > 1) {
    const auto largest = std::max_element(shells_.begin(), shells_.end(),
                                          [](const Shell& a, const Shell& b) { return a.volume < b.volume; });
    for (Shell& shell : shells_) {
      if (!shell.keep || &shell == &*largest) continue;
      const double radius = shell.area > 0 ? 3 * std::abs(shell.volume) / shell.area : 0;
      if (radius * smallest_scale(rig, input, shell.box.center()) >= rules.uncertainty) continue;
      shell.keep = false;
      ++count.crumbs;
      count.crumb_volume += shell.volume;
    }
  }
  drop_orphaned_cavities();
  if (std::any_of(shells_.begin(), shells_.end(), [](const Shell& shell) { return !shell.keep; }))
    compact(mesh, sources);
  return count;
}

}  // namespace floatstage::recon
