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

/// A part of the sphere of directions about the bunny, degrees.
struct BunnySky {
  double azimuth = 180;               ///< to either side of the front
  double lowest = -20, highest = 70;  ///< elevation: from below one would look into the holes of the scan
};
/// The part that bunny_grid(7, 10) spans.
inline constexpr BunnySky kBunnyWindow{30, -15, 45};

/// Cameras in random directions, evenly over that part of the sphere. Same seed, same cameras.
std::vector<RigCamera> bunny_cameras(int count, const BunnySky& sky, std::uint64_t seed, int size = 512);

enum class BetweenOrder { Random, FarthestFirst };

/// Up to `count` views between photographs: in directions inside the triangle of their three nearest cameras,
/// at least `apart` degrees from one another. FarthestFirst takes those farthest from all cameras.
std::vector<RigCamera> bunny_views_between(const std::vector<RigCamera>& cameras, const BunnySky& sky,
                                           int count, double apart, BetweenOrder order, int size = 512);

/// The angle between the directions in which two cameras see the bunny's middle, degrees.
double degrees_between(const RigCamera& a, const RigCamera& b);

/// `exact`, painted through with a checker of 6 mm cells in random colours, as `cameras` photograph it and as
/// it is from `views`, 3 x 3 rays a pixel; to be drawn on `proxy`.
TestScene painted_bunny(const Mesh& exact, const Mesh& proxy, const std::vector<RigCamera>& cameras,
                        const std::vector<RigCamera>& views);

}  // namespace floatstage::pipeline
