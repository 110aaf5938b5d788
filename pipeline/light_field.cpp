// The plane that a light field is drawn on: M. Eisemann, Error-Concealed Image-Based Rendering, §9.3.5
// (Eq. 9.13). Where it differs: nobody knows the scene's depths, so the plane is where the pictures agree
// best. docs/adr/0209-light-fields.md.
#include "pipeline/light_field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>

#include "core/file.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/text.h"
#include "render/camera_grid.h"

namespace floatstage::pipeline {
namespace {

constexpr int kPieces = 12;           // of a plane, along each side
constexpr int kShrink = 4;            // pictures are compared at this part of their size
constexpr int kStride = 4;            // px of the small pictures from one compared point to the next
constexpr double kWidestShare = 0.3;  // of the picture's width: the largest disparity of neighbours looked at
constexpr std::size_t kMostPairs = 12;
constexpr int kFiner = 10;  // steps within a step, the second time

Mesh rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& right, const Eigen::Vector3d& down) {
  Mesh mesh;
  for (int row = 0; row <= kPieces; ++row)
    for (int column = 0; column <= kPieces; ++column)
      mesh.positions.push_back((corner + right * (static_cast<double>(column) / kPieces) +
                                down * (static_cast<double>(row) / kPieces))
                                   .cast<float>());
  auto at = [](int column, int row) { return static_cast<std::uint32_t>(row * (kPieces + 1) + column); };
  for (int row = 0; row < kPieces; ++row)
    for (int column = 0; column < kPieces; ++column) {
      const std::uint32_t a = at(column, row), b = at(column + 1, row), c = at(column + 1, row + 1),
                          d = at(column, row + 1);
      mesh.triangles.insert(mesh.triangles.end(), {a, d, b, b, d, c});  // counter-clockwise for the cameras
    }
  return mesh;
}

// A picture at a part of its size, and the camera that would have taken it.
struct Small {
  CameraModel model;
  Image gray;
};

Small small(const RigCamera& camera, const Image& picture) {
  Small s{pinhole(camera.model), Image(picture.width / kShrink, picture.height / kShrink, 1)};
  s.model.width = s.gray.width, s.model.height = s.gray.height;
  s.model.fx /= kShrink, s.model.fy /= kShrink, s.model.cx /= kShrink, s.model.cy /= kShrink;
  for (int y = 0; y < s.gray.height; ++y)
    for (int x = 0; x < s.gray.width; ++x) {
      int sum = 0;
      for (int v = 0; v < kShrink; ++v)
        for (int u = 0; u < kShrink; ++u) {
          const std::uint8_t* p = picture.at(x * kShrink + u, y * kShrink + v);
          sum += p[0] + 2 * p[1] + p[2];
        }
      *s.gray.at(x, y) = static_cast<std::uint8_t>(sum / (4 * kShrink * kShrink));
    }
  return s;
}

double bilinear(const Image& gray, const Eigen::Vector2d& p) {
  const double x = p.x() - 0.5, y = p.y() - 0.5;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double fx = x - x0, fy = y - y0;
  return (*gray.at(x0, y0) * (1 - fx) + *gray.at(x0 + 1, y0) * fx) * (1 - fy) +
         (*gray.at(x0, y0 + 1) * (1 - fx) + *gray.at(x0 + 1, y0 + 1) * fx) * fy;
}

struct Pair {
  std::size_t a, b;
};

// Mean squared difference of pairs of pictures through a plane across the grid's direction.
double disagreement(const Rig& rig, const render::CameraGrid& grid, const std::vector<Small>& pictures,
                    const std::vector<Pair>& pairs, double distance) {
  std::vector<double> squares(pairs.size(), 0), counts(pairs.size(), 0);
  parallel_for(pairs.size(), 0, [&](std::size_t i) {
    const Small &from = pictures[pairs[i].a], &to = pictures[pairs[i].b];
    const Rigid3 world_from_a = rig.cameras[pairs[i].a].cam_from_world.inverse();
    const Rigid3& b_from_world = rig.cameras[pairs[i].b].cam_from_world;
    const Eigen::Vector3d n = grid.normal();
    for (int y = kStride; y < from.gray.height; y += kStride)
      for (int x = kStride; x < from.gray.width; x += kStride) {
        const std::optional<Eigen::Vector3d> ray = unproject(from.model, {x + 0.5, y + 0.5});
        if (!ray) continue;
        const Eigen::Vector3d way = world_from_a.rotation * *ray;
        const double ahead = distance - n.dot(world_from_a.translation - grid.origin);
        const std::optional<Eigen::Vector2d> p =
            project(to.model, b_from_world * (world_from_a.translation + way * (ahead / n.dot(way))));
        if (!p || p->x() < 1 || p->y() < 1 || p->x() > to.gray.width - 1.5 || p->y() > to.gray.height - 1.5)
          continue;
        const double d = bilinear(to.gray, *p) - *from.gray.at(x, y);
        squares[i] += d * d;
        counts[i] += 1;
      }
  });
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) sum += squares[i], count += counts[i];
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

// Neighbours along rows and columns, spread over the grid.
std::vector<Pair> neighbours(const render::CameraGrid& grid, const std::vector<Image>& pictures) {
  std::vector<Pair> all;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      for (int k = 0; k < 2; ++k) {
        const int r = row + k, c = column + 1 - k;
        if (r >= grid.rows || c >= grid.columns) continue;
        const auto a = static_cast<std::size_t>(
                       grid.cameras[static_cast<std::size_t>(row * grid.columns + column)]),
                   b = static_cast<std::size_t>(grid.cameras[static_cast<std::size_t>(r * grid.columns + c)]);
        if (!pictures[a].empty() && !pictures[b].empty()) all.push_back({a, b});
      }
  const std::size_t stride = (all.size() + kMostPairs - 1) / kMostPairs;
  std::vector<Pair> some;
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(stride, 1)) some.push_back(all[i]);
  return some;
}

}  // namespace

Result<Mesh> plane_before(const Rig& rig, double distance) {
  Eigen::Vector3d forward_mean = Eigen::Vector3d::Zero(), right = forward_mean, middle = forward_mean;
  for (const RigCamera& c : rig.cameras) {
    const Eigen::Matrix3d axes = c.cam_from_world.rotation.toRotationMatrix();
    right += axes.row(0).transpose();
    forward_mean += axes.row(2).transpose();
    middle += c.cam_from_world.center() / static_cast<double>(rig.cameras.size());
  }
  if (forward_mean.norm() < 0.5 * static_cast<double>(rig.cameras.size()))
    return fail(
        ErrorCode::InvalidArgument,
        "the cameras look in all directions: no plane stands before all of them; take another --proxy");
  const Eigen::Vector3d n = forward_mean.normalized();
  right = (right - n * n.dot(right)).normalized();
  const Eigen::Vector3d down = n.cross(right);
  Eigen::AlignedBox2d seen;
  for (const RigCamera& c : rig.cameras) {
    const Eigen::Vector3d from = c.cam_from_world.center() - middle;
    const Eigen::Matrix3d world_from_cam = c.cam_from_world.rotation.toRotationMatrix().transpose();
    for (const Eigen::Vector2d& corner :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(c.model.width, 0), Eigen::Vector2d(0, c.model.height),
          Eigen::Vector2d(c.model.width, c.model.height)}) {
      const std::optional<Eigen::Vector3d> ray = unproject(pinhole(c.model), corner);
      const Eigen::Vector3d direction = world_from_cam * ray.value_or(Eigen::Vector3d::UnitZ());
      const double ahead = distance - n.dot(from), along = n.dot(direction);
      if (!(distance > 0) || !(ahead > 0) || !(along > 0))
        return fail(ErrorCode::InvalidArgument, text("the plane ", distance, " m away is not before camera '",
                                                     c.serial, "' and all that it sees"));
      const Eigen::Vector3d p = from + direction * (ahead / along);
      seen.extend(Eigen::Vector2d(right.dot(p), down.dot(p)));
    }
  }
  const Eigen::Vector2d size = seen.sizes();
  return rectangle(middle + n * distance + right * seen.min().x() + down * seen.min().y(), right * size.x(),
                   down * size.y());
}

Result<double> plane_of_pictures(const Rig& rig, const std::vector<Image>& pictures) {
  const Result<render::CameraGrid> grid = render::camera_grid(rig.cameras);
  if (!grid) return forward(grid);
  const std::vector<Pair> pairs = neighbours(*grid, pictures);
  if (pairs.empty())
    return fail(ErrorCode::InvalidArgument,
                "no two cameras side by side have a picture; say where the plane is");
  std::vector<Small> halves(rig.cameras.size());
  parallel_for(halves.size(), 0, [&](std::size_t i) {
    if (!pictures[i].empty()) halves[i] = small(rig.cameras[i], pictures[i]);
  });
  const Pair& first = pairs.front();
  const double pitch =
      (rig.cameras[first.a].cam_from_world.center() - rig.cameras[first.b].cam_from_world.center()).norm();
  const double scale = pitch * halves[first.a].model.fx;  // px of disparity times metres of depth
  double best = 0, least = std::numeric_limits<double>::infinity();
  auto look = [&](double low, double high, double step) {
    for (double disparity = low; disparity <= high; disparity += step) {
      const double d = disagreement(rig, *grid, halves, pairs, scale / disparity);
      if (d < least) least = d, best = disparity;
    }
  };
  look(0.25, kWidestShare * halves[first.a].gray.width, 0.25);
  const double around = best;
  look(std::max(0.02, around - 0.25), around + 0.25, 0.25 / kFiner);
  return scale / best;
}

Result<double> give_plane(capture::TakeReader& take, std::optional<double> distance) {
  if (!distance) {
    const Result<FrameSet> images = take.frame_set(0);
    if (!images) return forward(images);
    std::vector<Image> pictures;
    for (const Frame& frame : images->frames) {
      const Result<Image> rgb = to_rgb(frame);
      pictures.push_back(rgb ? *rgb : Image());
    }
    const Result<double> found = plane_of_pictures(take.rig(), pictures);
    if (!found) return forward(found);
    distance = *found;
  }
  const Result<Mesh> plane = plane_before(take.rig(), *distance);
  if (!plane) return forward(plane);
  if (Result<void> ok = make_folder(take.layout().meshes()); !ok) return forward(ok);
  for (int frame = 0; frame < take.frame_count(); ++frame)
    if (Result<void> ok = save_ply(*plane, take.layout().mesh(frame)); !ok) return forward(ok);
  return *distance;
}

}  // namespace floatstage::pipeline
