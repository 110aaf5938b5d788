// Method:  cross-validation: folds of frames are predicted by
//          solutions that know nothing of them
// Paper:   M. Stone, "Cross-validatory choice and assessment of statistical predictions", 1974
// Differs: only what moves is held out; folds are taken until enough frames were predicted
// ADR:     0122

#include "calib/solver/holdout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calib/solver/bundle.h"
#include "calib/solver/quality.h"
#include "calib/solver/stages.h"
#include "calib/solver/start.h"
#include "calib/solver/timing.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool moves(const Scene& scene, const SceneBoard& b) {
  return b.placed && !scene.targets[at(b.target)].is_static;
}

bool moves(const Scene& scene, const SceneMarkers& m) {
  return m.placed && scene.targets[at(m.target)].kind == TargetKind::Wand;
}

std::set<int> moving_frames(const Scene& scene) {
  std::set<int> frames;
  for (const SceneBoard& b : scene.boards)
    if (moves(scene, b)) frames.insert(b.frame);
  for (const SceneMarkers& m : scene.markers)
    if (moves(scene, m)) frames.insert(m.frame);
  return frames;
}

// Solves without the fold's frames.
Scene solved_without(const Scene& solved, const std::set<int>& fold, const CalibrationOptions& options) {
  Scene scene = solved;
  const auto hold_out = [&](auto& object) {
    object.held_out = moves(scene, object) && fold.contains(object.frame);
    if (object.held_out) object.placed = false;
  };
  for (SceneBoard& b : scene.boards) hold_out(b);
  for (SceneMarkers& m : scene.markers) hold_out(m);
  solve_again(scene, options);
  return scene;
}

// Places the boards and markers that were held out, with cameras that stay where they are. Frames that were
// solved for only say how boards were moving.
void predict(Scene& scene, const CalibrationOptions& options) {
  ViewPoses poses(scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    SceneView& v = scene.views[i];
    const bool held =
        v.board >= 0 ? scene.boards[at(v.board)].held_out : scene.markers[at(v.markers)].held_out;
    if (!held) continue;
    v.jitter = 0;
    for (ScenePoint& p : v.points) p.kept = true;
    if (v.board < 0) continue;
    const SceneCamera& c = scene.cameras[at(v.camera)];
    poses[i] = view_pose(c.intrinsics, c.lens, c.width, c.height, correspondences(scene, v));
  }
  for (SceneMarkers& m : scene.markers) m.placed = m.held_out;
  for (SceneBoard& b : scene.boards)
    if (b.held_out) b.free_motion = b.has_motion = false;
  place_boards(scene, poses);
  if (options.time_offsets) {
    estimate_motion(scene);
    free_motion(scene);
  }
  for (SceneBoard& b : scene.boards) b.placed = b.placed && b.held_out;
  select_inliers(scene, 1e12);  // what is behind a camera
  solve(scene, {.loss = {2},
                .intrinsics = Freedom::None,
                .cameras_move = false,
                .iterations = 20,
                .threads = options.threads});
  for (int round = 0; round < 2; ++round) {
    estimate_jitter(scene);
    select_inliers(scene, options.outlier_sigmas);
    solve(scene,
          {.intrinsics = Freedom::None, .cameras_move = false, .iterations = 20, .threads = options.threads});
  }
  estimate_jitter(scene);
}

}  // namespace

std::vector<Measured> holdout_errors(const Scene& solved, const Observations& observations,
                                     const CalibrationOptions& options) {
  const std::set<int> frames = moving_frames(solved);
  constexpr std::size_t kFewestFrames = 15, kEnoughFrames = 40;
  const int folds = options.holdout_every;
  const auto none = [&](std::string because) {
    return std::vector<Measured>(solved.cameras.size(), Measured::not_measured(std::move(because)));
  };
  if (folds < 2) return none("no frame was to be held out (holdout_every)");
  if (frames.size() < kFewestFrames)
    return none(text("only ", frames.size(), " frames show what moves; ", kFewestFrames,
                     " are needed to hold some out"));
  std::vector<double> squares(solved.cameras.size());
  std::vector<int> counts(solved.cameras.size());
  std::size_t predicted = 0;
  for (int first = 0; first < folds && predicted < kEnoughFrames; ++first) {
    const int residue = (folds / 2 + first) % folds;
    std::set<int> fold;
    int position = 0;
    for (const int frame : frames)
      if (position++ % folds == residue) fold.insert(frame);
    predicted += fold.size();
    Scene scene = solved_without(solved, fold, options);
    predict(scene, options);
    for (const PointError& e : point_errors(scene, observations)) {
      if (!e.kept) continue;
      squares[at(e.camera)] += e.error.squaredNorm();
      ++counts[at(e.camera)];
    }
  }
  std::vector<Measured> rms;
  for (std::size_t c = 0; c < squares.size(); ++c)
    rms.push_back(Measured::of(counts[c] > 0 ? std::sqrt(squares[c] / counts[c]) : 0, counts[c],
                               "no frame that was held out shows this camera anything"));
  return rms;
}

}  // namespace floatstage::calib::solver
