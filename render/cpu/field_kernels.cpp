// Where a photograph shows what its fields move onto points of the view's surface: Eq. 11.4 of M. Eisemann,
// Error-Concealed Image-Based Rendering. What photograph i shows at p stands, seen from everywhere else, at
// p + sum_j v_j W_ij(p); that which stands at q is found by iteration from p = q.
#include "render/cpu/field_kernels.h"

#include <algorithm>

#include "core/instruction_sets.h"
#include "render/camera_fields.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/field_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>

#include "render/cpu/photo_geometry-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

constexpr int kInversions = 2;  // render/gl/shaders/static.comp has the same

struct Moved {
  VF x, y;
};

/// The fields' sum at a place of the grid, bilinear.
HWY_INLINE Moved combined(const FieldPulls& fields, std::size_t i, VF gx, VF gy) {
  const F d;
  const I di;
  const VF x = held(hn::Sub(gx, all(0.5F)), 0, static_cast<float>(fields.width - 1));
  const VF y = held(hn::Sub(gy, all(0.5F)), 0, static_cast<float>(fields.height - 1));
  const VI x0 = hn::Min(hn::ConvertTo(di, x), hn::Set(di, fields.width - 2));
  const VI y0 = hn::Min(hn::ConvertTo(di, y), hn::Set(di, fields.height - 2));
  const VF fx = hn::Sub(x, hn::ConvertTo(d, x0)), fy = hn::Sub(y, hn::ConvertTo(d, y0));
  const VI at = hn::Add(hn::Mul(y0, hn::Set(di, fields.width)), x0);
  const VF rest_x = hn::Sub(all(1), fx), rest_y = hn::Sub(all(1), fy);
  const VF weight[4] = {hn::Mul(rest_x, rest_y), hn::Mul(fx, rest_y), hn::Mul(rest_x, fy), hn::Mul(fx, fy)};
  VF u = all(0), v = all(0);
  for (int n = 0; n < fields.count; ++n) {
    const auto* texels = reinterpret_cast<const std::int32_t*>(fields.uv[static_cast<std::size_t>(n)]);
    const VF pull = hn::LoadU(d, fields.pulls[static_cast<std::size_t>(n)] + i);
    VF fu = all(0), fv = all(0);
    for (int k = 0; k < 4; ++k) {
      const VI both = hn::GatherIndex(di, texels + (k & 1) + (k >> 1) * fields.width, at);
      fu = hn::MulAdd(weight[k], hn::ConvertTo(d, hn::ShiftRight<16>(hn::ShiftLeft<16>(both))), fu);
      fv = hn::MulAdd(weight[k], hn::ConvertTo(d, hn::ShiftRight<16>(both)), fv);
    }
    u = hn::MulAdd(pull, fu, u);
    v = hn::MulAdd(pull, fv, v);
  }
  return {hn::Mul(u, all(CameraField::kStep)), hn::Mul(v, all(CameraField::kStep))};
}

void FloatPoints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                 const FieldPulls& fields, float* u, float* v, std::int32_t* inside, float* moved_x,
                 float* moved_y) {
  const F d;
  const I di;
  const auto& m = fields.place;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); i += hn::Lanes(d)) {
    const V3 w =
        world_points(rays, hn::LoadU(d, points.x + i), row_or(points, i), hn::LoadU(d, points.inverse_z + i));
    const V3 p = in_camera(camera, w);
    const VF inverse = hn::Div(all(1), p.z);
    const VF gx = hn::MulAdd(all(m[0]), hn::Mul(p.x, inverse), all(m[2]));
    const VF gy = hn::MulAdd(all(m[1]), hn::Mul(p.y, inverse), all(m[3]));
    Moved moved = combined(fields, i, gx, gy);
    for (int k = 1; k < kInversions; ++k)
      moved = combined(fields, i, hn::Sub(gx, moved.x), hn::Sub(gy, moved.y));
    hn::StoreU(moved.x, d, moved_x + i);
    hn::StoreU(moved.y, d, moved_y + i);
    const VF x = hn::NegMulAdd(moved.x, all(1 / m[0]), hn::Mul(p.x, inverse));
    const VF y = hn::NegMulAdd(moved.y, all(1 / m[1]), hn::Mul(p.y, inverse));
    VF pu, pv;
    const MF in = lens_pixel(camera, x, y, hn::Gt(p.z, all(0)), pu, pv);
    hn::StoreU(pu, d, u + i);
    hn::StoreU(pv, d, v + i);
    hn::StoreU(hn::IfThenElseZero(hn::RebindMask(di, in), hn::Set(di, 1)), di, inside + i);
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(FloatPoints);

void float_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                  const FieldPulls& fields, float* u, float* v, std::int32_t* inside, float* moved_x,
                  float* moved_y) {
  if (fields.count == 0) {
    std::fill_n(moved_x, points.count, 0.F);
    std::fill_n(moved_y, points.count, 0.F);
    project_points(camera, rays, points, u, v, inside);
    return;
  }
  HWY_DYNAMIC_DISPATCH(FloatPoints)(camera, rays, points, fields, u, v, inside, moved_x, moved_y);
}

}  // namespace floatstage::render::cpu
#endif
