#include "tests/calib/temple_scene.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "core/png.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {

TempleScene temple_scene(const std::filesystem::path& folder, const char* par) {
  TempleScene scene;
  const Result<ForeignRig> foreign = read_middlebury(folder / par);
  EXPECT_THAT(foreign, IsOk());
  for (std::size_t i = 0; i < foreign->rig.cameras.size(); ++i) {
    RigCamera camera = foreign->rig.cameras[i];
    const std::filesystem::path file = folder / foreign->image_names[i];
    if (!std::filesystem::exists(file)) continue;
    camera.model.width = 640, camera.model.height = 480;
    camera.serial = file.stem().string();
    Result<Image> pixels = load_png(file);
    EXPECT_THAT(pixels, IsOk());
    scene.pictures.push_back({camera.serial, file, camera.model, *std::move(pixels)});
    scene.truth.cameras.push_back(std::move(camera));
  }
  return scene;
}

CenterErrors center_errors(const Rig& rig, const Rig& truth) {
  const Eigen::Index n = static_cast<Eigen::Index>(rig.cameras.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = rig.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
    b.col(i) = truth.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(a, b);
  const Eigen::Matrix3Xd moved =
      (similarity.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(similarity.topRightCorner<3, 1>());
  const double radius = (b.colwise() - focus_point(truth)).colwise().norm().mean();
  const Eigen::VectorXd errors = (moved - b).colwise().norm();
  return {100 * errors.mean() / radius,
          100 * std::sqrt(errors.squaredNorm() / static_cast<double>(n)) / radius,
          100 * errors.maxCoeff() / radius};
}

}  // namespace floatstage::calib
