// Somebody before a wall under a hard lamp, ray by ray, seen by cameras in an arc: his shadow on the wall is
// found there, and he, however dark he is and wherever he stands, is no wall.
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "core/random.h"
#include "matting/cast_shadows.h"

namespace floatstage::matting {
namespace {

// His foot hides one place of the floor from all, which looks like him to each.
enum class What : std::uint8_t { Stage, OnFloor, OnWall, Pillar, Foot };
constexpr double kFoot = 0.35;

struct Setting {
  double wall = 1.3;    // metres behind where cameras look
  double stands = 0;    // he, likewise
  double thick = 0.16;  // he is a pillar: its radius
  double arc = 1.4;     // radians, of all cameras
  bool lamp = true;     // hard, beside the cameras
  bool corner = false;  // another wall, to the right, and another lamp
};

class BeforeAWall {
 public:
  explicit BeforeAWall(const Setting& setting, int cameras = 6) : setting_(setting) {
    for (int k = 0; k < cameras; ++k) {
      const double turn = setting.arc * (k / (cameras - 1.0) - 0.5);
      const Eigen::Vector3d eye(3.2 * std::sin(turn), -3.2 * std::cos(turn), 1.2 + 0.3 * (k % 3));
      const Eigen::Vector3d ahead = (Eigen::Vector3d(0, 0, 0.9) - eye).normalized();
      const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
      RigCamera camera;
      camera.serial = "cam" + std::to_string(k);
      camera.model.width = 360;
      camera.model.height = 270;
      camera.model.fx = camera.model.fy = 255;
      camera.model.cx = 180;
      camera.model.cy = 135;
      Eigen::Matrix3d axes;
      axes << right, ahead.cross(right), ahead;
      camera.cam_from_world.rotation = Eigen::Quaterniond(axes.transpose());
      camera.cam_from_world.translation = -(camera.cam_from_world.rotation * eye);
      rig_.cameras.push_back(camera);
    }
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) shoot(i);
  }

  const Rig& rig() const { return rig_; }
  std::vector<CastShade> find(CastShadows& shadows, int threads = 2) const {
    std::vector<BeforeStage> before;
    for (std::size_t i = 0; i < pictures_.size(); ++i) before.push_back({&pictures_[i], &stages_[i]});
    return shadows.find(before, threads);
  }
  std::vector<CastShade> seek(CastShadows& shadows, int threads = 2) const {
    shadows.seek_planes();
    return find(shadows, threads);
  }
  // The share of the pixels that show this which are found to be shadows.
  double share(What what, const std::vector<CastShade>& found) const {
    double all = 0, shadow = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      for (std::size_t p = 0; p < what_[i].size(); ++p)
        if (what_[i][p] == what) ++all, shadow += found[i].mask[p] != 0;
    return shadow / all;
  }

 private:
  // Where a ray meets him, within so much of it.
  std::optional<Eigen::Vector3d> meets_him(const Eigen::Vector3d& from, const Eigen::Vector3d& along,
                                           double most) const {
    const double y = from.y() - setting_.stands;
    const double a = along.head<2>().squaredNorm(), b = from.x() * along.x() + y * along.y();
    const double c = from.x() * from.x() + y * y - setting_.thick * setting_.thick, root = b * b - a * c;
    if (root < 0) return std::nullopt;
    const double t = (-b - std::sqrt(root)) / a;
    const Eigen::Vector3d at = from + t * along;
    if (t > 0 && t < most && at.z() > 0 && at.z() < 1.7) return at;
    return std::nullopt;
  }

  void shoot(std::size_t number) {
    const RigCamera& camera = rig_.cameras[number];
    const CameraModel& m = camera.model;
    const Eigen::Vector3d eye = camera.cam_from_world.center(), lamp(-2.0, -1.8, 2.4), other(1.4, -2.2, 2.4);
    Image picture(m.width, m.height, 3), stage(m.width, m.height, 3);
    std::vector<What> what;
    Random random(number);
    for (int y = 0; y < m.height; ++y)
      for (int x = 0; x < m.width; ++x) {
        const Eigen::Vector3d along = camera.cam_from_world.rotation.conjugate() *
                                      unproject(m, {x + 0.5, y + 0.5}).value_or(Eigen::Vector3d::UnitZ());
        double far = along.y() > 0 ? (setting_.wall - eye.y()) / along.y() : 20;
        What on = What::OnWall;
        if (setting_.corner && along.x() > 0) far = std::min(far, (1.0 - eye.x()) / along.x());
        if (along.z() < 0 && -eye.z() / along.z() < far) far = -eye.z() / along.z(), on = What::OnFloor;
        const Eigen::Vector3d at = eye + far * along;
        const std::optional<Eigen::Vector3d> him = meets_him(eye, along, far);
        const bool shaded = setting_.lamp && (meets_him(at, lamp - at, 1) ||
                                              (setting_.corner && meets_him(at, other - at, 1)));
        what.push_back(him ? (him->z() < kFoot ? What::Foot : What::Pillar) : shaded ? on : What::Stage);
        const double light =
            (on == What::OnWall ? 170 : 140) + 8 * std::sin(5 * at.x()) * std::sin(4 * at.z());
        for (int c = 0; c < 3; ++c) {
          const double now = him ? 62 + 4 * c : shaded ? (0.45 + 0.05 * c) * light : light;
          stage.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(light + random.normal()));
          picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(now + random.normal()));
        }
      }
    pictures_.push_back(std::move(picture));
    stages_.push_back(std::move(stage));
    what_.push_back(std::move(what));
  }

  Setting setting_;
  Rig rig_;
  std::vector<Image> pictures_, stages_;
  std::vector<std::vector<What>> what_;
};

TEST(ShadedWalls, AreFoundWhenTheyAreSoughtAndStayWhereTheyAre) {
  const BeforeAWall stage({});
  CastShadows shadows(stage.rig());
  EXPECT_LT(stage.share(What::OnWall, stage.find(shadows)), 0.3);
  const std::vector<CastShade> found = stage.seek(shadows);
  ASSERT_EQ(shadows.walls().size(), 1u);
  EXPECT_GT(-shadows.walls()[0].normal.y(), std::cos(0.1));
  EXPECT_NEAR(shadows.walls()[0].offset, -1.3, 0.1);
  EXPECT_GT(stage.share(What::OnWall, found), 0.95);
  EXPECT_GT(stage.share(What::OnFloor, found), 0.9);
  EXPECT_LT(stage.share(What::Pillar, found), 0.05);
  EXPECT_LT(stage.share(What::Stage, found), 0.01);
  EXPECT_EQ(stage.find(shadows)[0].mask, found[0].mask);
  EXPECT_EQ(stage.seek(shadows, 1)[0].mask, found[0].mask) << "nor is there another one";
  EXPECT_EQ(shadows.walls().size(), 1u);
}

TEST(ShadedWalls, AreFoundInACornerWhereTwoLampsCastTwoShadows) {
  const BeforeAWall stage({.corner = true});
  CastShadows shadows(stage.rig());
  const std::vector<CastShade> found = stage.seek(shadows);
  EXPECT_GE(shadows.walls().size(), 1u);
  EXPECT_GT(stage.share(What::OnWall, found), 0.7);
  EXPECT_LT(stage.share(What::Pillar, found), 0.1);
}

TEST(ShadedWalls, AreNobodyInDarkClothesBehindWhereCamerasLook) {
  for (const auto& [arc, thick] : {std::pair{0.4, 0.15}, {1.4, 0.15}, {1.4, 0.3}}) {
    const BeforeAWall stage({.stands = 0.9, .thick = thick, .arc = arc, .lamp = false});
    CastShadows shadows(stage.rig());
    const std::vector<CastShade> found = stage.seek(shadows);
    EXPECT_TRUE(shadows.walls().empty()) << arc << " " << thick;
    EXPECT_LT(stage.share(What::Pillar, found), 0.25) << arc << " " << thick;
  }
}

TEST(ShadedWalls, AreTheSameAtAnyNumberOfThreads) {
  const BeforeAWall stage({});
  CastShadows one(stage.rig()), three(stage.rig());
  EXPECT_EQ(stage.seek(one, 1)[2].mask, stage.seek(three, 3)[2].mask);
  EXPECT_EQ(one.walls()[0].offset, three.walls()[0].offset);
}

}  // namespace
}  // namespace floatstage::matting
