// Method:  faces joined by the names of their corners, checked edge by edge, cut into triangles
// Paper:   none: in a closed oriented surface every edge has its reverse and every vertex one fan
// Differs: the volume comes from the faces, before there are
//          triangles; shared diagonals are found
// ADR:     0070, 0075

#include "recon/exact/exact_mesh.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/random.h"

namespace floatstage::recon {
namespace {

constexpr int kSlots = 6;  // edges that leave a vertex: three, or six where a majority of views changes
enum Kind : std::uint8_t { kHitVertex, kTripleVertex, kApexVertex };

}  // namespace

void HullPolygons::clear() {
  positions.clear();
  corners.clear();
  polygon_start.assign(1, 0);
  faces.clear();
  triangles.clear();
  triangle_face.clear();
  volume = 0;
  unmatched = irregular = 0;
}

std::int32_t MeshWelder::number_of(VertexName name, const FaceCorner& corner, const FaceOutput::Face& face,
                                   const ArrangementInput& input, HullPolygons& out) {
  if (name.is_hit()) return of_hit_[name.hit_id()];
  const std::uint64_t key = name.bits();
  std::size_t at = mix(key) & (keys_.size() - 1);
  while (keys_[at] != 0) {
    if (keys_[at] == key) return values_[at];
    at = (at + 1) & (keys_.size() - 1);
  }
  keys_[at] = key;
  values_[at] = static_cast<std::int32_t>(out.positions.size());
  ++named_;
  const ConeView& view = input.views[face.view];
  if (name.is_apex()) {
    out.positions.push_back(view.center);
    kind_.push_back(kApexVertex);
  } else {
    const Eigen::Vector3d &da = view.rays[face.edge], &db = view.rays[view.next[face.edge]];
    out.positions.emplace_back(view.center + ((1 - corner.s) * da + corner.s * db) / corner.w);
    kind_.push_back(kTripleVertex);
  }
  return values_[at];
}

void MeshWelder::place_hits(const ArrangementInput& input, HullPolygons& out) {
  of_hit_.assign(static_cast<std::size_t>(input.pairs->hit_count()), -1);
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const ConeView& view = input.views[v];
    for (std::size_t ray = 0; ray + 1 < input.rays->start[v].size(); ++ray) {
      for (int k = input.rays->start[v][ray]; k < input.rays->start[v][ray + 1]; ++k) {
        const RayInterval& interval = input.rays->of_view[v][k];
        const auto add = [&](std::int32_t id, double w) {
          if (id == RayInterval::kApex || of_hit_[id] >= 0) return;
          of_hit_[id] = static_cast<std::int32_t>(out.positions.size());
          out.positions.emplace_back(view.center + view.rays[ray] / w);
          kind_.push_back(kHitVertex);
        };
        add(interval.low, interval.w_low);
        add(interval.high, interval.w_high);
      }
    }
  }
}

void MeshWelder::note_face(std::int32_t vertex, std::int32_t face) {
  if (kind_[vertex] == kApexVertex) return;
  std::int32_t* of = &faces_of_[kFaces * vertex];
  for (int k = 0; k < kFaces && of[k] != face; ++k) {
    if (of[k] >= 0) continue;
    of[k] = face;
    break;
  }
}

bool MeshWelder::add_face(const FaceOutput& part, std::size_t f, const ArrangementInput& input,
                          HullPolygons& out) {
  const FaceOutput::Face& face = part.faces[f];
  const int last = f + 1 < part.faces.size() ? part.faces[f + 1].first_polygon
                                             : static_cast<int>(part.polygon_start.size()) - 1;
  out.faces.push_back({face.view, face.edge, static_cast<std::int32_t>(out.polygon_start.size()) - 1});
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (int p = face.first_polygon; p < last; ++p) {
    const std::size_t first = out.corners.size();
    for (int c = part.polygon_start[p]; c < part.polygon_start[p + 1]; ++c) {
      const std::int32_t number = number_of(part.corners[c].name, part.corners[c], face, input, out);
      if (number < 0) return false;
      note_face(number, static_cast<std::int32_t>(out.faces.size()) - 1);
      out.corners.push_back(number);
    }
    out.polygon_start.push_back(static_cast<std::int32_t>(out.corners.size()));
    const Eigen::Vector3d origin = out.positions[out.corners[first]];
    for (std::size_t k = first + 1; k + 1 < out.corners.size(); ++k) {
      area += (out.positions[out.corners[k]] - origin).cross(out.positions[out.corners[k + 1]] - origin);
    }
  }
  // The face's plane passes through the camera's centre.
  out.volume += (input.views[face.view].center - input.views[0].center).dot(area) / 6;
  return true;
}

void MeshWelder::weld(const ArrangementInput& input, std::span<const FaceOutput> parts, HullPolygons& out) {
  out.clear();
  kind_.clear();
  place_hits(input, out);
  std::size_t corner_count = 0;
  for (const FaceOutput& part : parts) corner_count += part.corners.size();
  std::size_t capacity = 1024;
  while (capacity < corner_count) capacity *= 2;
  keys_.assign(capacity, 0);
  values_.resize(capacity);
  named_ = 0;
  faces_of_.assign(kFaces * (out.positions.size() + corner_count), -1);
  out.corners.reserve(corner_count);
  for (const FaceOutput& part : parts)
    for (std::size_t f = 0; f < part.faces.size(); ++f)
      if (!add_face(part, f, input, out)) {
        ++out.unmatched;  // the face uses a hit that its ray does not know as a vertex
        return;
      }
  check(input, out);
}

void MeshWelder::check(const ArrangementInput& input, HullPolygons& out) {
  const std::size_t count = out.positions.size();
  out_edges_.resize(count * kSlots);
  degree_.assign(count, 0);
  std::vector<std::pair<std::int32_t, std::int32_t>> from_apex, to_apex;
  const auto each_edge = [&](const auto& visit) {
    for (std::size_t p = 0; p + 1 < out.polygon_start.size(); ++p) {
      const std::int32_t begin = out.polygon_start[p], end = out.polygon_start[p + 1];
      for (std::int32_t c = begin; c < end; ++c)
        visit(out.corners[c], out.corners[c + 1 < end ? c + 1 : begin]);
    }
  };
  each_edge([&](std::int32_t u, std::int32_t v) {
    if (kind_[u] == kApexVertex) {
      from_apex.emplace_back(u, v);
    } else if (degree_[u] == kSlots) {
      ++out.irregular;
    } else {
      out_edges_[u * kSlots + degree_[u]++] = v;
    }
  });
  each_edge([&](std::int32_t u, std::int32_t v) {
    if (kind_[v] == kApexVertex) {
      to_apex.emplace_back(v, u);
      return;
    }
    const std::int32_t* edges = &out_edges_[v * kSlots];
    if (std::count(edges, edges + degree_[v], u) != 1) ++out.unmatched;
  });
  std::sort(from_apex.begin(), from_apex.end());
  std::sort(to_apex.begin(), to_apex.end());
  if (from_apex != to_apex) ++out.unmatched;
  const bool strict = input.votes.strict;
  for (std::size_t v = 0; v < count; ++v) {
    // Three edges in and out of a vertex of a closed surface cannot be anything but one fan.
    const bool regular = kind_[v] == kApexVertex || degree_[v] == 3 ||
                         (!strict && kind_[v] == kTripleVertex && degree_[v] == 6);
    out.irregular += !regular;
  }
}

bool MeshWelder::share_another_face(std::int32_t u, std::int32_t v, std::int32_t face) const {
  const std::int32_t *of_u = &faces_of_[kFaces * u], *of_v = &faces_of_[kFaces * v];
  for (int k = 0; k < kFaces; ++k) {
    if (of_u[k] < 0 || of_u[k] == face) continue;
    if (of_u[k] == of_v[0] || of_u[k] == of_v[1] || of_u[k] == of_v[2]) return true;
  }
  return false;
}

// Cuts a face (polygons first … last - 1 of a part) into triangles of its own corners, in scratch.local.
void MeshWelder::cut_face(const FaceOutput& part, int first, int last, Scratch& scratch) {
  const int begin = part.polygon_start[first], end = part.polygon_start[last];
  scratch.points.clear();
  scratch.ends.clear();
  double highest = 0;
  for (int c = begin; c < end; ++c) {
    scratch.points.emplace_back(part.corners[c].s, part.corners[c].w);
    if (std::isfinite(part.corners[c].w)) highest = std::max(highest, part.corners[c].w);
  }
  for (auto& point : scratch.points) {
    if (!std::isfinite(point.y())) point = {0.5, 1e6 * (highest + 1)};  // the camera's centre
  }
  for (int p = first; p < last; ++p) scratch.ends.push_back(part.polygon_start[p + 1] - begin);
  scratch.local.clear();
  scratch.cutter.cut(scratch.points, scratch.ends, scratch.local);
}

// Whether two corners are neighbours on one of the face's own polygons.
bool MeshWelder::adjacent(const Scratch& scratch, std::int32_t a, std::int32_t b) {
  const auto next = std::upper_bound(scratch.ends.begin(), scratch.ends.end(), a);
  const std::int32_t ring_begin = next == scratch.ends.begin() ? 0 : *(next - 1), ring_end = *next;
  if (b < ring_begin || b >= ring_end) return false;
  return std::abs(a - b) == 1 || std::abs(a - b) == ring_end - ring_begin - 1;
}

// Notes the new edges of a face's triangles that another face could have made too: only vertices with another
// face in common can be joined twice. Clipping an ear leaves its third side.
void MeshWelder::note_risky(FaceOutput& part, std::size_t first_triangle, bool ears_only, std::int32_t number,
                            Scratch& scratch) const {
  const std::size_t triangles = part.triangles.size() - (ears_only ? 3 : 0);
  const auto first_risky = static_cast<std::ptrdiff_t>(part.risky.size());
  scratch.within.clear();
  for (std::size_t t = first_triangle; t < triangles; t += 3) {
    for (std::size_t k = ears_only ? 2 : 0; k < 3; ++k) {
      const std::int32_t u = static_cast<std::int32_t>(part.triangles[t + k]),
                         v = static_cast<std::int32_t>(part.triangles[t + (k + 1) % 3]);
      if (!ears_only) {
        const std::int32_t *ends = &scratch.local[t - first_triangle], a = ends[k], b = ends[(k + 1) % 3];
        scratch.within.emplace_back(a, b);
        if (adjacent(scratch, a, b)) continue;
      }
      if (!share_another_face(u, v, number)) continue;
      const std::int32_t* edges = &out_edges_[static_cast<std::size_t>(u) * kSlots];
      const std::int32_t* back = &out_edges_[static_cast<std::size_t>(v) * kSlots];
      part.doubled |= std::find(edges, edges + degree_[u], v) != edges + degree_[u] ||
                      std::find(back, back + degree_[v], u) != back + degree_[v];
      const std::uint64_t low = static_cast<std::uint64_t>(std::min(u, v)),
                          high = static_cast<std::uint64_t>(std::max(u, v));
      part.risky.push_back(low << 32 | high);
    }
  }
  // Bridges pass points twice, so rounding can join two of them twice within one face.
  std::sort(scratch.within.begin(), scratch.within.end());
  part.doubled |= std::adjacent_find(scratch.within.begin(), scratch.within.end()) != scratch.within.end();
  std::sort(part.risky.begin() + first_risky, part.risky.end());
  part.risky.erase(std::unique(part.risky.begin() + first_risky, part.risky.end()), part.risky.end());
}

void MeshWelder::triangulate_part(FaceOutput& part, PartStart start, const HullPolygons& hull,
                                  Scratch& scratch) const {
  part.triangles.clear();
  part.triangle_face.clear();
  part.risky.clear();
  part.doubled = false;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const std::int32_t number = start.face + static_cast<std::int32_t>(f);
    const int first = part.faces[f].first_polygon;
    const int last = f + 1 < part.faces.size() ? part.faces[f + 1].first_polygon
                                               : static_cast<int>(part.polygon_start.size()) - 1;
    cut_face(part, first, last, scratch);
    const std::int32_t* corners = hull.corners.data() + start.corner + part.polygon_start[first];
    const std::size_t first_triangle = part.triangles.size();
    for (const std::int32_t k : scratch.local)
      part.triangles.push_back(static_cast<std::uint32_t>(corners[k]));
    part.triangle_face.insert(part.triangle_face.end(), scratch.local.size() / 3, number);
    note_risky(part, first_triangle, last == first + 1, number, scratch);
  }
}

bool MeshWelder::triangulate(std::span<FaceOutput> parts, int threads, HullPolygons& out) {
  part_start_.clear();
  PartStart start{0, 0};
  for (const FaceOutput& part : parts) {
    part_start_.push_back(start);
    start.corner += static_cast<std::int32_t>(part.corners.size());
    start.face += static_cast<std::int32_t>(part.faces.size());
  }
  const std::size_t stretches = threads == 1 ? 1 : std::min<std::size_t>(parts.size(), 16);
  scratch_.resize(std::max(scratch_.size(), stretches));
  parallel_for(stretches, threads, [&](std::size_t k) {
    for (std::size_t p = parts.size() * k / stretches; p < parts.size() * (k + 1) / stretches; ++p)
      triangulate_part(parts[p], part_start_[p], out, scratch_[k]);
  });
  risky_.clear();
  bool doubled = false;
  for (const FaceOutput& part : parts) {
    doubled |= part.doubled;
    out.triangles.insert(out.triangles.end(), part.triangles.begin(), part.triangles.end());
    out.triangle_face.insert(out.triangle_face.end(), part.triangle_face.begin(), part.triangle_face.end());
    risky_.insert(risky_.end(), part.risky.begin(), part.risky.end());
  }
  std::sort(risky_.begin(), risky_.end());
  return !doubled && std::adjacent_find(risky_.begin(), risky_.end()) == risky_.end();
}

}  // namespace floatstage::recon
