#include "calib/formats/colmap_cameras.h"

#include <algorithm>

#include "calib/formats/camera_parts.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr auto kOrigin = PixelOrigin::ImageCorner;
constexpr long kLargestImage = 1 << 20;  // px a side; more is a damaged file

constexpr std::array kModels{ColmapCameraModel{0, "SIMPLE_PINHOLE", 1, 0},
                             ColmapCameraModel{1, "PINHOLE", 2, 0},
                             ColmapCameraModel{2, "SIMPLE_RADIAL", 1, 1},
                             ColmapCameraModel{3, "RADIAL", 1, 2},
                             ColmapCameraModel{4, "OPENCV", 2, 4},
                             ColmapCameraModel{5, "OPENCV_FISHEYE", 2, 4},
                             ColmapCameraModel{6, "FULL_OPENCV", 2, 8},
                             ColmapCameraModel{7, "FOV", 2, 1, false},
                             ColmapCameraModel{8, "SIMPLE_RADIAL_FISHEYE", 1, 1},
                             ColmapCameraModel{9, "RADIAL_FISHEYE", 1, 2},
                             ColmapCameraModel{10, "THIN_PRISM_FISHEYE", 2, 8, false}};

Lens lens_of(std::string_view model, const std::vector<double>& c) {
  if (c.empty()) return Lens{};
  if (model == "OPENCV_FISHEYE") return KannalaBrandt{c[0], c[1], c[2], c[3]};
  if (model == "SIMPLE_RADIAL_FISHEYE") return KannalaBrandt{.k1 = c[0]};
  if (model == "RADIAL_FISHEYE") return KannalaBrandt{.k1 = c[0], .k2 = c[1]};
  if (model == "SIMPLE_RADIAL") return BrownConrady{.k1 = c[0]};
  if (model == "RADIAL") return BrownConrady{.k1 = c[0], .k2 = c[1]};
  if (model == "OPENCV") return BrownConrady{c[0], c[1], c[2], c[3]};
  return BrownConrady{c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]};
}

template <class Fits>
const ColmapCameraModel* find(const Fits& fits) {
  const auto* const found = std::find_if(kModels.begin(), kModels.end(), fits);
  return found == kModels.end() ? nullptr : found;
}

}  // namespace

const ColmapCameraModel* colmap_model_named(std::string_view name) {
  return find([&](const ColmapCameraModel& m) { return m.name == name; });
}

const ColmapCameraModel* colmap_model_numbered(std::int32_t id) {
  return find([&](const ColmapCameraModel& m) { return m.id == id; });
}

Result<CameraModel> camera_from_colmap(const ColmapCameraModel& shape, long width, long height,
                                       const std::vector<double>& p) {
  if (!shape.readable)
    return fail(ErrorCode::Unsupported, text("the camera model ", shape.name,
                                             " is not supported; convert the model to OPENCV or "
                                             "OPENCV_FISHEYE"));
  if (width < 1 || height < 1 || width > kLargestImage || height > kLargestImage)
    return fail(ErrorCode::BadData, "the image size is not a pair of positive whole numbers");
  CameraModel model;
  model.width = static_cast<int>(width);
  model.height = static_cast<int>(height);
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = p[0];
  k(1, 1) = p[shape.focals - 1];
  k(0, 2) = p[shape.focals];
  k(1, 2) = p[shape.focals + 1];
  if (Result<void> ok = set_k(model, k, kOrigin); !ok) return forward(ok);
  model.lens = lens_of(shape.name, {p.begin() + static_cast<std::ptrdiff_t>(shape.focals + 2), p.end()});
  return model;
}

ColmapCamera camera_to_colmap(const CameraModel& m) {
  const auto* brown = std::get_if<BrownConrady>(&m.lens);
  const auto* fisheye = std::get_if<KannalaBrandt>(&m.lens);
  std::vector<double> p{m.fx, m.fy, from_corner_origin(m.cx, kOrigin), from_corner_origin(m.cy, kOrigin)};
  if (fisheye) {
    p.insert(p.end(), {fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4});
    return {colmap_model_named("OPENCV_FISHEYE"), std::move(p)};
  }
  if (!brown) return {colmap_model_named("PINHOLE"), std::move(p)};
  p.insert(p.end(), {brown->k1, brown->k2, brown->p1, brown->p2});
  if (brown->k3 == 0 && !brown->rational()) return {colmap_model_named("OPENCV"), std::move(p)};
  p.insert(p.end(), {brown->k3, brown->k4, brown->k5, brown->k6});
  return {colmap_model_named("FULL_OPENCV"), std::move(p)};
}

}  // namespace floatstage::calib
