#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "calib/solver/projection.h"
#include "core/camera.h"

namespace floatstage::calib::solver {

/// What is being solved for: cameras, where boards were, where markers were; and the views that tie them
/// together.

struct SceneCamera {
  std::string serial;
  int width = 0, height = 0;
  LensKind lens = LensKind::BrownConrady;
  Intrinsics intrinsics = Intrinsics::Zero();
  Intrinsics start = Intrinsics::Zero();  ///< what the weak priors hold on to where a capture says nothing
  Rigid3 cam_from_world;
  double offset = 0;  ///< seconds that this camera's pictures were taken later than their time says
  double noise = 1;   ///< its pixel errors in units of the detector's sigmas
  bool intrinsics_fixed = false, pose_fixed = false;
  bool third_if_shown = false;  ///< k3 was left to the capture: it is held where nothing speaks for it
  int denominator_terms = 0;    ///< of k4 k5 k6: those that are solved for once all others have settled
  Intrinsics without_denominator = Intrinsics::Zero();  ///< the lens as it was before they were
  bool third_was_held = false;                          ///< and whether it had k3
  Eigen::Matrix<bool, kIntrinsics, 1> held = Eigen::Matrix<bool, kIntrinsics, 1>::Constant(false);
  bool has_intrinsics = false, placed = false;
  int lens_of = -1;         ///< the camera whose intrinsics are this one's too; -1: they are its own
  bool plain_lens = false;  ///< see CalibrationCamera
};

/// The camera whose intrinsics are this one's: itself in most rigs.
inline int lens_owner(const std::vector<SceneCamera>& cameras, int camera) {
  const int of = cameras[static_cast<std::size_t>(camera)].lens_of;
  return of >= 0 ? of : camera;
}

/// A board at one instant, and how it was moving then.
struct SceneBoard {
  int target = 0, frame = 0;
  double time = 0;  ///< seconds, from the first frame
  Rigid3 world_from_target;
  bool placed = false, held_out = false;
  bool has_motion = false;
  /// Spin and velocity are solved for: cameras that expose at different instants see them. Then the
  /// neighbouring frames only say what they are likely to be.
  bool free_motion = false;
  Eigen::Vector3d likely_spin = Eigen::Vector3d::Zero(), likely_velocity = Eigen::Vector3d::Zero();
  double spin_doubt = 1, velocity_doubt = 1;               ///< sigmas of that (rad/s, m/s)
  bool has_neighbours = false;                             ///< near enough to say what is likely
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();          ///< rad/s, in the world
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s of the target's origin
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< m/s²

  /// Where it was `dt` seconds later.
  Rigid3 at(double dt) const;
};

/// Markers of one target at one instant (a wand), or at all (static markers).
struct SceneMarkers {
  int target = 0, frame = 0;
  double time = 0;
  std::vector<int> indices;                ///< into the target's points
  std::vector<Eigen::Vector3d> positions;  ///< world
  std::vector<Eigen::Vector3d> velocities;
  bool placed = false, held_out = false, has_motion = false;
};

struct ScenePoint {
  int index = 0;  ///< of a board: into its target's points; of markers: into SceneMarkers::positions
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 0;
  bool kept = true;  ///< false: an outlier
};

struct SceneView {
  int camera = 0;
  int board = -1, markers = -1;  ///< one of them
  int source = 0;                ///< index into Observations::views
  double lag = 0;                ///< seconds after the time of its board or markers
  double jitter = 0;  ///< seconds beyond its lag and its camera's offset, as far as is known; of board views
  std::vector<ScenePoint> points;
};

/// The most that a hand's motion strays from what its neighbouring frames say (rad/s, m/s).
inline constexpr double kSpinDoubt = 0.7, kVelocityDoubt = 0.25;

/// A known distance between two cameras.
struct SceneDistance {
  int a = 0, b = 0;
  double metres = 0, sigma = 0;
};

struct Scene {
  std::vector<SceneCamera> cameras;
  std::vector<SceneDistance> distances;
  std::vector<Target> targets;
  std::vector<SceneBoard> boards;
  std::vector<SceneMarkers> markers;
  std::vector<SceneView> views;
  int reference =
      -1;  ///< the camera that stands still while the others are solved for; -1: fixed things hold the world
  double period = 0;  ///< seconds from frame to frame; 0: unknown
  /// Seconds that a picture strays from its camera's instant; each board view's own jitter is eliminated. 0:
  /// none does.
  double jitter_sigma = 0;
  double ring = 0;  ///< the cameras stand on a circle within this share of its radius; 0: nobody says so
  double spin_doubt = kSpinDoubt,
         velocity_doubt = kVelocityDoubt;  ///< how far motion strays from what neighbours say
};

/// Boards and markers made out of the views; nothing placed but what is known.
Scene make_scene(const Observations& observations);

/// Both ends exist: whether a view takes part in a solution.
bool usable(const Scene& scene, const SceneView& view);

/// Where the target of a board view is in the camera's frame at the instant of the view.
Rigid3 camera_from_target(const Scene& scene, const SceneView& view);

/// Pixel errors of a view's points, kept or not; infinite behind the camera. Needs usable(scene, view).
std::vector<Eigen::Vector2d> errors_of(const Scene& scene, const SceneView& view);

/// Fills in how boards and markers move, from where they are in neighbouring frames.
void estimate_motion(Scene& scene);

/// From now on the motion of boards that are not static is solved for.
void free_motion(Scene& scene);

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);
Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& axis_times_angle);
Eigen::Vector3d vector_from_rotation(const Eigen::Quaterniond& rotation);
double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);  ///< rad

}  // namespace floatstage::calib::solver
