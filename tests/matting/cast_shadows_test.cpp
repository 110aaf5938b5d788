// Somebody on a floor under a hard lamp, ray by ray: whose pixels are his shadow's, and whose are not.
#include "matting/cast_shadows.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage::matting {
namespace {

constexpr double kTall = 1.7, kThick = 0.2;     // metres: he is a pillar
constexpr double kUmbra[3] = {0.5, 0.6, 0.68};  // of the floor's light: a blue sky is left
constexpr double kTowards[2] = {0.8, 0.35};     // where his shadow falls, a metre of height
// His foot: that far up, cameras look at a place under him, which shows all of them his colour.
constexpr double kFoot = 0.3;
enum class What : std::uint8_t { Floor, Shadow, Pillar, Foot };

struct Ground {
  double height = 0;       // metres, which the rig takes for 0
  double texture = 0.2;    // 0: plain
  double noise = 1;        // 8-bit steps
  bool same_tint = false;  // what stands there has the colours of its shadow on a plain floor
};

// What one camera sees.
struct Seen {
  Image picture, stage;
  std::vector<What> what;
};

class UnderALamp {
 public:
  explicit UnderALamp(const Ground& floor, int cameras = 6, double lens = 0)
      : rig_(synthetic_rig({.cameras = cameras, .width = 240, .height = 180})), floor_(floor) {
    for (RigCamera& camera : rig_.cameras) {
      camera.model.fx = camera.model.fy = 130;  // they see the floor around him
      if (lens != 0) camera.model.lens = BrownConrady{.k1 = lens};
    }
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) seen_.push_back(shoot(rig_.cameras[i], i));
  }

  std::vector<CastShade> found(int threads = 2) const {
    std::vector<BeforeStage> before;
    for (const Seen& s : seen_) before.push_back({&s.picture, &s.stage});
    return CastShadows(rig_).find(before, threads);
  }
  // The share of the pixels that show this which are found to be shadows, in all cameras.
  double share(What what, const std::vector<CastShade>& found) const {
    double all = 0, shadow = 0;
    for (std::size_t i = 0; i < seen_.size(); ++i)
      for (std::size_t p = 0; p < seen_[i].what.size(); ++p)
        if (seen_[i].what[p] == what) ++all, shadow += found[i].width > 0 && found[i].mask[p] != 0;
    return shadow / all;
  }
  std::vector<Seen>& seen() { return seen_; }
  const Rig& rig() const { return rig_; }

 private:
  static bool in_pillar(double x, double y) { return std::hypot(x, y) < kThick; }
  // Whether the lamp's way to a place of the floor goes through him.
  static bool shaded(double x, double y) {
    for (double height = 0; height <= kTall; height += 0.02)
      if (in_pillar(x - height * kTowards[0], y - height * kTowards[1])) return true;
    return false;
  }

  double light_at(double x, double y) const {
    const double wave = std::sin(9 * x + 2) * std::sin(7 * y) + 0.5 * std::sin(31 * x - 17 * y);
    return 150 * (1 + floor_.texture * wave);
  }

  Seen shoot(const RigCamera& camera, std::size_t number) const {
    const CameraModel& m = camera.model;
    Seen seen{Image(m.width, m.height, 3), Image(m.width, m.height, 3), {}};
    Random random(17 + number);
    const Eigen::Vector3d eye = camera.cam_from_world.center();
    for (int y = 0; y < m.height; ++y)
      for (int x = 0; x < m.width; ++x) {
        const Eigen::Vector3d along = camera.cam_from_world.rotation.conjugate() *
                                      unproject(m, {x + 0.5, y + 0.5}).value_or(Eigen::Vector3d::UnitZ());
        const double far = (floor_.height - eye.z()) / along.z();
        What what = What::Floor;
        Eigen::Vector3d at = eye + 20 * along;
        if (far > 0 && far < 8) {
          at = eye + far * along;
          if (shaded(at.x(), at.y())) what = What::Shadow;
        }
        for (double s = 1; s < std::min(far > 0 ? far : 8.0, 8.0); s += 0.01) {
          const Eigen::Vector3d on_way = eye + s * along;
          if (on_way.z() < floor_.height + kTall && in_pillar(on_way.x(), on_way.y())) {
            what = on_way.z() < floor_.height + kFoot ? What::Foot : What::Pillar;
            break;
          }
        }
        seen.what.push_back(what);
        for (int c = 0; c < 3; ++c) {
          const double stage = far > 0 && far < 8 ? light_at(at.x(), at.y()) : 90;
          const double clothes = floor_.same_tint ? 150 * kUmbra[c] : 40 + 5 * c;
          const double now = what == What::Pillar || what == What::Foot ? clothes
                             : what == What::Shadow                     ? kUmbra[c] * stage
                                                                        : stage;
          const auto noisy = [&](double v) {
            return static_cast<std::uint8_t>(
                std::clamp(std::lround(v + floor_.noise * random.normal()), 0L, 255L));
          };
          seen.stage.at(x, y)[c] = noisy(stage);
          seen.picture.at(x, y)[c] = noisy(now);
        }
      }
    return seen;
  }

  Rig rig_;
  Ground floor_;
  std::vector<Seen> seen_;
};

TEST(CastShadows, AreToldFromWhoCastsThemHoweverDarkTheyAre) {
  const UnderALamp stage({});
  const std::vector<CastShade> found = stage.found();
  EXPECT_GT(stage.share(What::Shadow, found), 0.97);
  EXPECT_LT(stage.share(What::Pillar, found), 0.01);
  EXPECT_LT(stage.share(What::Floor, found), 0.005);
}

TEST(CastShadows, AreToldOnAPlainFloorFromClothesThatLookLikeThem) {
  const UnderALamp stage({.texture = 0, .same_tint = true});
  const std::vector<CastShade> found = stage.found();
  EXPECT_GT(stage.share(What::Shadow, found), 0.9);
  EXPECT_LT(stage.share(What::Pillar, found), 0.02);
}

TEST(CastShadows, AreFoundInNoiseAndThroughALens) {
  const UnderALamp noisy({.noise = 6});
  EXPECT_GT(noisy.share(What::Shadow, noisy.found()), 0.9);
  EXPECT_LT(noisy.share(What::Pillar, noisy.found()), 0.02);
  const UnderALamp bent({}, 6, -0.12);
  EXPECT_GT(bent.share(What::Shadow, bent.found()), 0.95);
}

TEST(CastShadows, AreNotFoundWhereTheFloorIsNotUnlessItIsSought) {
  const UnderALamp stage({.height = 0.5});
  const std::vector<CastShade> found = stage.found();
  EXPECT_LT(stage.share(What::Pillar, found), 0.02);
  EXPECT_LT(stage.share(What::Shadow, found), 0.3);
}

// A world of any size that anybody's calibration left, 25 degrees off.
Rig turned(Rig rig) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.44, Eigen::Vector3d(1, -2, 0.3).normalized()));
  for (RigCamera& c : rig.cameras) {
    c.cam_from_world.rotation = c.cam_from_world.rotation * turn.conjugate();
    c.cam_from_world.translation =
        0.4 * c.cam_from_world.translation - c.cam_from_world.rotation * Eigen::Vector3d(0.7, -1.1, 2);
  }
  return rig;
}

TEST(CastShadows, AreFoundOnAFloorThatIsSoughtForWhereTheWorldIsNotItsOwn) {
  UnderALamp stage({});
  std::vector<BeforeStage> before;
  for (const Seen& s : stage.seen()) before.push_back({&s.picture, &s.stage});
  CastShadows shadows(turned(stage.rig()));
  EXPECT_LT(stage.share(What::Shadow, shadows.find(before, 2)), 0.1);
  shadows.seek_planes();
  const std::vector<CastShade> found = shadows.find(before, 2);
  EXPECT_GT(stage.share(What::Shadow, found), 0.95);
  EXPECT_LT(stage.share(What::Pillar, found), 0.01);
  EXPECT_NE(shadows.floor().offset, 0);
  const ShadedPlane there = shadows.floor();
  EXPECT_EQ(shadows.find(before, 1)[0].mask, found[0].mask) << "it stays where it is";
  EXPECT_EQ(shadows.floor().normal, there.normal);
}

TEST(CastShadows, LeaveTheFloorWhereItIsIfShadowsAreThereOrNowhere) {
  UnderALamp stage({});
  std::vector<BeforeStage> before;
  for (const Seen& s : stage.seen()) before.push_back({&s.picture, &s.stage});
  CastShadows shadows(stage.rig());
  shadows.seek_planes();
  shadows.find(before, 2);
  EXPECT_EQ(shadows.floor().offset, 0);
  EXPECT_TRUE(shadows.found_floor());
  for (BeforeStage& b : before) b.picture = b.stage;
  CastShadows none(turned(stage.rig()));
  none.seek_planes();
  none.find(before, 2);
  EXPECT_EQ(none.floor().offset, 0);
  EXPECT_FALSE(none.found_floor());
}

TEST(CastShadows, AreToldByThreeCamerasAtLeast) {
  const UnderALamp stage({}, 2);
  for (const CastShade& shade : stage.found()) EXPECT_FALSE(shade.any());
}

TEST(CastShadows, OfACameraWithoutAPictureAreToldByNobodyAndAskNobody) {
  UnderALamp stage({});
  stage.seen()[2].picture = {};
  const std::vector<CastShade> found = stage.found();
  EXPECT_EQ(found[2].width, 0);
  EXPECT_GT(stage.share(What::Shadow, found), 0.65);  // of all, and that camera sees much of it
}

TEST(CastShadows, AreTheSameAtAnyNumberOfThreads) {
  const UnderALamp stage({});
  const std::vector<CastShade> one = stage.found(1), four = stage.found(4);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].mask, four[i].mask);
}

}  // namespace
}  // namespace floatstage::matting
