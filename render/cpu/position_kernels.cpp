// Position weights: what is blended stands where the surface is, however wrong the proxy's depth, to first
// order. Extends Eq. 11.3 of the thesis, which places by the angular weights; ADR 190.
#include "render/cpu/position_kernels.h"

#include <algorithm>
#include <cmath>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/position_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

constexpr int kBlock = 16;          // lists are padded to it
constexpr float kSteady = 0.02F;    // of the trace: keeps weights finite where cameras stand on one line
constexpr float kTakenBack = 0.5F;  // of a displacement, how much of what an error of depth does not explain

struct Block {
  float v[kBlock];
};

// Compilers make no vectors of std::sqrt, which may have to set errno.
HWY_INLINE void take_roots(float* values, std::size_t count) {
  using D = HWY_CAPPED(float, kBlock);
  const D d;
  for (std::size_t k = 0; k < count; k += hwy::HWY_NAMESPACE::Lanes(d))
    hwy::HWY_NAMESPACE::StoreU(hwy::HWY_NAMESPACE::Sqrt(hwy::HWY_NAMESPACE::LoadU(d, values + k)), d,
                               values + k);
}

// Parallax of camera j at the block's pixels, in units of the view's picture plane at z = 1.
HWY_INLINE void parallax(const ViewRays& rays, const std::array<float, 3>& center, const PositionRow& row,
                         int begin, const Block& nx, const Block& ny, const Block& nz, Block& ux, Block& uy) {
  const float ry = (row.y - rays.cy) * rays.inverse_fy;
  Block facing, far;
  for (int k = 0; k < kBlock; ++k) {
    const int i = begin + k;
    const float rx = (row.x[i] - rays.cx - rays.skew * ry) * rays.inverse_fx, z = 1 / row.inverse_z[i];
    const float dx = rx * z - center[0], dy = ry * z - center[1], dz = z - center[2];
    facing.v[k] = nx.v[k] * dx + ny.v[k] * dy + nz.v[k] * dz;
    far.v[k] = dx * dx + dy * dy + dz * dz;
  }
  take_roots(far.v, kBlock);
  for (int k = 0; k < kBlock; ++k) {
    const float rx = (row.x[begin + k] - rays.cx - rays.skew * ry) * rays.inverse_fx;
    const float scale = 1 / std::min(facing.v[k], -kGrazing * far.v[k]);
    ux.v[k] = (center[0] - rx * center[2]) * scale;
    uy.v[k] = (center[1] - ry * center[2]) * scale;
  }
}

// The row's normals in the view's coordinates.
HWY_INLINE void turn_normals(const ViewRays& rays, const Normals& n, int begin, Block& x, Block& y,
                             Block& z) {
  const std::array<float, 9>& m = rays.world_from_view;
  for (int k = 0; k < kBlock; ++k) {
    const float a = n.x[begin + k], b = n.y[begin + k], c = n.z[begin + k];
    x.v[k] = m[0] * a + m[3] * b + m[6] * c;
    y.v[k] = m[1] * a + m[4] * b + m[7] * c;
    z.v[k] = m[2] * a + m[5] * b + m[8] * c;
  }
}

void PositionWeights(const ViewRays& rays, const CentersInView& centers, const PositionRow& row) {
  const auto cameras = static_cast<std::size_t>(row.cameras);
  Block nx, ny, nz, ux[kMostListed], uy[kMostListed];
  for (int begin = 0; begin < row.count; begin += kBlock) {
    turn_normals(rays, row.normals, begin, nx, ny, nz);
    Block sx{}, sy{}, xx{}, xy{}, yy{};
    for (std::size_t j = 0; j < cameras; ++j) {
      parallax(rays, centers[j], row, begin, nx, ny, nz, ux[j], uy[j]);
      const float* w = row.share[j] + begin;
      for (int k = 0; k < kBlock; ++k) {
        const float wx = w[k] * ux[j].v[k], wy = w[k] * uy[j].v[k];
        sx.v[k] += wx;
        sy.v[k] += wy;
        xx.v[k] += wx * ux[j].v[k];
        xy.v[k] += wx * uy[j].v[k];
        yy.v[k] += wy * uy[j].v[k];
      }
    }
    Block qx, qy, total{};
    for (int k = 0; k < kBlock; ++k) {
      const float steady = kSteady * (xx.v[k] + yy.v[k]), a = xx.v[k] + steady, b = yy.v[k] + steady;
      const float determinant = a * b - xy.v[k] * xy.v[k];
      const float scale = determinant > 0 ? 1 / determinant : 0;
      qx.v[k] = scale * (b * sx.v[k] - xy.v[k] * sy.v[k]);
      qy.v[k] = scale * (a * sy.v[k] - xy.v[k] * sx.v[k]);
    }
    // None is negative; the others share what is left.
    for (std::size_t j = 0; j < cameras; ++j) {
      float* w = row.share[j] + begin;
      for (int k = 0; k < kBlock; ++k) {
        w[k] *= std::max(0.F, 1 - qx.v[k] * ux[j].v[k] - qy.v[k] * uy[j].v[k]);
        total.v[k] += w[k];
      }
    }
    for (std::size_t j = 0; j < cameras; ++j) {
      float* w = row.share[j] + begin;
      for (int k = 0; k < kBlock; ++k) w[k] /= total.v[k];
    }
  }
}

void ParallaxesOfRow(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                     const std::array<float*, kMostListed>& x, const std::array<float*, kMostListed>& y) {
  Block nx, ny, nz, ux, uy;
  for (int begin = 0; begin < row.count; begin += kBlock) {
    turn_normals(rays, row.normals, begin, nx, ny, nz);
    for (std::size_t j = 0; j < static_cast<std::size_t>(row.cameras); ++j) {
      parallax(rays, centers[j], row, begin, nx, ny, nz, ux, uy);
      for (int k = 0; k < kBlock; ++k) {
        x[j][begin + k] = ux.v[k] / rays.inverse_fx + rays.skew * uy.v[k];
        y[j][begin + k] = uy.v[k] / rays.inverse_fy;
      }
    }
  }
}

void LeanOnDepth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                 const FetchedRow& fetched) {
  const auto cameras = static_cast<std::size_t>(row.cameras);
  Block nx, ny, nz, ux[kMostListed], uy[kMostListed], dx[kMostListed], dy[kMostListed];
  for (int begin = 0; begin < row.count; begin += kBlock) {
    turn_normals(rays, row.normals, begin, nx, ny, nz);
    Block mean_x{}, mean_y{};
    for (std::size_t j = 0; j < cameras; ++j) {
      parallax(rays, centers[j], row, begin, nx, ny, nz, ux[j], uy[j]);
      const float *v = row.share[j] + begin, *x = fetched.from_x[j] + begin, *y = fetched.from_y[j] + begin;
      for (int k = 0; k < kBlock; ++k) {
        mean_x.v[k] += v[k] * ux[j].v[k];
        mean_y.v[k] += v[k] * uy[j].v[k];
        dy[j].v[k] = (y[k] - row.y) * rays.inverse_fy;
        dx[j].v[k] = (x[k] - row.x[begin + k] - rays.skew * dy[j].v[k]) * rays.inverse_fx;
      }
    }
    // Displacements along their own parallaxes, against how long those are. By squares the widest parallax
    // would decide, of the camera that shows least of what is seen from here.
    Block along{}, length{}, depth;
    for (std::size_t j = 0; j < cameras; ++j) {
      const float* pull = fetched.pull[j] + begin;
      Block far;
      for (int k = 0; k < kBlock; ++k) {
        const float x = ux[j].v[k] - mean_x.v[k], y = uy[j].v[k] - mean_y.v[k];
        far.v[k] = x * x + y * y;
      }
      take_roots(far.v, kBlock);
      for (int k = 0; k < kBlock; ++k) {
        const float x = ux[j].v[k] - mean_x.v[k], y = uy[j].v[k] - mean_y.v[k];
        const float w = pull[k] < kFaintShare ? 0 : pull[k];
        along.v[k] += far.v[k] > 0 ? w * (x * dx[j].v[k] + y * dy[j].v[k]) / far.v[k] : 0;
        length.v[k] += w * far.v[k];
      }
    }
    for (int k = 0; k < kBlock; ++k) depth.v[k] = length.v[k] > 0 ? along.v[k] / length.v[k] : 0;
    for (std::size_t j = 0; j < cameras; ++j) {
      float *x = fetched.from_x[j] + begin, *y = fetched.from_y[j] + begin;
      for (int k = 0; k < kBlock; ++k) {
        const float rest_x = dx[j].v[k] - depth.v[k] * ux[j].v[k],
                    rest_y = dy[j].v[k] - depth.v[k] * uy[j].v[k];
        x[k] -= kTakenBack * (rest_x / rays.inverse_fx + rays.skew * rest_y);
        y[k] -= kTakenBack * rest_y / rays.inverse_fy;
      }
    }
  }
}

void PlaceAtDepth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                  std::span<const float> share, const float* displacement,
                  const std::array<float*, kMostListed>& from_x,
                  const std::array<float*, kMostListed>& from_y) {
  const auto cameras = static_cast<std::size_t>(row.cameras);
  Block nx, ny, nz, ux[kMostListed], uy[kMostListed], step;
  for (int begin = 0; begin < row.count; begin += kBlock) {
    turn_normals(rays, row.normals, begin, nx, ny, nz);
    Block apart{};
    float pairs = 0;
    for (std::size_t j = 0; j < cameras; ++j) {
      parallax(rays, centers[j], row, begin, nx, ny, nz, ux[j], uy[j]);
      for (int k = 0; k < kBlock; ++k) {
        ux[j].v[k] = ux[j].v[k] / rays.inverse_fx + rays.skew * uy[j].v[k];
        uy[j].v[k] /= rays.inverse_fy;
      }
      for (std::size_t i = 0; i < j; ++i) {
        const float both = share[i] * share[j];
        pairs += both;
        Block far;
        for (int k = 0; k < kBlock; ++k) {
          const float x = ux[i].v[k] - ux[j].v[k], y = uy[i].v[k] - uy[j].v[k];
          far.v[k] = x * x + y * y;
        }
        take_roots(far.v, kBlock);
        for (int k = 0; k < kBlock; ++k) apart.v[k] += both * far.v[k];
      }
    }
    for (int k = 0; k < kBlock; ++k)
      step.v[k] = apart.v[k] > 0 ? displacement[begin + k] * (pairs / apart.v[k]) : 0;
    for (std::size_t j = 0; j < cameras; ++j) {
      float *x = from_x[j] + begin, *y = from_y[j] + begin;
      for (int k = 0; k < kBlock; ++k) {
        x[k] = row.x[begin + k] + step.v[k] * ux[j].v[k];
        y[k] = row.y + step.v[k] * uy[j].v[k];
      }
    }
  }
}

void AddDistances(std::size_t count, float weight, const PlaneRow& a, const PlaneRow& b,
                  float* HWY_RESTRICT sums) {
  constexpr std::size_t kPiece = 256;
  float far[kPiece] = {};
  for (std::size_t begin = 0; begin < count; begin += kPiece) {
    const std::size_t pixels = std::min(kPiece, count - begin);
    for (std::size_t k = 0; k < pixels; ++k) {
      const float x = a.x[begin + k] - b.x[begin + k], y = a.y[begin + k] - b.y[begin + k];
      far[k] = x * x + y * y;
    }
    take_roots(far, kPiece);
    for (std::size_t k = 0; k < pixels; ++k) sums[begin + k] += weight * far[k];
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(PositionWeights);
HWY_EXPORT(ParallaxesOfRow);
HWY_EXPORT(LeanOnDepth);
HWY_EXPORT(PlaceAtDepth);
HWY_EXPORT(AddDistances);

std::array<float, 3> center_in_view(const ViewRays& rays, const std::array<float, 3>& center) {
  std::array<float, 3> out{};
  const std::array<float, 9>& m = rays.world_from_view;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t r = 0; r < 3; ++r) out[c] += m[3 * r + c] * (center[r] - rays.eye[r]);
  return out;
}

void position_weights(const ViewRays& rays, const CentersInView& centers, const PositionRow& row) {
  HWY_DYNAMIC_DISPATCH(PositionWeights)(rays, centers, row);
}

void parallaxes_of_row(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                       const std::array<float*, kMostListed>& x, const std::array<float*, kMostListed>& y) {
  HWY_DYNAMIC_DISPATCH(ParallaxesOfRow)(rays, centers, row, x, y);
}

void lean_on_depth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                   const FetchedRow& fetched) {
  HWY_DYNAMIC_DISPATCH(LeanOnDepth)(rays, centers, row, fetched);
}

void place_at_depth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                    std::span<const float> share, const float* displacement,
                    const std::array<float*, kMostListed>& from_x,
                    const std::array<float*, kMostListed>& from_y) {
  HWY_DYNAMIC_DISPATCH(PlaceAtDepth)(rays, centers, row, share, displacement, from_x, from_y);
}

void add_distances(std::size_t count, float weight, const PlaneRow& a, const PlaneRow& b, float* sums) {
  HWY_DYNAMIC_DISPATCH(AddDistances)(count, weight, a, b, sums);
}

}  // namespace floatstage::render::cpu
#endif
