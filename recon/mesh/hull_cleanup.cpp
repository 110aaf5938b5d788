#include "recon/mesh/hull_cleanup.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/text.h"
#include "recon/mask_distance.h"
#include "recon/mesh/crossings.h"
#include "recon/mesh/decimate.h"
#include "recon/mesh/half_edges.h"
#include "recon/mesh/hull_smooth.h"
#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_silhouettes.h"
#include "recon/mesh/reprojection_bound.h"
#include "recon/mesh/slivers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using OpenMesh::FaceHandle;
using OpenMesh::VertexHandle;

/// A hull on its half-edges, with what its triangles and vertices have to remember.
class CleanedMesh {
 public:
  /// Absent for a mesh that is no manifold.
  static std::optional<CleanedMesh> from(const Mesh& mesh, std::span<const HullFaceSource> sources) {
    CleanedMesh out;
    out.edges.add_property(out.normals);
    out.edges.add_property(out.source);
    out.edges.add_property(out.name);
    for (const Eigen::Vector3f& p : mesh.positions) {
      const VertexHandle v = out.edges.add_vertex(to_openmesh(p.cast<double>()));
      out.edges.property(out.name, v) = static_cast<std::size_t>(v.idx());
    }
    const std::vector<Vector3d> normals = face_normals(mesh, sources);
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const auto corner = [&](std::size_t k) {
        return VertexHandle(static_cast<int>(mesh.triangles[3 * t + k]));
      };
      const FaceHandle face = out.edges.add_face(corner(0), corner(1), corner(2));
      if (!face.is_valid()) return std::nullopt;
      out.edges.property(out.normals, face) = to_openmesh(normals[t]);
      if (!sources.empty()) out.edges.property(out.source, face) = sources[t];
    }
    request_deletion(out.edges);
    return out;
  }

  std::vector<std::size_t> names() const {
    std::vector<std::size_t> all;
    for (const VertexHandle v : edges.all_vertices()) all.push_back(edges.property(name, v));
    return all;
  }

  void write(Mesh& mesh, std::vector<HullFaceSource>& sources) {
    edges.garbage_collection();
    mesh.positions.clear();
    mesh.triangles.clear();
    for (const VertexHandle v : edges.all_vertices()) mesh.positions.push_back(place(edges, v).cast<float>());
    const bool sourced = !sources.empty();
    sources.clear();
    for (const FaceHandle f : edges.all_faces()) {
      for (const VertexHandle v : edges.fv_range(f))
        mesh.triangles.push_back(static_cast<std::uint32_t>(v.idx()));
      if (sourced) sources.push_back(edges.property(source, f));
    }
  }

  HalfEdges edges;
  FaceNormals normals;
  OpenMesh::FPropHandleT<HullFaceSource> source;
  OpenMesh::VPropHandleT<std::size_t>
      name;  ///< the vertex's index before anything was done: ReprojectionBound's name for it

 private:
  /// All triangles of one contour edge lie in one plane: together they know its normal, slivers or not.
  static std::vector<Vector3d> face_normals(const Mesh& mesh, std::span<const HullFaceSource> sources) {
    std::vector<Vector3d> normals(mesh.triangle_count());
    for (std::size_t t = 0; t < normals.size(); ++t) {
      const auto corner = [&](std::size_t k) -> Vector3d {
        return mesh.positions[mesh.triangles[3 * t + k]].cast<double>();
      };
      normals[t] = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    }
    if (!sources.empty()) {
      std::vector<std::size_t> order(normals.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      const auto key = [&](std::size_t t) { return std::pair(sources[t].camera, sources[t].contour_edge); };
      std::stable_sort(order.begin(), order.end(),
                       [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
      for (std::size_t first = 0, last; first < order.size(); first = last) {
        Vector3d sum = Vector3d::Zero();
        for (last = first; last < order.size() && key(order[last]) == key(order[first]); ++last)
          sum += normals[order[last]];
        for (std::size_t k = first; k < last; ++k) normals[order[k]] = sum;
      }
    }
    for (Vector3d& n : normals) n.stableNormalize();
    return normals;
  }
};

std::vector<Matte> silhouettes(const Rig& rig, std::span<const Matte> mattes, const Mesh& mesh, int threads) {
  std::vector<Matte> masks(mattes.size());
  const MeshSilhouettes of_mesh(mesh);
  parallel_for(mattes.size(), threads, [&](std::size_t c) {
    if (!mattes[c].empty()) masks[c] = of_mesh.of(rig.cameras[c]);
  });
  return masks;
}

std::vector<double> ious(std::span<const Matte> masks, std::span<const Matte> mattes) {
  std::vector<double> out(mattes.size(), 0);
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (!mattes[c].empty()) out[c] = iou(masks[c], mattes[c]);
  return out;
}

std::vector<std::array<std::uint32_t, 3>> triples(const Mesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    out.push_back({mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]});
  return out;
}

/// Where smoothing made triangles pass through each other, their vertices go back to where they were.
void undo_new_crossings(Mesh& mesh, const std::vector<Eigen::Vector3f>& start, int threads) {
  const auto triangles = triples(mesh);
  const auto pairs = [&](const std::vector<Eigen::Vector3f>& positions) {
    std::vector<Vector3d> doubles;
    for (const Eigen::Vector3f& p : positions) doubles.push_back(p.cast<double>());
    return crossing_pairs(doubles, triangles, 64, threads);
  };
  const auto before = pairs(start);
  for (int round = 0; round < 8; ++round) {
    bool undone = false;
    for (const auto& pair : pairs(mesh.positions)) {
      if (std::binary_search(before.begin(), before.end(), pair)) continue;
      for (const std::uint32_t triangle : {pair.first, pair.second})
        for (const std::uint32_t v : triangles[triangle]) {
          undone = undone || mesh.positions[v] != start[v];
          mesh.positions[v] = start[v];
        }
    }
    if (!undone) return;
  }
}

/// Smooths, and holds back until no silhouette loses more than it may. The px that it was held to; 0: given
/// up.
double smooth(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
              ReprojectionBound& bound, CleanedMesh& cleaned) {
  constexpr int kTries = 5;
  const MeshCleanup& cleanup = options.cleanup;
  const std::vector<std::size_t> names = cleaned.names();
  Mesh start;
  std::vector<HullFaceSource> none;
  cleaned.write(start, none);
  const std::vector<double> iou_before = ious(silhouettes(rig, mattes, start, options.threads), mattes);
  std::vector<OpenMesh::Vec3d> planes;
  for (const FaceHandle f : cleaned.edges.all_faces())
    planes.push_back(cleaned.edges.property(cleaned.normals, f));
  double limit = cleanup.largest_move;
  for (int attempt = 0; attempt < kTries; ++attempt, limit /= 2) {
    bound.set_limit(limit);
    for (std::size_t v = 0; v < names.size(); ++v)
      cleaned.edges.set_point(VertexHandle(static_cast<int>(v)),
                              to_openmesh(start.positions[v].cast<double>()));
    for (std::size_t f = 0; f < planes.size(); ++f)
      cleaned.edges.property(cleaned.normals, FaceHandle(static_cast<int>(f))) = planes[f];
    smooth_within(cleaned.edges, cleaned.normals, bound, names, cleanup.smooth, options.threads);
    Mesh smoothed;
    cleaned.write(smoothed, none);
    undo_new_crossings(smoothed, start.positions, options.threads);
    const std::vector<double> now = ious(silhouettes(rig, mattes, smoothed, options.threads), mattes);
    bool kept = true;
    for (std::size_t c = 0; c < now.size(); ++c)
      kept = kept && now[c] >= iou_before[c] - cleanup.largest_loss;
    const std::vector<Eigen::Vector3f>& best = kept ? smoothed.positions : start.positions;
    for (std::size_t v = 0; v < names.size(); ++v)
      cleaned.edges.set_point(VertexHandle(static_cast<int>(v)), to_openmesh(best[v].cast<double>()));
    if (kept) return limit;
  }
  return 0;
}

}  // namespace

void clean_up_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                   HullReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  const MeshCleanup& cleanup = options.cleanup;
  std::optional<CleanedMesh> cleaned = CleanedMesh::from(report.mesh, report.sources);
  if (!cleaned) {
    report.remarks.push_back("the hull is no manifold: it was left as it is");
    return;
  }
  MeshCleanupReport done;
  done.triangles_before = report.mesh.triangle_count();
  done.slivers_before = count_slivers(cleaned->edges);
  std::vector<Vector3d> positions;
  for (const Eigen::Vector3f& p : report.mesh.positions) positions.push_back(p.cast<double>());
  ReprojectionBound bound(rig, mattes, positions, cleanup.largest_move);
  const std::vector<Matte> before = silhouettes(rig, mattes, report.mesh, options.threads);
  const std::vector<double> iou_before = ious(before, mattes);

  if (cleanup.collapse_slivers) remove_slivers(cleaned->edges, cleaned->normals, bound);
  cleaned->edges.garbage_collection();
  if (cleanup.triangles > 0)
    decimate(cleaned->edges, cleaned->normals, static_cast<std::size_t>(cleanup.triangles));
  cleaned->edges.garbage_collection();
  if (cleanup.smooth > 0) done.smoothed_within = smooth(rig, mattes, options, bound, *cleaned);
  done.vertex_move.assign(mattes.size(), 0);
  for (const VertexHandle v : cleaned->edges.all_vertices())
    bound.measure(cleaned->edges.property(cleaned->name, v), place(cleaned->edges, v), done.vertex_move);

  Mesh mesh;
  std::vector<HullFaceSource> sources = report.sources;
  cleaned->write(mesh, sources);
  const MeshCheck check = check_mesh(mesh);
  if (!(check.watertight && check.manifold && check.oriented)) {
    report.remarks.push_back(
        text("cleanup would have left a mesh that is ", check.summary(), ": it was left as it is"));
    return;
  }
  done.triangles_after = mesh.triangle_count();
  done.slivers_after = count_slivers(cleaned->edges);
  if (cleanup.triangles > 0 && done.triangles_after > static_cast<std::size_t>(cleanup.triangles))
    report.remarks.push_back(
        text("decimation stopped at ", done.triangles_after, " triangles: no further one can go"));
  if (cleanup.smooth > 0 && done.smoothed_within == 0)
    report.remarks.push_back("smoothing was given up: the silhouettes would have suffered");
  const std::vector<Matte> after = silhouettes(rig, mattes, mesh, options.threads);
  done.silhouette_shift.assign(mattes.size(), 0);
  parallel_for(mattes.size(), options.threads, [&](std::size_t c) {
    if (!mattes[c].empty()) done.silhouette_shift[c] = mask_distance(before[c], after[c]);
  });
  done.iou_loss = ious(after, mattes);
  for (std::size_t c = 0; c < mattes.size(); ++c) done.iou_loss[c] = iou_before[c] - done.iou_loss[c];
  report.mesh = std::move(mesh);
  report.sources = std::move(sources);
  report.volume = signed_volume(report.mesh);
  report.cleanup = std::move(done);
  report.timings.cleanup = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace floatstage::recon
