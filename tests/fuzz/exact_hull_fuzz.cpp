#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/fuzz/hull_claims.h"

// Any mattes from any directions: a closed, manifold mesh or a sentence about the input. Byte 0 says how many
// cameras, then six bytes each place one, and the rest is opacity, read in a circle.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  if (size < 2) return 0;
  constexpr int kWidth = 20, kHeight = 15;
  const auto byte = [&](std::size_t at) { return data[at % size]; };
  const std::size_t cameras = 2 + byte(0) % 3;
  Rig rig;
  std::vector<Matte> mattes;
  std::size_t at = 1;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::optional<Rigid3> pose = pose_from([&] { return byte(at++); });
    if (!pose) return 0;
    RigCamera camera;
    camera.serial = std::to_string(c);
    camera.model = {
        .width = kWidth, .height = kHeight, .fx = 18, .fy = 18, .cx = 10, .cy = 7.5, .skew = 0, .lens = {}};
    camera.cam_from_world = *pose;
    if (check(Rig{{camera}})) rig.cameras.push_back(camera);
    Image alpha(kWidth, kHeight, 1);
    for (std::uint8_t& pixel : alpha.pixels) pixel = byte(at++);
    mattes.push_back(make_matte({}, alpha));
  }
  if (rig.cameras.size() != cameras) return 0;
  recon::HullOptions options;
  options.threads = 1;
  options.contour_tolerance = byte(0) % 5 * 0.5;
  options.resolution = 48;  // of the octree that helps out, so that a slow input is one of the exact hull
  if (byte(0) & 64)
    options.volume = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1));
  claim_closed_or_refused(recon::visual_hull(rig, mattes, options));
  return 0;
}
