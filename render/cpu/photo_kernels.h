#pragma once

#include <array>
#include <cstdint>

#include "render/camera_block.h"
#include "render/scene_impl.h"

// Inner loops over lists of pixels, made for several instruction sets and chosen at run time. Lists are
// padded to Covered::kAlign: loops read and write up to the next multiple of it. Formulas:
// render/gl/shaders/camera.glsl and visibility.comp.
namespace floatstage::render::cpu {

/// How a pixel of the window becomes a point of the world.
struct ViewRays {
  float inverse_fx, inverse_fy, cx, cy, skew;  ///< cx, cy in the window
  std::array<float, 9> world_from_view;        ///< row by row
  std::array<float, 3> eye;                    ///< world
};

/// One photograph: its camera, its pixels, its depth map.
struct PhotoCamera {
  std::array<float, 12> cam_from_world;  ///< row by row, 3 x 4
  std::array<float, 3> center;           ///< world
  float fx, fy, cx, cy, skew;
  int lens;  ///< 0 pinhole, 1 Brown-Conrady, 2 fisheye
  std::array<float, 5> k;
  std::array<float, 3> below;  ///< k4 k5 k6 of Brown-Conrady
  bool rational;               ///< whether one of them is not zero
  float largest_r2, width, height;
  float tile_x, tile_y, tile_width, tile_height;
  const std::uint8_t* tile;  ///< its first pixel, RGBA; an apron lies around it
  int tile_stride;           ///< px
  std::array<float, 4> depth_place;
  int depth_width, depth_height;
  const float* depth;  ///< 1/z, 0: nothing there
};
PhotoCamera photo_camera(const CameraBlock& block, const SceneTile& tile);  ///< without the depth map

/// Points of the view's surface.
struct PixelList {
  const float *x, *y;      ///< px of the window; y may be null: all are on `row_y`
  const float* inverse_z;  ///< of the view
  float row_y;
  int count;
};
struct Normals {
  const float *x, *y, *z;  ///< world, towards the eye
};

/// Where a photograph shows the points: px of it, and 1 where that is inside the picture, else 0.
void project_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points, float* u,
                    float* v, std::int32_t* inside);

/// What the mattes of the cameras that look at a point say there, summed camera by camera over a list: those
/// whose picture and depth map show it, weighted by angle and `reach`. Null: nobody asks.
struct MatteSums {
  float reach = 1;
  float *sum = nullptr, *weight = nullptr;  ///< of weight x opacity, and of weights
  float* most = nullptr;                    ///< the largest opacity; stays as it is where no camera looks
  float* behind = nullptr;                  ///< the same of all whose picture reaches there, hidden or not
};

/// The same, and whether the photograph may be used there (picture, matte, depth map), and the angular
/// weight: 1/angle, negative where the picture does not reach or shows no subject.
void see_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                const Normals& normals, float tolerance, float* u, float* v, std::int32_t* seen,
                float* angular, const MatteSums& mattes);

/// Colours of a photograph, r g b a per pixel, 0…255, at the pixels whose `wanted` is not 0: Catmull-Rom
/// spline, or bilinear where not `sharp`. Others are left alone.
void read_colors(const PhotoCamera& camera, bool sharp, const float* u, const float* v,
                 const std::int32_t* wanted, int count, float* rgba);

const char* instruction_set();

}  // namespace floatstage::render::cpu
