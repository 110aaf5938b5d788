#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace floatstage::synthetic {

/// Hash of a lattice point, uniform in [0, 1).
float lattice(int x, int y, int z, std::uint32_t seed);

/// Smooth value noise with one random number a lattice point: range [0, 1], mean 0.5, period of detail 1.
float value_noise(const Eigen::Vector3f& p, std::uint32_t seed);

/// 0 below `edge`, 1 above, a ramp of width `width` between: a step seen through a pixel of that size.
float soft_step(float edge, float x, float width);

/// A stripe pattern (1 on the first `duty` of each `period`) averaged over a window of `width`: exact, so it
/// fades to its mean instead of aliasing when the window outgrows the period.
float stripes(float x, float period, float duty, float width);

}  // namespace floatstage::synthetic
