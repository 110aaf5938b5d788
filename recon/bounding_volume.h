#pragma once

#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::recon {

/// The box around the intersection of the silhouettes' bounding pyramids (in the world, metres): every
/// camera's subject lies in a rectangle of its image, whose sides, undistorted, are four planes through the
/// camera.
///
/// Outside an image is unknown. Where a subject is cut by the image's border, that side bounds nothing, and
/// neither do the two neighbouring sides, which only hold inside the image (a man cut at the waist may stand
/// with his legs apart). Only when this leaves the volume unbounded, what lies outside the images is given
/// up: then all four sides of every subject that does not fill its image count. An empty matte, and one
/// without subject, gives no plane. Absent when the pyramids bound nothing; an empty box when they have no
/// point in common. mattes[i] belongs to rig.cameras[i] and is empty or of its size.
std::optional<Eigen::AlignedBox3d> bounding_volume(const Rig& rig, std::span<const Matte> mattes);

/// Whether any pixel is subject (alpha >= 128); stops at the first.
bool has_subject(const Matte& matte);

/// The rectangle, in pixels, of all pixels with any subject at all (alpha >= 128); empty when there is none.
Eigen::AlignedBox2i subject_rectangle(const Matte& matte);

}  // namespace floatstage::recon
