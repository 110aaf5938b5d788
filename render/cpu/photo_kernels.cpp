#include "render/cpu/photo_kernels.h"

#include <algorithm>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/photo_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "render/cpu/photo_geometry-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

constexpr float kSmallestAngle =
    2e-5F;                         // rad; a camera nearer than this to the viewing ray has all the weight
constexpr float kGrazing = 0.02F;  // cosine below which a camera sees nothing of a surface
constexpr float kOpaque = 0.5F;

/// By tangent: precise near zero, where a cosine is not.
HWY_INLINE VF angle_between(const V3& a, const V3& b) {
  const V3 cross = {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
                    hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
  const VF along = dot(a, b), size = hn::Max(hn::Abs(along), all(1e-30F));
  const VF acute = hn::Atan(F(), hn::Div(hn::Sqrt(dot(cross, cross)), size));
  return hn::IfThenElse(hn::Lt(along, all(0)), hn::Sub(all(3.14159265F), acute), acute);
}

/// The matte at a pixel, bilinear, 0 … 1.
HWY_INLINE VF matte_at(const PhotoCamera& c, VF u, VF v) {
  const F d;
  const I di;
  const VF x = hn::Sub(held(hn::Sub(u, all(c.tile_x)), 0.5F, c.tile_width - 0.5F), all(0.5F));
  const VF y = hn::Sub(held(hn::Sub(v, all(c.tile_y)), 0.5F, c.tile_height - 0.5F), all(0.5F));
  const VI x0 = hn::ConvertTo(di, x), y0 = hn::ConvertTo(di, y);
  const VF fx = hn::Sub(x, hn::ConvertTo(d, x0)), fy = hn::Sub(y, hn::ConvertTo(d, y0));
  const VI at = hn::Add(hn::Mul(y0, hn::Set(di, c.tile_stride)), x0);
  const auto* pixels = reinterpret_cast<const std::int32_t*>(c.tile);
  auto alpha = [&](int offset) HWY_ATTR {
    const VI rgba = hn::GatherIndex(di, pixels + offset, at);
    return hn::ConvertTo(d,
                         hn::BitCast(di, hn::ShiftRight<24>(hn::BitCast(hn::RebindToUnsigned<I>(), rgba))));
  };
  const VF a = alpha(0), b = alpha(1), e = alpha(c.tile_stride), f = alpha(c.tile_stride + 1);
  const VF top = hn::MulAdd(fx, hn::Sub(b, a), a), bottom = hn::MulAdd(fx, hn::Sub(f, e), e);
  return hn::Mul(hn::MulAdd(fy, hn::Sub(bottom, top), top), all(1.F / 255));
}

/// At least half of the four depth map texels around p are explained by the surface's own plane.
HWY_INLINE MF not_hidden(const PhotoCamera& c, const V3& p, const V3& n, float tolerance) {
  const F d;
  const I di;
  const VF plane = dot(n, p);
  // The cosine of the angle of view is -plane / |p|.
  const MF faces = hn::And(hn::Lt(plane, all(0)),
                           hn::Ge(hn::Mul(plane, plane), hn::Mul(all(kGrazing * kGrazing), dot(p, p))));
  const auto& m = c.depth_place;
  const VF inverse = hn::Div(all(1), p.z);
  const VF ax = hn::MulAdd(all(m[0]), hn::Mul(p.x, inverse), all(m[2] - 0.5F));
  const VF ay = hn::MulAdd(all(m[1]), hn::Mul(p.y, inverse), all(m[3] - 0.5F));
  const VF lx = hn::Floor(ax), ly = hn::Floor(ay);
  const float last_x = static_cast<float>(c.depth_width - 2), last_y = static_cast<float>(c.depth_height - 2);
  const MF beyond = hn::Or(hn::Or(hn::Lt(lx, all(0)), hn::Gt(lx, all(last_x))),
                           hn::Or(hn::Lt(ly, all(0)), hn::Gt(ly, all(last_y))));
  const VI ix = hn::ConvertTo(di, held(lx, 0, last_x)), iy = hn::ConvertTo(di, held(ly, 0, last_y));
  const VI at = hn::Add(hn::Mul(iy, hn::Set(di, c.depth_width)), ix);
  const VF fx = hn::Sub(ax, lx), fy = hn::Sub(ay, ly);
  const VF step_x = hn::Mul(n.x, all(1 / m[0])), step_y = hn::Mul(n.y, all(1 / m[1]));
  const VF corner = hn::MulAdd(n.x, hn::Mul(hn::Add(lx, all(0.5F - m[2])), all(1 / m[0])),
                               hn::MulAdd(n.y, hn::Mul(hn::Add(ly, all(0.5F - m[3])), all(1 / m[1])), n.z));
  const VF nearest = hn::Sub(p.z, all(2 * tolerance)), farthest = hn::Add(p.z, all(2 * tolerance));
  VF sum = all(0);
  for (int i = 0; i < 4; ++i) {
    const VF away = hn::Add(corner, hn::Add((i & 1) != 0 ? step_x : all(0), (i >> 1) != 0 ? step_y : all(0)));
    const VF expected = hn::Min(hn::Max(hn::Div(plane, hn::Min(away, all(-1e-6F))), nearest), farthest);
    const VF there = hn::GatherIndex(d, c.depth + (i & 1) + (i >> 1) * c.depth_width, at);
    const VF weight =
        hn::Mul((i & 1) != 0 ? fx : hn::Sub(all(1), fx), (i >> 1) != 0 ? fy : hn::Sub(all(1), fy));
    // z >= expected - tolerance, without dividing
    const MF behind = hn::Le(hn::Mul(there, hn::Sub(expected, all(tolerance))), all(1));
    sum = hn::Add(sum, hn::IfThenElseZero(behind, weight));
  }
  return hn::And(faces, hn::Or(beyond, hn::Ge(sum, all(0.5F))));
}

void ProjectPoints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points, float* u,
                   float* v, std::int32_t* inside) {
  const F d;
  const I di;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); i += hn::Lanes(d)) {
    const V3 w =
        world_points(rays, hn::LoadU(d, points.x + i), row_or(points, i), hn::LoadU(d, points.inverse_z + i));
    VF pu, pv;
    const MF in = photo_pixel(camera, in_camera(camera, w), pu, pv);
    hn::StoreU(pu, d, u + i);
    hn::StoreU(pv, d, v + i);
    hn::StoreU(hn::IfThenElseZero(hn::RebindMask(di, in), hn::Set(di, 1)), di, inside + i);
  }
}

void SeePoints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
               const Normals& normals, float tolerance, float* u, float* v, std::int32_t* seen,
               float* angular, const MatteSums& mattes) {
  const F d;
  const I di;
  const V3 eye = {all(rays.eye[0]), all(rays.eye[1]), all(rays.eye[2])};
  const V3 center = {all(camera.center[0]), all(camera.center[1]), all(camera.center[2])};
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); i += hn::Lanes(d)) {
    const V3 w =
        world_points(rays, hn::LoadU(d, points.x + i), row_or(points, i), hn::LoadU(d, points.inverse_z + i));
    const V3 to_view = {hn::Sub(eye.x, w.x), hn::Sub(eye.y, w.y), hn::Sub(eye.z, w.z)};
    const V3 to_camera = {hn::Sub(center.x, w.x), hn::Sub(center.y, w.y), hn::Sub(center.z, w.z)};
    const VF angle = hn::Max(angle_between(to_view, to_camera), all(kSmallestAngle));
    const VF weight = hn::Div(all(1), angle);
    const V3 p = in_camera(camera, w);
    VF pu, pv;
    const MF in = photo_pixel(camera, p, pu, pv);
    const V3 nw = {hn::LoadU(d, normals.x + i), hn::LoadU(d, normals.y + i), hn::LoadU(d, normals.z + i)};
    auto turned = [&](std::size_t r) HWY_ATTR {
      const float* m = camera.cam_from_world.data() + 4 * r;
      return hn::MulAdd(all(m[0]), nw.x, hn::MulAdd(all(m[1]), nw.y, hn::Mul(all(m[2]), nw.z)));
    };
    const V3 n = {turned(0), turned(1), turned(2)};
    const VF matte = matte_at(camera, pu, pv);
    const MF looks = hn::And(in, not_hidden(camera, p, n, tolerance));
    const MF on_subject = hn::And(in, hn::Ge(matte, all(kOpaque)));
    const MF usable = hn::And(looks, on_subject);
    hn::StoreU(pu, d, u + i);
    hn::StoreU(pv, d, v + i);
    hn::StoreU(hn::IfThenElseZero(hn::RebindMask(di, usable), hn::Set(di, 1)), di, seen + i);
    hn::StoreU(hn::IfThenElse(on_subject, weight, hn::Neg(weight)), d, angular + i);
    if (mattes.sum == nullptr) continue;
    const VF counts = hn::IfThenElseZero(looks, hn::Mul(weight, all(mattes.reach)));
    hn::StoreU(hn::MulAdd(counts, matte, hn::LoadU(d, mattes.sum + i)), d, mattes.sum + i);
    hn::StoreU(hn::Add(counts, hn::LoadU(d, mattes.weight + i)), d, mattes.weight + i);
    const VF most = hn::LoadU(d, mattes.most + i);
    hn::StoreU(hn::IfThenElse(looks, hn::Max(most, matte), most), d, mattes.most + i);
    const VF behind = hn::LoadU(d, mattes.behind + i);
    hn::StoreU(hn::IfThenElse(in, hn::Max(behind, matte), behind), d, mattes.behind + i);
  }
}

/// Where splines along one axis begin to read, and their four weights.
struct Axis {
  static constexpr int kBlock = 64;  // pixels
  int low[kBlock];
  float w[4][kBlock];

  void set(const float* position, float offset, float size, bool sharp, int count) {
    for (int i = 0; i < count; ++i) {  // what is no number becomes the first pixel
      const float p = std::min(std::max(0.5F, position[i] - offset), size - 0.5F) - 0.5F;
      low[i] = static_cast<int>(p);
      const float f = p - static_cast<float>(low[i]);
      w[0][i] = sharp ? f * (-0.5F + f * (1 - 0.5F * f)) : 0;
      w[1][i] = sharp ? 1 + f * f * (1.5F * f - 2.5F) : 1 - f;
      w[2][i] = sharp ? f * (0.5F + f * (2 - 1.5F * f)) : f;
      w[3][i] = sharp ? f * f * (0.5F * f - 0.5F) : 0;
    }
  }
};

void ReadColors(const PhotoCamera& camera, bool sharp, const float* u, const float* v,
                const std::int32_t* wanted, int count, float* rgba) {
  // Four pixels of four rows: sixteen bytes a row, each row weighted, then summed across.
  const hn::CappedTag<float, 16> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const hn::Rebind<std::int32_t, decltype(d)> d32;
  constexpr std::size_t kAll = 16;
  const std::size_t lanes = hn::Lanes(d);
  const std::ptrdiff_t step = 4 * static_cast<std::ptrdiff_t>(camera.tile_stride);
  HWY_ALIGN float sums[kAll];
  Axis x, y;
  for (int begin = 0; begin < count; begin += Axis::kBlock) {
    const int block = std::min(Axis::kBlock, count - begin);
    x.set(u + begin, camera.tile_x, camera.tile_width, sharp, block);
    y.set(v + begin, camera.tile_y, camera.tile_height, sharp, block);
    for (int i = 0; i < block; ++i) {
      if (wanted[begin + i] == 0) continue;
      const std::uint8_t* row = camera.tile + (y.low[i] - 1) * step + 4 * (x.low[i] - 1);
      for (std::size_t k = 0; k < kAll; k += lanes) {
        auto part = [&](int r) HWY_ATTR {
          return hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, row + r * step + k)));
        };
        auto sum = hn::Mul(part(0), hn::Set(d, y.w[0][i]));
        sum = hn::MulAdd(part(1), hn::Set(d, y.w[1][i]), sum);
        sum = hn::MulAdd(part(2), hn::Set(d, y.w[2][i]), sum);
        sum = hn::MulAdd(part(3), hn::Set(d, y.w[3][i]), sum);
        hn::Store(sum, d, sums + k);
      }
      float* to = rgba + 4 * (begin + i);
      for (int c = 0; c < 4; ++c) {
        const float color = sums[c] * x.w[0][i] + sums[4 + c] * x.w[1][i] + sums[8 + c] * x.w[2][i] +
                            sums[12 + c] * x.w[3][i];
        to[c] = std::min(std::max(color, 0.F), 255.F);
      }
    }
  }
}

const char* InstructionSet() { return hwy::TargetName(HWY_TARGET); }

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(ProjectPoints);
HWY_EXPORT(SeePoints);
HWY_EXPORT(ReadColors);
HWY_EXPORT(InstructionSet);

PhotoCamera photo_camera(const CameraBlock& b, const SceneTile& tile) {
  PhotoCamera c{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column)
      c.cam_from_world[4 * row + column] = b.cam_from_world[4 * column + row];
  c.center = {b.center[0], b.center[1], b.center[2]};
  c.fx = b.intrinsics[0];
  c.fy = b.intrinsics[1];
  c.cx = b.intrinsics[2];
  c.cy = b.intrinsics[3];
  c.skew = b.lens_more[1];
  c.lens = static_cast<int>(b.lens_more[3]);
  c.k = {b.lens[0], b.lens[1], b.lens[2], b.lens[3], b.lens_more[0]};
  c.below = {b.lens_below[0], b.lens_below[1], b.lens_below[2]};
  c.rational = c.below != std::array<float, 3>{};
  c.largest_r2 = b.lens_more[2];
  c.width = b.image[0];
  c.height = b.image[1];
  c.tile_x = b.tile[0];
  c.tile_y = b.tile[1];
  c.tile_width = b.tile[2];
  c.tile_height = b.tile[3];
  c.tile = tile.at(0, 0);
  c.tile_stride = tile.stride();
  c.depth_place = b.depth;
  return c;
}

void project_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points, float* u,
                    float* v, std::int32_t* inside) {
  HWY_DYNAMIC_DISPATCH(ProjectPoints)(camera, rays, points, u, v, inside);
}

void see_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                const Normals& normals, float tolerance, float* u, float* v, std::int32_t* seen,
                float* angular, const MatteSums& mattes) {
  HWY_DYNAMIC_DISPATCH(SeePoints)(camera, rays, points, normals, tolerance, u, v, seen, angular, mattes);
}

void read_colors(const PhotoCamera& camera, bool sharp, const float* u, const float* v,
                 const std::int32_t* wanted, int count, float* rgba) {
  HWY_DYNAMIC_DISPATCH(ReadColors)(camera, sharp, u, v, wanted, count, rgba);
}

const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(InstructionSet)(); }

}  // namespace floatstage::render::cpu
#endif
