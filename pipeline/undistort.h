#pragma once

#include "core/camera.h"
#include "core/image.h"

namespace floatstage::pipeline {

/// The picture that pinhole(model) would have taken: each pixel is looked up through the lens by bicubic
/// interpolation (Catmull-Rom; rings are clamped to 0…255). A picture of a camera without a lens comes back
/// as it is. Pixels that the photograph does not show are 0.
Image undistorted(const Image& photograph, const CameraModel& model);

/// A camera of the same size without lens and skew, which other programs' pinholes are.
CameraModel straight(CameraModel model);

/// The picture of one camera as another at the same place would have taken it, by the same look-up. `to` has
/// no lens. Where both are one camera the picture comes back as it is.
Image retaken(const Image& photograph, const CameraModel& from, const CameraModel& to);

}  // namespace floatstage::pipeline
