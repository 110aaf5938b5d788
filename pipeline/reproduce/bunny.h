#pragma once

#include <filesystem>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

/// The Stanford bunny of Table 3: the scan, and 948 triangles of it.
struct Bunny {
  Mesh exact, coarse;
};
/// Of a folder that holds bun_zipper.ply and bun_zipper_res4.ply. Errors of load_ply().
Result<Bunny> load_bunny(const std::filesystem::path& folder);

/// A camera 0.45 m from the bunny's middle, degrees about its upright axis (y) and above its floor; a square
/// picture of `size` px that the bunny fills.
RigCamera bunny_camera(double azimuth, double elevation, int size = 512);

/// side x side cameras, `step` degrees apart, about azimuth 0 and elevation 15.
std::vector<RigCamera> bunny_grid(int side, double step, int size = 512);

/// Cameras in random directions all around: elevations from -20 to 70 degrees, evenly over that part of the
/// sphere (from below one would look into the holes of the scan). Same seed, same cameras.
std::vector<RigCamera> bunny_cameras_anywhere(int count, std::uint64_t seed, int size = 512);

/// `count` cameras of the same part of the sphere that are as far as can be from all of `from` and 15 degrees
/// from one another, farthest first.
std::vector<RigCamera> farthest_from(const std::vector<RigCamera>& from, int count, int size = 512);

/// The angle between the directions in which two cameras see the bunny's middle, degrees.
double degrees_between(const RigCamera& a, const RigCamera& b);

/// `exact`, painted through with a checker of 6 mm cells in random colours, as `cameras` photograph it and as
/// it is from `views`, 3 x 3 rays a pixel; to be drawn on `proxy`.
TestScene painted_bunny(const Mesh& exact, const Mesh& proxy, const std::vector<RigCamera>& cameras,
                        const std::vector<RigCamera>& views);

}  // namespace floatstage::pipeline
