#include "pipeline/subject.h"

#include <cmath>
#include <numbers>

#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

// Evenly over the sphere, a Fibonacci spiral: neighbours are 11 degrees apart, and between two of them the
// outermost point of a ball is missed by half a hundredth of its radius.
constexpr int kDirections = 400;

std::vector<Eigen::Vector3f> directions() {
  std::vector<Eigen::Vector3f> out;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    out.push_back(Eigen::Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z).cast<float>());
  }
  return out;
}

}  // namespace

void add(const Mesh& mesh, Subject& subject) {
  if (mesh.empty()) return;
  subject.box.extend(bounding_box(mesh).cast<double>());
  for (const Eigen::Vector3f& d : directions()) {
    std::size_t farthest = 0;
    for (std::size_t v = 1; v < mesh.positions.size(); ++v)
      if (mesh.positions[v].dot(d) > mesh.positions[farthest].dot(d)) farthest = v;
    subject.outermost.push_back(mesh.positions[farthest].cast<double>());
  }
}

Result<Subject> find_subject(const capture::TakeReader& take) {
  std::vector<Result<Subject>> frames(static_cast<std::size_t>(take.frame_count()), Subject());
  parallel_for(frames.size(), 0, [&](std::size_t frame) {
    const std::filesystem::path file = take.layout().mesh(static_cast<int>(frame));
    if (!is_there(file)) return;
    const Result<Mesh> mesh = load_ply(file);
    if (mesh)
      add(*mesh, *frames[frame]);
    else
      frames[frame] = forward(mesh);
  });
  Subject all;
  for (const Result<Subject>& of : frames) {
    if (!of) return forward(of);
    if (!of->box.isEmpty()) all.box.extend(of->box);
    all.outermost.insert(all.outermost.end(), of->outermost.begin(), of->outermost.end());
  }
  if (all.box.isEmpty())
    return fail(ErrorCode::NotFound,
                text(take.layout().folder().string(), " has no mesh with a subject; run `floatstage process ",
                     take.layout().folder().string(), "` and look at its mattes"));
  return all;
}

}  // namespace floatstage::pipeline
