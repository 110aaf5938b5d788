// Method:  normals are averaged with those that nearly agree; vertices follow them
// Paper:   X. Sun and others, "Fast and effective feature-preserving mesh denoising", 2007
// Differs: slivers take the normals of the hull's faces, nothing
//          folds, vertices stay within their pixels
// ADR:     0078

#include "recon/mesh/hull_smooth.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "core/parallel.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using OpenMesh::FaceHandle;
using OpenMesh::VertexHandle;

constexpr int kSteps = 4;                // of the vertices, after each filtering of the normals
constexpr double kAgreement = 0.5;       // cosine from which neighbours count
constexpr std::size_t kMostFaces = 256;  // around a vertex that is moved
constexpr std::size_t kBatch = 256;      // elements a thread takes at once

struct Plane {
  Vector3d normal, center;
  double area;
};

FaceHandle face_at(std::size_t f) { return FaceHandle(static_cast<int>(f)); }
VertexHandle vertex_at(std::size_t v) { return VertexHandle(static_cast<int>(v)); }

template <class Body>
void in_batches(std::size_t count, int threads, const Body& body) {
  parallel_for((count + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
    for (std::size_t i = batch * kBatch; i < std::min(count, (batch + 1) * kBatch); ++i) body(i);
  });
}

Vector3d area_vector(const HalfEdges& mesh, FaceHandle face) {
  Vector3d corner[3];
  std::size_t k = 0;
  for (HalfEdges::ConstFaceVertexIter it = mesh.cfv_iter(face); it.is_valid(); ++it)
    corner[k++] = place(mesh, *it);
  return (corner[1] - corner[0]).cross(corner[2] - corner[0]);
}

Plane plane_of(const HalfEdges& mesh, FaceHandle face, FaceNormals normals) {
  Vector3d center = Vector3d::Zero();
  for (HalfEdges::ConstFaceVertexIter it = mesh.cfv_iter(face); it.is_valid(); ++it)
    center += place(mesh, *it) / 3;
  const Vector3d area = area_vector(mesh, face);
  // A sliver has no normal of its own.
  const Vector3d normal =
      is_sliver(mesh, face) ? to_eigen(mesh.property(normals, face)) : area.stableNormalized();
  return {normal, center, area.norm() / 2};
}

// A triangle's normal among those of all that share a corner with it; neighbours beyond a ridge do not count.
Vector3d filtered(const HalfEdges& mesh, FaceHandle face, std::span<const Plane> planes) {
  const Plane& own = planes[static_cast<std::size_t>(face.idx())];
  Vector3d sum = own.area * own.normal;
  for (HalfEdges::ConstFaceVertexIter v = mesh.cfv_iter(face); v.is_valid(); ++v) {
    for (HalfEdges::ConstVertexFaceIter f = mesh.cvf_iter(*v); f.is_valid(); ++f) {
      const Plane& other = planes[static_cast<std::size_t>((*f).idx())];
      const double agreement = std::max(0.0, own.normal.dot(other.normal) - kAgreement);
      sum += agreement * agreement * other.area * other.normal;
    }
  }
  return sum.norm() > 0 ? sum.normalized() : own.normal;
}

// Towards the planes of the triangles around the vertex, the large ones first.
Vector3d wish(const HalfEdges& mesh, VertexHandle vertex, std::span<const Plane> planes) {
  const Vector3d here = place(mesh, vertex);
  Vector3d sum = Vector3d::Zero();
  double areas = 0;
  for (HalfEdges::ConstVertexFaceIter f = mesh.cvf_iter(vertex); f.is_valid(); ++f) {
    const Plane& plane = planes[static_cast<std::size_t>((*f).idx())];
    sum += plane.area * plane.normal.dot(plane.center - here) * plane.normal;
    areas += plane.area;
  }
  return areas > 0 ? here + sum / areas : here;
}

double cosine(const Vector3d& a, const Vector3d& b) {
  const double norms = a.norm() * b.norm();
  return norms > 0 ? a.dot(b) / norms : 0;
}

// Moves the vertex as far towards `to` as its bound allows, and not at all where a triangle would turn away
// from the normal that it should have: thin ones fold when their corners move each on its own.
void move(HalfEdges& mesh, VertexHandle vertex, const Vector3d& start, const Vector3d& to,
          const ReprojectionBound& bound, std::size_t name, std::span<const Plane> planes) {
  constexpr double kGood = 0.9;  // cosine
  const Vector3d here = place(mesh, vertex);
  double before[kMostFaces];
  std::size_t faces = 0;
  for (HalfEdges::ConstVertexFaceIter f = mesh.cvf_iter(vertex); f.is_valid(); ++f) {
    if (faces == kMostFaces) return;
    before[faces++] = cosine(area_vector(mesh, *f), planes[static_cast<std::size_t>((*f).idx())].normal);
  }
  Vector3d there = bound.nearest_allowed(name, start, to);
  for (int attempt = 0; attempt < 3; ++attempt, there = (here + there) / 2) {
    mesh.set_point(vertex, to_openmesh(there));
    bool fine = attempt == 0 || bound.allows(name, there);
    std::size_t k = 0;
    for (HalfEdges::ConstVertexFaceIter f = mesh.cvf_iter(vertex); fine && f.is_valid(); ++f, ++k) {
      const double after = cosine(area_vector(mesh, *f), planes[static_cast<std::size_t>((*f).idx())].normal);
      fine = after >= std::min(kGood, before[k]);
    }
    if (fine) return;
  }
  mesh.set_point(vertex, to_openmesh(here));
}

}  // namespace

void smooth_within(HalfEdges& mesh, FaceNormals known, const ReprojectionBound& bound,
                   std::span<const std::size_t> names, int rounds, int threads) {
  const std::size_t vertices = mesh.n_vertices(), faces = mesh.n_faces();
  std::vector<Vector3d> start(vertices), normals(faces);
  std::vector<Plane> planes(faces);
  for (std::size_t v = 0; v < vertices; ++v) start[v] = place(mesh, vertex_at(v));
  const auto measure = [&] {
    in_batches(faces, threads, [&](std::size_t f) { planes[f] = plane_of(mesh, face_at(f), known); });
  };
  for (int round = 0; round < rounds; ++round) {
    measure();
    in_batches(faces, threads, [&](std::size_t f) { normals[f] = filtered(mesh, face_at(f), planes); });
    for (std::size_t f = 0; f < faces; ++f) mesh.property(known, face_at(f)) = to_openmesh(normals[f]);
    for (int step = 0; step < kSteps; ++step) {
      if (step > 0) measure();
      for (std::size_t f = 0; f < faces; ++f) planes[f].normal = normals[f];
      // One after the other, so that each sees where its neighbours are now.
      for (std::size_t v = 0; v < vertices; ++v)
        move(mesh, vertex_at(v), start[v], wish(mesh, vertex_at(v), planes), bound, names[v], planes);
    }
  }
}

}  // namespace floatstage::recon
