#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/rig.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage {

/// The embedded studio, seen by fake GigE Vision cameras that really send packets: camera i at 127.0.0.(i +
/// 1) with the rig's serial. All show the same pose at the same time, `loop` of them again and again, at
/// whatever rate they are set to. Threads of this process; gone with this object.
class GigeStage {
 public:
  /// `lost` is the share of packets that camera i never sends. Throws std::runtime_error.
  GigeStage(const SyntheticRigOptions& rig, double rate, int loop, const std::vector<double>& lost);
  ~GigeStage();

  const Rig& rig() const { return rig_; }
  /// A studio's [[camera]] tables for all of them.
  std::string toml() const;

 private:
  struct Camera;
  Rig rig_;
  double rate_;
  std::vector<std::unique_ptr<Camera>> cameras_;
};

}  // namespace floatstage
