// Method:  cameras along the tree of pairs that saw most points
//          together, boards where most views agree
// Paper:   R. C. Prim, "Shortest connection networks and some generalizations", 1957
// Differs: of many estimates of a pose the one nearest to the others stands: nothing is drawn by chance
// ADR:     none; docs/algorithms/calibration.md

#include <algorithm>
#include <limits>
#include <map>

#include <Eigen/Dense>

#include "calib/solver/start.h"
#include "calib/solver/wand_start.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

ViewPoses all_view_poses(const Scene& scene, int threads) {
  ViewPoses poses(scene.views.size());
  parallel_for(scene.views.size(), threads, [&](std::size_t i) {
    const SceneView& v = scene.views[i];
    const SceneCamera& c = scene.cameras[at(v.camera)];
    if (v.board < 0 || v.points.size() < 4 || !c.has_intrinsics) return;
    poses[i] = view_pose(c.intrinsics, c.lens, c.width, c.height, correspondences(scene, v));
  });
  return poses;
}

// Of many estimates of one transform the one that most agree with. `depth` turns radians into metres.
const Rigid3* consensus(const std::vector<Rigid3>& candidates, double depth) {
  constexpr std::size_t kMost = 60;
  const std::size_t step = (candidates.size() + kMost - 1) / kMost;
  const Rigid3* best = nullptr;
  double least = kInfinity;
  for (std::size_t i = 0; i < candidates.size(); i += step) {
    std::vector<double> distances;  // to the others
    for (std::size_t k = 0; k < candidates.size(); k += step)
      if (k != i)
        distances.push_back(angle_between(candidates[i].rotation, candidates[k].rotation) * depth +
                            (candidates[i].center() - candidates[k].center()).norm());
    const double middle = distances.empty() ? 0 : median(std::move(distances));
    if (middle < least) {
      least = middle;
      best = &candidates[i];
    }
  }
  return best;
}

struct Shared {
  CameraPair pair;
  std::vector<Rigid3> a_from_b;
  double depth = 0;
};

// What pairs of cameras saw together of boards, by pair.
std::map<std::pair<int, int>, Shared> shared_boards(const Scene& scene, const ViewPoses& poses) {
  std::vector<std::map<int, std::pair<const ViewPose*, std::size_t>>> by_board(
      scene.boards.size());  // camera → its best view
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& v = scene.views[i];
    if (v.board < 0 || !poses[i]) continue;
    auto& entry = by_board[at(v.board)][v.camera];
    if (!entry.first || entry.second < v.points.size()) entry = {&*poses[i], v.points.size()};
  }
  std::map<std::pair<int, int>, Shared> pairs;
  for (const auto& cameras : by_board)
    for (auto a = cameras.begin(); a != cameras.end(); ++a)
      for (auto b = std::next(a); b != cameras.end(); ++b) {
        Shared& s = pairs[{a->first, b->first}];
        s.pair.a = a->first;
        s.pair.b = b->first;
        ++s.pair.frames;
        s.pair.points += static_cast<int>(std::min(a->second.second, b->second.second));
        const Rigid3& from_a = a->second.first->cam_from_target;
        s.a_from_b.push_back(from_a * b->second.first->cam_from_target.inverse());
        s.depth += from_a.translation.norm();
      }
  return pairs;
}

// What they saw together of a wand; it gives the pose where no board does.
void add_wand(const Scene& scene, std::map<std::pair<int, int>, Shared>& shared) {
  if (scene.markers.empty()) return;
  const auto count = static_cast<int>(scene.cameras.size());
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      const WandOverlap overlap = wand_overlap(scene, a, b);
      if (overlap.points == 0) continue;
      Shared& s = shared[{a, b}];
      s.pair.a = a;
      s.pair.b = b;
      s.pair.frames += overlap.frames;
      s.pair.points += overlap.points;
      if (scene.cameras[at(a)].placed && scene.cameras[at(b)].placed) continue;
      if (!s.a_from_b.empty() || !scene.cameras[at(a)].has_intrinsics || !scene.cameras[at(b)].has_intrinsics)
        continue;
      if (const std::optional<Rigid3> pose = pose_from_wand(scene, a, b)) s.a_from_b.push_back(*pose);
    }
}

// A camera that sees surveyed markers is placed by them.
void place_by_surveyed(Scene& scene) {
  std::vector<std::size_t> points(scene.cameras.size());
  for (const SceneView& v : scene.views) {
    if (v.markers < 0) continue;
    const SceneMarkers& m = scene.markers[at(v.markers)];
    const Target& target = scene.targets[at(m.target)];
    SceneCamera& c = scene.cameras[at(v.camera)];
    if (!target.positions_sigma || c.pose_fixed || !c.has_intrinsics ||
        v.points.size() <= points[at(v.camera)])
      continue;
    std::vector<Correspondence> seen;
    for (const ScenePoint& p : v.points)
      seen.push_back({target.points[at(m.indices[at(p.index)])].position, p.pixel});
    const std::optional<ViewPose> pose = view_pose(c.intrinsics, c.lens, c.width, c.height, seen);
    if (!pose) continue;
    points[at(v.camera)] = v.points.size();
    c.cam_from_world = pose->cam_from_target;
    c.placed = true;
  }
}

int richest_camera(const Scene& scene, bool only_placed) {
  std::vector<std::size_t> points(scene.cameras.size());
  for (const SceneView& v : scene.views) points[at(v.camera)] += v.points.size();
  int best = -1;
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((!only_placed || scene.cameras[i].placed) && (best < 0 || points[i] > points[at(best)]))
      best = static_cast<int>(i);
  return best;
}

std::string names_of_unplaced(const Scene& scene) {
  std::string names;
  for (const SceneCamera& c : scene.cameras)
    if (!c.placed) names += text(names.empty() ? "'" : ", '", c.serial, "'");
  return names;
}

// How well a board at a place explains all of its views; wrong points count little.
double disagreement(const std::vector<const SceneView*>& views, const SceneBoard& board, Scene& scratch) {
  scratch.boards[at(views.front()->board)] = board;
  double sum = 0;
  for (const SceneView* v : views)
    for (const Eigen::Vector2d& e : errors_of(scratch, *v)) sum += std::log1p(std::min(e.squaredNorm(), 1e6));
  return sum;
}

}  // namespace

void place_boards(Scene& scene, const ViewPoses& poses) {
  std::vector<std::vector<std::size_t>> of_board(scene.boards.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (scene.views[i].board >= 0) of_board[at(scene.views[i].board)].push_back(i);
  Scene scratch = scene;
  for (std::size_t b = 0; b < scene.boards.size(); ++b) {
    if (scene.boards[b].placed) continue;
    std::vector<const SceneView*> views;
    for (const std::size_t i : of_board[b])
      if (scene.cameras[at(scene.views[i].camera)].placed) views.push_back(&scene.views[i]);
    double least = kInfinity;
    SceneBoard best = scene.boards[b];
    for (const std::size_t i : of_board[b]) {
      const SceneCamera& c = scene.cameras[at(scene.views[i].camera)];
      if (!c.placed || !poses[i]) continue;
      SceneBoard candidate = scene.boards[b];
      candidate.world_from_target = c.cam_from_world.inverse() * poses[i]->cam_from_target;
      candidate.placed = true;
      const double cost = disagreement(views, candidate, scratch);
      if (cost < least) {
        least = cost;
        best = candidate;
      }
    }
    scene.boards[b] = best;
  }
}

void place_markers(Scene& scene) {
  std::vector<std::vector<SceneView*>> of_markers(scene.markers.size());
  for (SceneView& v : scene.views)
    if (v.markers >= 0) of_markers[at(v.markers)].push_back(&v);
  for (std::size_t m = 0; m < scene.markers.size(); ++m) {
    SceneMarkers& markers = scene.markers[m];
    if (markers.placed) continue;
    std::vector<int> moved(markers.indices.size(), -1), indices;
    std::vector<Eigen::Vector3d> positions;
    for (std::size_t k = 0; k < markers.indices.size(); ++k) {
      // Nearest to all rays in the least-squares sense.
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (const SceneView* v : of_markers[m]) {
        const SceneCamera& c = scene.cameras[at(v->camera)];
        for (const ScenePoint& p : v->points) {
          if (!c.placed || p.index != static_cast<int>(k)) continue;
          const std::optional<Eigen::Vector3d> ray =
              unproject(unpack(c.intrinsics, c.lens, c.width, c.height), p.pixel);
          if (!ray) continue;
          const Eigen::Vector3d d = (c.cam_from_world.rotation.conjugate() * *ray).normalized();
          const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
          normal += across;
          right += across * c.cam_from_world.center();
        }
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
      constexpr double kLeastParallax = 1e-4;  // about half a degree between two rays
      if (!(eigen.eigenvalues()[0] > kLeastParallax)) continue;
      moved[k] = static_cast<int>(indices.size());
      indices.push_back(markers.indices[k]);
      positions.push_back(normal.ldlt().solve(right));
    }
    for (SceneView* v : of_markers[m]) {
      std::vector<ScenePoint> left;
      for (ScenePoint p : v->points) {
        p.index = moved[at(p.index)];
        if (p.index >= 0) left.push_back(p);
      }
      v->points = std::move(left);
    }
    markers.indices = std::move(indices);
    markers.positions = std::move(positions);
    markers.placed = !markers.indices.empty();
  }
}

Result<std::vector<CameraPair>> start_poses(Scene& scene, int threads) {
  place_by_surveyed(scene);
  const ViewPoses poses = all_view_poses(scene, threads);
  std::map<std::pair<int, int>, Shared> shared = shared_boards(scene, poses);
  add_wand(scene, shared);
  const bool any_placed =
      std::any_of(scene.cameras.begin(), scene.cameras.end(), [](const SceneCamera& c) { return c.placed; });
  const int root = richest_camera(scene, any_placed);
  if (!any_placed) scene.cameras[at(root)].placed = true;
  const bool held = std::any_of(scene.cameras.begin(), scene.cameras.end(),
                                [](const SceneCamera& c) { return c.pose_fixed; }) ||
                    std::any_of(scene.targets.begin(), scene.targets.end(),
                                [](const Target& t) { return t.positions_sigma.has_value(); });
  scene.reference = held ? -1 : root;

  for (;;) {  // Prim: always the pair with most points that reaches a new camera
    Shared* best = nullptr;
    for (auto& [key, s] : shared)
      if (!s.a_from_b.empty() && scene.cameras[at(s.pair.a)].placed != scene.cameras[at(s.pair.b)].placed &&
          (!best || s.pair.points > best->pair.points))
        best = &s;
    if (!best) break;
    const Rigid3& a_from_b = *consensus(
        best->a_from_b, best->depth / std::max<double>(1, static_cast<double>(best->a_from_b.size())));
    SceneCamera &a = scene.cameras[at(best->pair.a)], &b = scene.cameras[at(best->pair.b)];
    if (a.placed)
      b.cam_from_world = a_from_b.inverse() * a.cam_from_world;
    else
      a.cam_from_world = a_from_b * b.cam_from_world;
    a.placed = b.placed = true;
    best->pair.in_tree = true;
  }
  if (const std::string lost = names_of_unplaced(scene); !lost.empty())
    return fail(ErrorCode::BadData,
                text("no chain of targets joins ", lost, " to camera '", scene.cameras[at(root)].serial,
                     "': show the target to these cameras together with others at the same time"));
  place_boards(scene, poses);
  place_markers(scene);
  std::vector<CameraPair> pairs;
  for (const auto& [key, s] : shared) pairs.push_back(s.pair);
  return pairs;
}

}  // namespace floatstage::calib::solver
