#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/result.h"

namespace floatstage::calib {

/// COLMAP's camera models, by the number that binary files and databases have for them
/// (src/base/camera_models.h of COLMAP 3.8). Both kinds of files hold a model's parameters in one order.
struct ColmapCameraModel {
  std::int32_t id;
  std::string_view name;
  std::size_t focals;  ///< 1 or 2
  std::size_t lens;    ///< coefficients after the principal point
  bool readable = true;

  std::size_t parameters() const { return focals + 2 + lens; }
};

/// All of them, those without a lens of ours too. Null: there is no such model.
const ColmapCameraModel* colmap_model_named(std::string_view name);
const ColmapCameraModel* colmap_model_numbered(std::int32_t id);

/// `parameters` as many as the model has. Unsupported for a lens that Floatstage does not have, BadData for
/// an impossible K; the caller says where.
Result<CameraModel> camera_from_colmap(const ColmapCameraModel& model, long width, long height,
                                       const std::vector<double>& parameters);

/// The model that holds a camera without skew, and its parameters.
struct ColmapCamera {
  const ColmapCameraModel* model = nullptr;
  std::vector<double> parameters;
};
ColmapCamera camera_to_colmap(const CameraModel& camera);

}  // namespace floatstage::calib
