#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace floatstage::synthetic {

/// Parts of the clothes may have the colour of the stage's green cloth: the right sleeve, and the lower shirt
/// in front. Other: a wine-red shirt, light trousers, dark shoes and hair.
enum class Dress { Usual, OfTheCloth, Other };

/// What a part of the performer is painted with.
enum class Material { Face, Skin, Hair, Shirt, Sleeve, Trousers, Hips, Shoe, Strand };

/// A point of the performer's surface, as a ray meets it.
struct SurfacePoint {
  Material material = Material::Skin;
  int variant = 0;  ///< Shirt…Shoe: +1 the right side, -1 the left; Strand: which colour
  Eigen::Vector3f rest = Eigen::Vector3f::Zero();  ///< metres, in the bone's rest coordinates
  float footprint = 0.001f;                        ///< metres on the surface that the ray stands for
};

/// Reflectance 0…1 in the picture's own (gamma) space, averaged over the footprint where the pattern is finer
/// than it.
Eigen::Vector3f albedo(const SurfacePoint& point, std::uint32_t seed, Dress dress = Dress::Usual);

/// The face, in head coordinates: eyes, brows, mouth, freckles. Called by albedo().
Eigen::Vector3f face_albedo(const Eigen::Vector3f& rest, float footprint, std::uint32_t seed);
Eigen::Vector3f skin_albedo(const Eigen::Vector3f& rest, float footprint, std::uint32_t seed);

/// Centre of the head in the head bone's coordinates.
inline const Eigen::Vector3f kHeadCenter(0, 0.015f, 0.135f);

}  // namespace floatstage::synthetic
