#pragma once

#include "pipeline/camera_path.h"

namespace floatstage::apps {

/// The camera that a hand on the mouse moves: orbits around a target or flies. Pure arithmetic, no window.
class ViewerCamera {
 public:
  explicit ViewerCamera(const pipeline::PathKey& start);

  const pipeline::PathKey& key() const { return key_; }  ///< its times mean nothing
  /// Stands as a key does that is in the world.
  void set(const pipeline::PathKey& key);

  /// Turns around the target: `right` and `up` in radians. Stops short of the poles.
  void orbit(double right, double up);
  /// Turns the head in place.
  void look(double right, double up);
  /// Moves target and eye across the picture; 1 is the picture's height at the target.
  void pan(double right, double up);
  /// Moves towards the target: 2 halves the distance.
  void zoom(double factor);
  /// Flies: metres along the camera's own axes.
  void fly(double right, double up, double forward);

 private:
  struct Axes {
    Eigen::Vector3d right, up, forward;
  };
  Axes axes() const;
  /// `direction` turned by `right` about the world's up and by `up` about the camera's right, kept off the
  /// poles.
  Eigen::Vector3d turned(const Eigen::Vector3d& direction, double right, double up) const;

  pipeline::PathKey key_;
};

}  // namespace floatstage::apps
