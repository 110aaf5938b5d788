#include "calib/solver/failures.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>

#include "calib/solver/start.h"
#include "calib/solver/view_pose.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string rounded(double value, int digits) { return text(std::fixed, std::setprecision(digits), value); }

// The board as it would be with its columns and rows exchanged.
Target transposed(Target t) {
  for (TargetPoint& p : t.points) {
    if (p.id >= t.grid->columns * t.grid->rows) continue;
    // Ids stay; what was said to be row by row of `columns` is row by row of `rows`.
    p.position = {t.grid->pitch * (p.id % t.grid->rows), t.grid->pitch * (p.id / t.grid->rows), 0};
  }
  return t;
}

std::vector<NamedFailure> wrong_lengths(const Scene& scene, const std::vector<LengthQuality>& lengths,
                                        double largest) {
  // A lone board agrees with itself. With a second measure (a wand, other boards, fixed poses) one of the two
  // is wrong.
  const auto fixed = std::count_if(scene.cameras.begin(), scene.cameras.end(),
                                   [](const SceneCamera& c) { return c.pose_fixed; });
  const auto kind_of = [&](const LengthQuality& q) {
    const auto found = std::find_if(scene.targets.begin(), scene.targets.end(),
                                    [&](const Target& t) { return t.name == q.target; });
    return found->kind;
  };
  std::vector<NamedFailure> out;
  for (const LengthQuality& board : lengths) {
    if (kind_of(board) != TargetKind::Board) continue;
    const LengthQuality* other = nullptr;
    for (const LengthQuality& q : lengths)
      if (&q != &board && (!other || kind_of(q) != TargetKind::Board)) other = &q;
    if (!other && fixed < 2) continue;
    const double ratio = other ? other->ratio / board.ratio : 1 / board.ratio;
    const double sigma = std::hypot(board.ratio_sigma, other ? other->ratio_sigma : 0);
    if (std::abs(ratio - 1) < std::max(largest, 4 * sigma)) continue;
    const Target& target = *std::find_if(scene.targets.begin(), scene.targets.end(),
                                         [&](const Target& t) { return t.name == board.target; });
    const std::string against =
        other ? text("the known lengths of '", other->target, "'") : "the fixed camera poses";
    std::string advice = "measure the board's squares again";
    if (target.grid)
      advice = text("if ", other ? "those" : "they", " are right, its squares measure ",
                    rounded(1e3 * target.grid->pitch / ratio, 2), " mm and not ",
                    rounded(1e3 * target.grid->pitch, 2), " mm");
    out.push_back(
        {CalibrationFailure::WrongSquareSize, "",
         text("target '", board.target, "' says that everything is ", rounded(100 * std::abs(ratio - 1), 1),
              " % ", ratio > 1 ? "larger" : "smaller", " than ", against, " say; ", advice)});
    if (other && kind_of(*other) == TargetKind::Board) break;  // two boards that disagree are one finding
  }
  return out;
}

std::vector<NamedFailure> mirrored_boards(const Scene& scene) {
  struct Count {
    int views = 0, behind = 0;
  };
  std::map<int, Count> counts;
  for (const SceneView& v : scene.views) {
    if (v.board < 0 || !usable(scene, v)) continue;
    const int target = scene.boards[at(v.board)].target;
    const Rigid3 pose = camera_from_target(scene, v);
    int front = 0, back = 0;
    for (const ScenePoint& p : v.points) {
      const TargetPoint& t = scene.targets[at(target)].points[at(p.index)];
      if (!p.kept || t.normal.isZero()) continue;
      ++((pose.rotation * t.normal).dot(pose * t.position) < 0 ? front : back);
    }
    if (front + back == 0) continue;
    ++counts[target].views;
    counts[target].behind += back > front;
  }
  std::vector<NamedFailure> out;
  for (const auto& [target, count] : counts)
    if (2 * count.behind > count.views)
      out.push_back({CalibrationFailure::MirroredBoard, "",
                     text("target '", scene.targets[at(target)].name, "' is seen from behind in ",
                          count.behind, " of ", count.views,
                          " views: its print, its description or the pictures are mirrored; print it again "
                          "without mirroring, or "
                          "turn off the cameras' mirror mode")});
  return out;
}

}  // namespace

std::vector<NamedFailure> wrong_layouts(const Scene& scene) {
  std::vector<NamedFailure> out;
  for (std::size_t t = 0; t < scene.targets.size(); ++t) {
    const Target& target = scene.targets[t];
    if (!target.grid || target.grid->columns == target.grid->rows) continue;
    const Target other = transposed(target);
    int views = 0, better = 0;
    constexpr int kMost = 60;
    for (const SceneView& v : scene.views) {
      if (v.board < 0 || scene.boards[at(v.board)].target != static_cast<int>(t) || v.points.size() < 8 ||
          views >= kMost)
        continue;
      std::vector<Correspondence> as_said, exchanged;
      for (const ScenePoint& p : v.points) {
        as_said.push_back({target.points[at(p.index)].position, p.pixel});
        exchanged.push_back({other.points[at(p.index)].position, p.pixel});
      }
      const double said = homography_error(as_said), swapped = homography_error(exchanged);
      ++views;
      better += said > 2 && swapped < 0.3 * said;
    }
    if (views > 0 && 2 * better > views)
      out.push_back({CalibrationFailure::SwappedRowsColumns, "",
                     text("target '", target.name, "': its points fit ", target.grid->rows, " columns and ",
                          target.grid->columns, " rows in ", better, " of ", views, " views, not ",
                          target.grid->columns, " columns and ", target.grid->rows,
                          " rows; exchange rows and columns in the session")});
  }
  return out;
}

std::vector<NamedFailure> weak_geometry(const Scene& scene, const std::vector<CameraQuality>& cameras,
                                        const std::vector<LengthQuality>& lengths,
                                        const CalibrationOptions& options) {
  std::vector<NamedFailure> out;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const CameraQuality& q = cameras[c];
    if (scene.cameras[c].intrinsics_fixed || !q.depth_ratio) continue;
    if (*q.depth_ratio < options.least_depth_ratio)
      out.push_back(
          {CalibrationFailure::ConstantDepth, q.serial,
           text("camera '", q.serial, "' saw the board at one distance only (farthest over nearest ",
                rounded(*q.depth_ratio, 2), ", at least ", rounded(options.least_depth_ratio, 2),
                " is needed): focal length and distance cannot be told apart; show it nearer and farther")});
    if (q.tilt_degrees && *q.tilt_degrees < options.least_tilt_degrees)
      out.push_back(
          {CalibrationFailure::PlanarMotion, q.serial,
           text("camera '", q.serial, "' saw the board always parallel to one plane (turned by ",
                rounded(*q.tilt_degrees, 1), "°, at least ", rounded(options.least_tilt_degrees, 1),
                "° are needed): its focal length is not determined; tilt the board by 30° and more")});
  }
  for (NamedFailure& f : wrong_lengths(scene, lengths, options.largest_length_error))
    out.push_back(std::move(f));
  for (NamedFailure& f : mirrored_boards(scene)) out.push_back(std::move(f));
  return out;
}

}  // namespace floatstage::calib::solver
