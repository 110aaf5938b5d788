#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/fuzz/hull_claims.h"

// Any outlines from any directions, as a wire may bring them: a closed, manifold mesh or a sentence about the
// input. Byte 0 says how many cameras and whether they have lenses and a volume; then six bytes place a
// camera, and the rest, read in a circle, are its polygons: a count, then per polygon a count and points in
// quarters of a pixel.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  if (size < 2) return 0;
  const auto byte = [&](std::size_t at) { return data[at % size]; };
  const std::size_t cameras = 2 + byte(0) % 4;
  Rig rig;
  std::vector<Silhouette> outlines;
  std::size_t at = 1;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::optional<Rigid3> pose = pose_from([&] { return byte(at++); });
    if (!pose) return 0;
    RigCamera camera;
    camera.serial = std::to_string(c);
    camera.model = {.width = 48, .height = 36, .fx = 44, .fy = 44, .cx = 24, .cy = 18, .skew = 0, .lens = {}};
    if (byte(0) & 32) camera.model.lens = BrownConrady{-0.1, 0.02, 0, 0, 0};
    camera.cam_from_world = *pose;
    if (!check(Rig{{camera}})) return 0;
    rig.cameras.push_back(camera);
    Silhouette outline;
    const std::uint8_t head = byte(at++);
    outline.beyond_counts = head & 128;
    const int polygons = head % 4;
    for (int k = 0; k < polygons; ++k) {
      outline.starts.push_back(static_cast<int>(outline.points.size()));
      const int points = byte(at++) % 24;
      for (int p = 0; p < points; ++p, at += 2)
        outline.points.emplace_back(byte(at) / 4.0 - 8, byte(at + 1) / 4.0 - 8);
    }
    if (polygons > 0) outline.starts.push_back(static_cast<int>(outline.points.size()) + (head & 64 ? 1 : 0));
    outlines.push_back(std::move(outline));
  }
  recon::HullOptions options;
  options.threads = 1;
  options.voting = byte(0) & 16 ? recon::HullVoting::Auto : recon::HullVoting::Strict;
  if (byte(0) & 64)
    options.volume = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1));
  claim_closed_or_refused(recon::visual_hull(rig, outlines, options));
  return 0;
}
