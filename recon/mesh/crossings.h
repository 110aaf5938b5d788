#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace floatstage::recon {

/// Do two triangles pass through each other: does some edge of one pierce the inside of the other? Touching
/// (a common point, a corner on a face, coplanar overlap) is not crossing.
bool triangles_cross(const std::array<Eigen::Vector3d, 3>& a, const std::array<Eigen::Vector3d, 3>& b);

/// All pairs (i < j) of triangles that cross and share no vertex, in ascending order; at most `limit_each`
/// for one i, so that a hostile mesh cannot exhaust the memory. Found over a tree of boxes; the same answer
/// at any thread count.
std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(
    std::span<const Eigen::Vector3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
    std::size_t limit_each, int threads);

}  // namespace floatstage::recon
