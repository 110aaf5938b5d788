// Method:  a camera's focal length by trying it on some views, then the camera alone
// Paper:   Z. Zhang, "A flexible new technique for camera calibration", 2000, for each trial's poses
// Differs: the median error decides, not a closed form: a
//          few wrong points do no harm
// ADR:     none; docs/algorithms/calibration.md

#include <algorithm>
#include <cmath>

#include "calib/solver/bundle.h"
#include "calib/solver/start.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

constexpr std::size_t kFewestPoints = 6;

// Views that cover the picture and are different: the richest, evenly spread over the capture.
std::vector<const SceneView*> choose(const Scene& scene, int camera, std::size_t most) {
  std::vector<const SceneView*> all;
  for (const SceneView& v : scene.views)
    if (v.camera == camera && v.board >= 0 && v.points.size() >= kFewestPoints) all.push_back(&v);
  if (all.size() <= most) return all;
  std::vector<const SceneView*> chosen;
  for (std::size_t i = 0; i < most; ++i) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(i * all.size() / most);
    const auto end = all.begin() + static_cast<std::ptrdiff_t>((i + 1) * all.size() / most);
    chosen.push_back(*std::max_element(begin, end, [](const SceneView* a, const SceneView* b) {
      return a->points.size() < b->points.size();
    }));
  }
  return chosen;
}

Intrinsics simple(const SceneCamera& c, double focal) {
  Intrinsics in = Intrinsics::Zero();
  in.head<4>() << focal, focal, 0.5 * c.width, 0.5 * c.height;
  return in;
}

double score(const SceneCamera& c, const Intrinsics& in,
             const std::vector<std::vector<Correspondence>>& views) {
  constexpr double kWorst = 50;  // px: one hopeless view must not decide
  double sum = 0;
  for (const auto& points : views) {
    const std::optional<ViewPose> pose = view_pose(in, c.lens, c.width, c.height, points);
    sum += pose ? std::min(pose->error, kWorst) : kWorst;
  }
  return sum;
}

// The camera alone with some of its views, itself standing at the origin.
void refine_alone(Scene& scene, int camera, const std::vector<const SceneView*>& views) {
  SceneCamera& c = scene.cameras[static_cast<std::size_t>(camera)];
  Scene alone;
  alone.targets = scene.targets;
  alone.cameras = {c};
  alone.cameras[0].cam_from_world = {};
  alone.cameras[0].placed = true;
  alone.cameras[0].offset = 0;
  alone.reference = 0;
  for (const SceneView* v : views) {
    const std::optional<ViewPose> pose =
        view_pose(c.intrinsics, c.lens, c.width, c.height, correspondences(scene, *v));
    if (!pose) continue;
    SceneView copy = *v;
    copy.camera = 0;
    copy.lag = 0;
    copy.board = static_cast<int>(alone.boards.size());
    SceneBoard board;
    board.target = scene.boards[static_cast<std::size_t>(v->board)].target;
    board.world_from_target = pose->cam_from_target;
    board.placed = true;
    Projected ignored;
    for (ScenePoint& p : copy.points) {
      const Target& target = scene.targets[static_cast<std::size_t>(board.target)];
      p.kept = project<Slopes::None>(
          c.intrinsics, c.lens,
          board.world_from_target * target.points[static_cast<std::size_t>(p.index)].position, ignored);
    }
    alone.boards.push_back(board);
    alone.views.push_back(std::move(copy));
  }
  constexpr double kLoose = 10;  // sigmas: a start may be several pixels off
  solve(alone, {.loss = {kLoose}, .intrinsics = Freedom::Focal, .iterations = 15, .threads = 1});
  if (alone.views.size() >= 6)
    solve(alone, {.loss = {kLoose}, .intrinsics = Freedom::All, .iterations = 15, .threads = 1});
  const Intrinsics& in = alone.cameras[0].intrinsics;
  // A capture that says little about the lens may end anywhere; then the trial's focal length is the better
  // start.
  const bool sane = in.allFinite() && in[0] > 0.3 * c.start[0] && in[0] < 3 * c.start[0] &&
                    in[1] > 0.3 * c.start[1] && in[1] < 3 * c.start[1] &&
                    std::abs(in[2] - c.start[2]) < 0.3 * c.width &&
                    std::abs(in[3] - c.start[3]) < 0.3 * c.height;
  if (sane) c.intrinsics = in;
}

}  // namespace

std::vector<Correspondence> correspondences(const Scene& scene, const SceneView& v) {
  std::vector<Correspondence> out;
  const Target& target =
      scene.targets[static_cast<std::size_t>(scene.boards[static_cast<std::size_t>(v.board)].target)];
  for (const ScenePoint& p : v.points)
    if (p.kept) out.push_back({target.points[static_cast<std::size_t>(p.index)].position, p.pixel});
  return out;
}

Result<void> start_intrinsics(Scene& scene, int camera) {
  SceneCamera& c = scene.cameras[static_cast<std::size_t>(camera)];
  constexpr std::size_t kTried = 12, kRefined = 30;
  std::vector<std::vector<Correspondence>> views;
  for (const SceneView* v : choose(scene, camera, kTried)) views.push_back(correspondences(scene, *v));
  if (views.empty())
    return fail(ErrorCode::BadData, text("camera '", c.serial, "': no picture shows ", kFewestPoints,
                                         " points of a board, so its focal length cannot be found; show it "
                                         "the board, or give its intrinsics"));
  // From a 130° wide lens to a long one; neighbours differ by 12 %, which the refinement bridges.
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (double factor = 0.2; factor < 8; factor *= 1.12) {
    const double focal = factor * std::max(c.width, c.height), error = score(c, simple(c, focal), views);
    if (error < least) {
      least = error;
      best = focal;
    }
  }
  c.start = c.intrinsics = simple(c, best);
  c.has_intrinsics = true;
  refine_alone(scene, camera, choose(scene, camera, kRefined));
  c.start = c.intrinsics;
  c.start.segment<kLensRows>(kLensRow).setZero();
  c.start[kSkewRow] = 0;
  c.start.segment<2>(2) << 0.5 * c.width, 0.5 * c.height;
  return {};
}

}  // namespace floatstage::calib::solver
