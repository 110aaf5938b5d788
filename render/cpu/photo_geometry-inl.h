// How points of the view's surface come to stand in photographs, in vectors. Included by files of kernels
// after <hwy/highway.h>, once an instruction set.
#if defined(FLOATSTAGE_RENDER_CPU_PHOTO_GEOMETRY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FLOATSTAGE_RENDER_CPU_PHOTO_GEOMETRY_INL_H
#undef FLOATSTAGE_RENDER_CPU_PHOTO_GEOMETRY_INL_H
#else
#define FLOATSTAGE_RENDER_CPU_PHOTO_GEOMETRY_INL_H
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "render/cpu/photo_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;

struct V3 {
  VF x, y, z;
};
HWY_INLINE VF dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE VF all(float v) { return hn::Set(F(), v); }
HWY_INLINE V3 world_points(const ViewRays& rays, VF px, VF py, VF inverse_z) {
  const VF z = hn::Div(all(1), inverse_z);
  const VF y = hn::Mul(hn::Sub(py, all(rays.cy)), all(rays.inverse_fy));
  const VF x = hn::Mul(hn::NegMulAdd(all(rays.skew), y, hn::Sub(px, all(rays.cx))), all(rays.inverse_fx));
  const auto& r = rays.world_from_view;
  auto row = [&](std::size_t i) HWY_ATTR {
    const VF way = hn::MulAdd(all(r[3 * i]), x, hn::MulAdd(all(r[3 * i + 1]), y, all(r[3 * i + 2])));
    return hn::MulAdd(way, z, all(rays.eye[i]));
  };
  return {row(0), row(1), row(2)};
}

HWY_INLINE V3 in_camera(const PhotoCamera& c, const V3& w) {
  auto row = [&](std::size_t i) HWY_ATTR {
    const float* m = c.cam_from_world.data() + 4 * i;
    return hn::MulAdd(all(m[0]), w.x, hn::MulAdd(all(m[1]), w.y, hn::MulAdd(all(m[2]), w.z, all(m[3]))));
  };
  return {row(0), row(1), row(2)};
}

/// The lens on a ray (x, y, 1); false where it folds back.
HWY_INLINE MF through_lens(const PhotoCamera& c, VF& x, VF& y) {
  const F d;
  const VF r2 = hn::MulAdd(x, x, hn::Mul(y, y));
  const auto& k = c.k;
  if (c.lens == 0) return hn::Eq(r2, r2);
  if (c.lens == 1) {
    VF radial = hn::MulAdd(r2, hn::MulAdd(r2, hn::MulAdd(r2, all(k[4]), all(k[1])), all(k[0])), all(1));
    if (c.rational) {
      const auto& b = c.below;
      const VF below =
          hn::MulAdd(r2, hn::MulAdd(r2, hn::MulAdd(r2, all(b[2]), all(b[1])), all(b[0])), all(1));
      radial = hn::Div(radial, below);
    }
    const VF xy = hn::Mul(x, y), xx = hn::Mul(x, x), yy = hn::Mul(y, y);
    const VF nx =
        hn::MulAdd(x, radial, hn::MulAdd(all(2 * k[2]), xy, hn::Mul(all(k[3]), hn::MulAdd(all(2), xx, r2))));
    const VF ny =
        hn::MulAdd(y, radial, hn::MulAdd(all(2 * k[3]), xy, hn::Mul(all(k[2]), hn::MulAdd(all(2), yy, r2))));
    x = nx;
    y = ny;
  } else {
    const VF r = hn::Sqrt(hn::Max(r2, all(1e-12F))), t = hn::Atan(d, r), q = hn::Mul(t, t);
    const VF poly = hn::MulAdd(
        q, hn::MulAdd(q, hn::MulAdd(q, hn::MulAdd(q, all(k[3]), all(k[2])), all(k[1])), all(k[0])), all(1));
    const VF scale = hn::IfThenElse(hn::Gt(r2, all(1e-12F)), hn::Div(hn::Mul(t, poly), r), all(1));
    x = hn::Mul(x, scale);
    y = hn::Mul(y, scale);
  }
  return hn::Le(r2, all(c.largest_r2));
}

/// Where the lens puts the ray (x, y, 1), and whether that is in the picture; `front`: what lies before it.
HWY_INLINE MF lens_pixel(const PhotoCamera& c, VF x, VF y, MF front, VF& u, VF& v) {
  const MF good = hn::And(through_lens(c, x, y), front);
  u = hn::IfThenElse(good, hn::MulAdd(all(c.fx), x, hn::MulAdd(all(c.skew), y, all(c.cx))), all(-1));
  v = hn::IfThenElse(good, hn::MulAdd(all(c.fy), y, all(c.cy)), all(-1));
  const MF right = hn::And(hn::Ge(u, all(0)), hn::Lt(u, all(c.width)));
  return hn::And(right, hn::And(hn::Ge(v, all(0)), hn::Lt(v, all(c.height))));
}

HWY_INLINE MF photo_pixel(const PhotoCamera& c, const V3& p, VF& u, VF& v) {
  const VF inverse = hn::Div(all(1), p.z);
  return lens_pixel(c, hn::Mul(p.x, inverse), hn::Mul(p.y, inverse), hn::Gt(p.z, all(0)), u, v);
}

/// In [low, high], also what is no number.
HWY_INLINE VF held(VF v, float low, float high) { return hn::Min(hn::Max(v, all(low)), all(high)); }

HWY_INLINE VF row_or(const PixelList& points, std::size_t i) {
  return points.y != nullptr ? hn::LoadU(F(), points.y + i) : all(points.row_y);
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
