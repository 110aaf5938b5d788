// The footprint of a view's pixel in a photograph: Eisemann, Error-Concealed Image-Based Rendering,
// Eq. 9.4-9.6, for perspective cameras: the derivative of the projection along the surface's tangent plane.
// The twin of render/gl/shaders/footprint.glsl. docs/adr/0262-footprints.md.
#include "render/cpu/footprint_kernels.h"

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/footprint_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, 16>;
using VF = hn::Vec<F>;

constexpr float kLeastFacing = 1e-3F;

struct V3 {
  VF x, y, z;
};
HWY_INLINE VF all(float v) { return hn::Set(F(), v); }

/// Rows of 3 in steps of `stride` times a vector.
HWY_INLINE V3 turned(const float* m, std::size_t stride, const V3& v) {
  auto row = [&](std::size_t i) HWY_ATTR {
    const float* r = m + stride * i;
    return hn::MulAdd(all(r[0]), v.x, hn::MulAdd(all(r[1]), v.y, hn::Mul(all(r[2]), v.z)));
  };
  return {row(0), row(1), row(2)};
}

void Footprints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                const Normals& normals, float* area) {
  const F d;
  const auto& m = rays.world_from_view;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); i += hn::Lanes(d)) {
    const VF py = points.y != nullptr ? hn::LoadU(d, points.y + i) : all(points.row_y);
    const VF ry = hn::Mul(hn::Sub(py, all(rays.cy)), all(rays.inverse_fy));
    const VF rx =
        hn::Mul(hn::NegMulAdd(all(rays.skew), ry, hn::Sub(hn::LoadU(d, points.x + i), all(rays.cx))),
                all(rays.inverse_fx));
    const VF z = hn::Div(all(1), hn::LoadU(d, points.inverse_z + i));
    const V3 ray = turned(m.data(), 3, {rx, ry, all(1)});
    const V3 n = {hn::LoadU(d, normals.x + i), hn::LoadU(d, normals.y + i), hn::LoadU(d, normals.z + i)};
    auto dot = [&](const V3& a, const V3& b)
                   HWY_ATTR { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); };
    const VF facing = hn::Div(all(1), hn::Min(dot(n, ray), all(-kLeastFacing)));
    // A step of the pixel, carried along the ray back onto the tangent plane, as the camera sees it.
    const V3 w = {hn::MulAdd(ray.x, z, all(rays.eye[0])), hn::MulAdd(ray.y, z, all(rays.eye[1])),
                  hn::MulAdd(ray.z, z, all(rays.eye[2]))};
    const float* c = camera.cam_from_world.data();
    V3 p = turned(c, 4, w);
    p = {hn::Add(p.x, all(c[3])), hn::Add(p.y, all(c[7])), hn::Add(p.z, all(c[11]))};
    const VF inverse = hn::Div(all(1), hn::Max(p.z, all(1e-6F)));
    const VF ax = hn::Mul(p.x, inverse), ay = hn::Mul(p.y, inverse);
    auto stepped = [&](float ex, float ey, VF& du, VF& dv) HWY_ATTR {
      const V3 e = {all(m[0] * ex + m[1] * ey), all(m[3] * ex + m[4] * ey), all(m[6] * ex + m[7] * ey)};
      const VF back = hn::Mul(dot(n, e), facing);
      const V3 on = {hn::NegMulAdd(back, ray.x, e.x), hn::NegMulAdd(back, ray.y, e.y),
                     hn::NegMulAdd(back, ray.z, e.z)};
      const V3 s = turned(c, 4, on);
      const VF scale = hn::Mul(z, inverse);
      du = hn::Mul(hn::Mul(all(camera.fx), scale), hn::NegMulAdd(ax, s.z, s.x));
      dv = hn::Mul(hn::Mul(all(camera.fy), scale), hn::NegMulAdd(ay, s.z, s.y));
    };
    VF ux, vx, uy, vy;
    stepped(rays.inverse_fx, 0, ux, vx);
    stepped(-rays.skew * rays.inverse_fy * rays.inverse_fx, rays.inverse_fy, uy, vy);
    // The smaller eigenvalue of J Jᵀ, without cancellation: det² over the larger.
    const VF a = hn::MulAdd(ux, ux, hn::Mul(uy, uy)), b = hn::MulAdd(ux, vx, hn::Mul(uy, vy)),
             e = hn::MulAdd(vx, vx, hn::Mul(vy, vy));
    const VF half = hn::Mul(all(0.5F), hn::Sub(a, e));
    const VF larger =
        hn::Add(hn::Mul(all(0.5F), hn::Add(a, e)), hn::Sqrt(hn::MulAdd(half, half, hn::Mul(b, b))));
    const VF det = hn::MulSub(ux, vy, hn::Mul(uy, vx));
    hn::StoreU(hn::Div(hn::Mul(det, det), hn::Max(larger, all(1e-12F))), d, area + i);
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(Footprints);

void footprints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                const Normals& normals, float* area) {
  HWY_DYNAMIC_DISPATCH(Footprints)(camera, rays, points, normals, area);
}

}  // namespace floatstage::render::cpu
#endif
