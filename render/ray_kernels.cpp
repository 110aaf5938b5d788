#include "render/ray_kernels.h"

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/ray_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, kRayLanes>;
using V = hn::Vec<D>;

struct Rays {
  V x, y, z;
};

/// Of some rays, from `from`: the vector to each.
HWY_INLINE Rays difference(const double* rays, std::size_t count, std::size_t first,
                           const Eigen::Vector3d& from) {
  const D d;
  return {hn::Sub(hn::LoadU(d, rays + first), hn::Set(d, from.x())),
          hn::Sub(hn::LoadU(d, rays + count + first), hn::Set(d, from.y())),
          hn::Sub(hn::LoadU(d, rays + 2 * count + first), hn::Set(d, from.z()))};
}

// Rounded as Eigen rounds it, on every instruction set.
HWY_INLINE V length(const Rays& r) {
  return hn::Sqrt(hn::Add(hn::Mul(r.x, r.x), hn::Add(hn::Mul(r.y, r.y), hn::Mul(r.z, r.z))));
}

void UnitRays(const Eigen::Vector3d& point, const double* places, std::size_t count, double* rays) {
  const D d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Rays way = difference(places, count, i, point);
    const V far = length(way), scale = hn::IfThenElse(hn::Gt(far, hn::Zero(d)), far, hn::Set(d, 1.0));
    hn::StoreU(hn::Div(way.x, scale), d, rays + i);
    hn::StoreU(hn::Div(way.y, scale), d, rays + count + i);
    hn::StoreU(hn::Div(way.z, scale), d, rays + 2 * count + i);
  }
}

// By the chord between the rays' ends, which keeps its digits where they nearly coincide.
void AddAngles(const Eigen::Vector3d& ray, double weight, const double* rays, std::size_t count,
               double* sums) {
  const D d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V half_chord = hn::Mul(hn::Set(d, 0.5), length(difference(rays, count, i, ray)));
    const V half_angle = hn::Asin(d, hn::Min(hn::Set(d, 1.0), half_chord));
    hn::StoreU(hn::Add(hn::LoadU(d, sums + i), hn::Mul(hn::Set(d, weight), half_angle)), d, sums + i);
  }
}

}  // namespace
}  // namespace floatstage::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render {

HWY_EXPORT(UnitRays);
HWY_EXPORT(AddAngles);

void unit_rays(const Eigen::Vector3d& point, const double* places, std::size_t count, double* rays) {
  HWY_DYNAMIC_DISPATCH(UnitRays)(point, places, count, rays);
}

void add_angles(const Eigen::Vector3d& ray, double weight, const double* rays, std::size_t count,
                double* sums) {
  HWY_DYNAMIC_DISPATCH(AddAngles)(ray, weight, rays, count, sums);
}

}  // namespace floatstage::render
#endif
