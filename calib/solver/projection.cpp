#include "calib/solver/projection.h"

#include <cmath>

namespace floatstage::calib::solver {
namespace {

// A point on the plane z = 1 after the lens, its derivative by the point before it, and by the lens'
// coefficients.
struct Bent {
  Eigen::Vector2d point;
  Eigen::Matrix2d by_point;
  Eigen::Matrix<double, 2, kLensRows> by_lens;
};

// The denominator must not reach 0 on the way to r2: beyond it a picture would come back from infinity.
bool is_before_pole(const Intrinsics& in, double r2) {
  const double k4 = in[9], k5 = in[10], k6 = in[11];
  if (k4 == 0 && k5 == 0 && k6 == 0) return true;
  constexpr int kSteps = 4;
  constexpr double kNearest = 1e-3;
  for (int i = 1; i <= kSteps; ++i)
    if (const double q = r2 * i / kSteps; !(1 + q * (k4 + q * (k5 + q * k6)) > kNearest)) return false;
  return true;
}

template <Slopes kSlopes>
Bent brown(const Intrinsics& in, double x, double y) {
  const double k1 = in[4], k2 = in[5], p1 = in[6], p2 = in[7], k3 = in[8], k4 = in[9], k5 = in[10],
               k6 = in[11];
  const double r2 = x * x + y * y, r4 = r2 * r2;
  const double below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6)), by_k = 1 / below;
  const double radial = by_k * (1 + r2 * (k1 + r2 * (k2 + r2 * k3)));
  Bent b;
  b.point = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  if (kSlopes == Slopes::None) return b;
  const double slope = by_k * (k1 + r2 * (2 * k2 + 3 * r2 * k3) -
                               radial * (k4 + r2 * (2 * k5 + 3 * r2 * k6)));  // of radial by r2
  const double cross = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  b.by_point << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, cross, cross,
      radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  if (kSlopes == Slopes::ByPoint) return b;
  const double by_below = -radial * by_k;
  const Eigen::Matrix<double, 1, 3> powers = Eigen::RowVector3d(r2, r4, r4 * r2);
  const Eigen::Vector2d p(x, y);
  b.by_lens.leftCols<2>() = by_k * p * powers.head<2>();
  b.by_lens.middleCols<2>(2) << 2 * x * y, r2 + 2 * x * x, r2 + 2 * y * y, 2 * x * y;
  b.by_lens.col(4) = by_k * powers[2] * p;
  b.by_lens.rightCols<3>() = by_below * p * powers;
  return b;
}

template <Slopes kSlopes>
Bent fisheye(const Intrinsics& in, double x, double y) {
  const double r = std::hypot(x, y);
  Bent b;
  if (kSlopes == Slopes::All) b.by_lens.setZero();
  if (r < 1e-9) {  // the limit: no bending on the axis
    b.point = {x, y};
    b.by_point.setIdentity();
    return b;
  }
  const double theta = std::atan(r), q = theta * theta;
  const double bent = theta * (1 + q * (in[4] + q * (in[5] + q * (in[6] + q * in[7]))));
  const Eigen::Vector2d n(x / r, y / r);
  b.point = bent * n;
  if (kSlopes == Slopes::None) return b;
  const double slope =
      (1 + q * (3 * in[4] + q * (5 * in[5] + q * (7 * in[6] + q * 9 * in[7])))) / (1 + r * r);  // by r
  b.by_point = (bent / r) * Eigen::Matrix2d::Identity() + (slope - bent / r) * n * n.transpose();
  if (kSlopes == Slopes::ByPoint) return b;
  double power = theta * q;
  for (int i = 0; i < 4; ++i, power *= q) b.by_lens.col(i) = power * n;
  return b;
}

}  // namespace

int coefficient_count(LensKind lens) {
  return lens == LensKind::BrownConrady ? kLensRows : lens == LensKind::KannalaBrandt ? 4 : 0;
}

Intrinsics pack(const CameraModel& m) {
  Intrinsics v = Intrinsics::Zero();
  v.head<4>() << m.fx, m.fy, m.cx, m.cy;
  if (const auto* b = std::get_if<BrownConrady>(&m.lens))
    v.segment<kLensRows>(kLensRow) << b->k1, b->k2, b->p1, b->p2, b->k3, b->k4, b->k5, b->k6;
  if (const auto* f = std::get_if<KannalaBrandt>(&m.lens))
    v.segment<4>(kLensRow) << f->k1, f->k2, f->k3, f->k4;
  v[kSkewRow] = m.skew;
  return v;
}

CameraModel unpack(const Intrinsics& v, LensKind lens, int width, int height) {
  CameraModel m{.width = width,
                .height = height,
                .fx = v[0],
                .fy = v[1],
                .cx = v[2],
                .cy = v[3],
                .skew = v[kSkewRow],
                .lens = {}};
  if (lens == LensKind::BrownConrady) {
    const auto k = v.segment<kLensRows>(kLensRow);
    m.lens = BrownConrady{k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7]};
  }
  if (lens == LensKind::KannalaBrandt) m.lens = KannalaBrandt{v[4], v[5], v[6], v[7]};
  return m;
}

template <Slopes kSlopes>
bool project(const Intrinsics& in, LensKind lens, const Eigen::Vector3d& p, Projected& out) {
  constexpr double kNearest = 1e-6;  // metres
  if (!(p.z() > kNearest)) return false;
  const double inverse = 1 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
  Bent bent;
  if (lens == LensKind::BrownConrady) {
    if (!is_before_pole(in, x * x + y * y)) return false;
    bent = brown<kSlopes>(in, x, y);
  } else if (lens == LensKind::KannalaBrandt) {
    bent = fisheye<kSlopes>(in, x, y);
  } else {
    bent.point = {x, y};
    bent.by_point.setIdentity();
    if (kSlopes == Slopes::All) bent.by_lens.setZero();
  }
  Eigen::Matrix2d k;
  k << in[0], in[kSkewRow], 0, in[1];
  out.pixel = k * bent.point + Eigen::Vector2d(in[2], in[3]);
  if (kSlopes == Slopes::None) return true;
  Eigen::Matrix<double, 2, 3> plane_by_point;
  plane_by_point << inverse, 0, -x * inverse, 0, inverse, -y * inverse;
  out.by_point = k * bent.by_point * plane_by_point;
  if (kSlopes == Slopes::ByPoint) return true;
  out.by_intrinsics.leftCols<4>() << bent.point.x(), 0, 1, 0, 0, bent.point.y(), 0, 1;
  out.by_intrinsics.middleCols<kLensRows>(kLensRow) = k * bent.by_lens;
  out.by_intrinsics.col(kSkewRow) << bent.point.y(), 0;
  return true;
}

template bool project<Slopes::None>(const Intrinsics&, LensKind, const Eigen::Vector3d&, Projected&);
template bool project<Slopes::ByPoint>(const Intrinsics&, LensKind, const Eigen::Vector3d&, Projected&);
template bool project<Slopes::All>(const Intrinsics&, LensKind, const Eigen::Vector3d&, Projected&);

}  // namespace floatstage::calib::solver
