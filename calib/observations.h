#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/rig.h"
#include "core/time.h"

namespace floatstage::calib {

/// What detectors hand to the solver, and what is known beforehand. Plain values: lengths in metres, pixels
/// with (0,0) at the image's corner (a detector built on OpenCV adds the half pixel before it fills these
/// in).

/// A point that can be told apart from the others of its target.
struct TargetPoint {
  int id = 0;                                          ///< unique in its target, not negative
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< metres, in the target's frame
  /// Which way the surface faces that carries the point, unit length in the target's frame. Zero: seen from
  /// everywhere. A board printed on one side with x to the right, y down and z into the board has (0,0,-1).
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  bool operator==(const TargetPoint&) const = default;
};

/// Two points of a target and how far apart they are.
struct TargetLength {
  int a = 0, b = 0;  ///< ids of points
  double metres = 0;
  double sigma = 1e-4;  ///< metres; how well it was measured, > 0
  bool operator==(const TargetLength&) const = default;
};

/// Ids 0 … columns*rows-1 lie row by row on a lattice: what lets the solver say that rows and columns were
/// swapped.
struct TargetGrid {
  int columns = 0, rows = 0;
  double pitch = 0;  ///< metres between neighbours
  bool operator==(const TargetGrid&) const = default;
};

enum class TargetKind {
  Board,    ///< rigid, its points where they are said to be; one pose a frame (one for all frames when it is
            ///< static)
  Wand,     ///< markers that move; only `lengths` are known, positions are ignored
  Markers,  ///< points fixed to the stage; positions are ignored unless `positions_sigma` says that they are
            ///< surveyed
};

struct Target {
  std::string name;
  TargetKind kind = TargetKind::Board;
  std::vector<TargetPoint> points;
  std::vector<TargetLength> lengths;      ///< of a wand or of markers; a board's are exact by its points
  std::optional<TargetGrid> grid;         ///< of a board
  bool is_static = false;                 ///< a board that never moves during the capture
  std::optional<double> positions_sigma;  ///< metres; of markers surveyed in the world
  bool operator==(const Target&) const = default;
};

/// One detected point.
struct SeenPoint {
  int id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< corner origin
  double sigma = 0.3;                               ///< px, of each coordinate, > 0
  bool operator==(const SeenPoint&) const = default;
};

/// What one camera saw of one target at one instant. Ids are unique in a view.
struct TargetView {
  int camera = 0;  ///< index into cameras
  int target = 0;  ///< index into targets
  int frame = 0;   ///< views of a target with one frame number show it in one place: the synchronised instant
  Timestamp time;  ///< of the frame, on the studio clock; only time offsets between cameras need it
  std::vector<SeenPoint> points;
  bool operator==(const TargetView&) const = default;
};

enum class LensKind { None, BrownConrady, KannalaBrandt };

/// Which terms of a lens are solved for; those that are not stay 0.
struct LensTerms {
  /// k1, k1 k2, …: 0 to 6 of a Brown-Conrady lens, 0 to 4 of a fisheye. Beyond 3 they are the denominator,
  /// kept where the capture shows it (ADR 0247). Absent: all of a fisheye, and of a Brown-Conrady lens two,
  /// and the third where the capture shows it (ADR 0225), or those of the rational lens that it begins with.
  std::optional<int> radial;
  bool tangential = true;  ///< p1 and p2 of a Brown-Conrady lens
  bool skew = false;       ///< of the pixels; for pictures that were scaled or scanned oddly
  bool operator==(const LensTerms&) const = default;
};

/// What is known of something before the calibration.
enum class Prior {
  Unknown,  ///< nothing: the solver finds its own start
  Start,    ///< nearly this: where the solver starts ("re-solve from yesterday")
  Fixed,    ///< exactly this
};

struct CalibrationCamera {
  std::string serial;
  int width = 0, height = 0;  ///< px
  LensKind lens = LensKind::BrownConrady;
  LensTerms terms = {};
  Prior intrinsics = Prior::Unknown, pose = Prior::Unknown;
  CameraModel model;      ///< where intrinsics is not Unknown; size and lens as above
  Rigid3 cam_from_world;  ///< where pose is not Unknown
  /// A place found by other means (COLMAP), where the solver starts. It says nothing of the world, and
  /// nothing moved since.
  std::optional<Rigid3> found = {};
  /// Index of an earlier camera with a lens of its own whose intrinsics are this one's too: one camera that
  /// was carried about, or a turntable's. Both begin from known intrinsics.
  std::optional<int> same_lens_as = {};
  /// Pixels of the shape (fx / fy) that they begin with and two radial coefficients: all that points of a
  /// scene, without a target, can tell of a lens.
  bool plain_lens = false;
};

/// Two cameras' centres and how far apart they are: measured, or as they were yesterday. One that contradicts
/// the others counts little.
struct CameraDistance {
  int a = 0, b = 0;  ///< indices into cameras
  double metres = 0;
  double sigma = 1e-3;  ///< metres, > 0
  bool operator==(const CameraDistance&) const = default;
};

/// The world is the frame of the fixed poses or of the surveyed markers; without them, the cameras' mean up
/// is z, the point they look at is above the origin, and where the floor is stays unknown.
struct OwnGauge {};

/// A board that lay on the floor in one frame: its origin on the floor, x along its x axis, z up on the side
/// from which it was seen.
struct FloorBoard {
  int target = 0, frame = 0;
  double height = 0;  ///< metres of the printed face above the floor
};

/// Set by hand: where one camera is.
struct HandSet {
  int camera = 0;
  Rigid3 cam_from_world;
};

using Gauge = std::variant<OwnGauge, FloorBoard, HandSet>;

/// All that a calibration is computed from.
struct Observations {
  std::vector<CalibrationCamera> cameras;
  std::vector<Target> targets;
  std::vector<TargetView> views;
  std::vector<CameraDistance> distances;
  Gauge gauge;
};

/// Serials usable and unique, sizes positive, every number finite, sigmas positive, indices and ids in range,
/// no view twice; the sentence names the camera, target and frame.
Result<void> check(const Observations& observations);

/// Index of the target's point with that id, or -1.
int point_index(const Target& target, int id);

/// JSON with a version ("floatstage_observations": 1), for caches and tests; numbers survive a round trip bit
/// by bit. What is read has passed check().
Result<Observations> parse_observations(std::string_view json, std::string_view name_for_errors);
std::string to_json(const Observations& observations);
Result<Observations> load_observations(const std::filesystem::path& file);
Result<void> save_observations(const Observations& observations, const std::filesystem::path& file);

}  // namespace floatstage::calib
