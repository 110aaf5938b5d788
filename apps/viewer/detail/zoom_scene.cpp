#include "apps/viewer/detail/zoom_scene.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "detail/synthesis/enlarge.h"
#include "detail/synthesis/provenance.h"

namespace floatstage::apps {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Texture coordinates to pixels.
Matrix3d pixels_of(const Image& picture) {
  return Eigen::DiagonalMatrix<double, 3>(picture.width, picture.height, 1);
}

// The colours of a Provenance, as detail::provenance_picture() has them.
Vector3f color_of(detail::Provenance provenance) {
  Image one(1, 1, 1, static_cast<std::uint8_t>(provenance));
  const Image rgb = detail::provenance_picture(one);
  return Vector3f(rgb.pixels[0], rgb.pixels[1], rgb.pixels[2]) / 255;
}

}  // namespace

Result<ZoomScene> zoom_scene(const detail::ZoomLayers& layers) {
  ZoomScene scene;
  scene.width = layers.root.width;
  scene.height = layers.root.height;
  scene.provenance = {1, color_of(detail::Provenance::Upsampled), color_of(detail::Provenance::Warped), {}};
  std::vector<Image> pictures;
  std::vector<render::Zipmap::Patch> patches;
  for (const detail::ZoomLayer& layer : layers.layers) {
    Matrix3d patch_from_root =
        (layer.root_from_layer * pixels_of(layer.picture)).inverse() * pixels_of(layers.root);
    ZoomOutline outline{layer.name, layer.zoom, {}};
    for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)})
      outline.corners.push_back(
          (layer.root_from_layer * pixels_of(layer.picture) * corner.homogeneous()).hnormalized());
    // Before its horizon, wherever the homography's sign put it.
    const Vector2d middle =
        (layer.root_from_layer * pixels_of(layer.picture) * Vector3d(0.5, 0.5, 1)).hnormalized();
    const Vector3d there = patch_from_root * pixels_of(layers.root).inverse() * middle.homogeneous();
    patch_from_root /= there.z();
    patches.push_back({pictures.size(), patch_from_root});
    pictures.push_back(layer.picture);
    scene.outlines.push_back(std::move(outline));
    scene.provenance.patches.push_back(
        color_of(layer.moved ? detail::Provenance::Warped : detail::Provenance::Real));
  }
  Result<render::Zipmap> zipmap = render::Zipmap::make(layers.root, pictures, std::move(patches));
  if (!zipmap) return forward(zipmap);
  scene.zipmap = std::make_shared<const render::Zipmap>(std::move(*zipmap));
  return scene;
}

}  // namespace floatstage::apps
