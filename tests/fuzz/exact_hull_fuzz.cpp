#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/check.h"
#include "recon/mesh_check.h"
#include "recon/visual_hull.h"

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
    const auto coordinate = [&] { return (byte(at++) - 127.5) / 40; };
    const Eigen::Vector3d eye(coordinate(), coordinate(), coordinate());
    const Eigen::Vector3d target = 0.1 * Eigen::Vector3d(coordinate(), coordinate(), coordinate());
    RigCamera camera;
    camera.serial = std::to_string(c);
    camera.model = {
        .width = kWidth, .height = kHeight, .fx = 18, .fy = 18, .cx = 10, .cy = 7.5, .skew = 0, .lens = {}};
    if ((eye - target).norm() < 0.1) return 0;
    camera.cam_from_world = look_at(eye, target, Eigen::Vector3d(0.1, 0.3, 1));
    if (check(Rig{{camera}})) rig.cameras.push_back(camera);
    Image alpha(kWidth, kHeight, 1);
    for (std::uint8_t& pixel : alpha.pixels) pixel = byte(at++);
    mattes.push_back(make_matte({}, alpha));
  }
  if (rig.cameras.size() != cameras) return 0;
  HullOptions options;
  options.threads = 1;
  options.contour_tolerance = byte(0) % 5 * 0.5;
  options.resolution = 48;  // of the octree that helps out, so that a slow input is one of the exact hull
  if (byte(0) & 64)
    options.volume = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1));
  const Result<HullReport> hull = visual_hull(rig, mattes, options);
  if (!hull) {
    FLOATSTAGE_CHECK(hull.error().code == ErrorCode::BadData, "an error that is not about the input");
    return 0;
  }
  const MeshCheck mesh = check_mesh(hull->mesh);
  FLOATSTAGE_CHECK(mesh.watertight && mesh.manifold && mesh.oriented, "an open hull: " + mesh.summary());
  return 0;
}
