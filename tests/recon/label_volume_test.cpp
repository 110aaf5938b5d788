#include "recon/label_volume.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

// Two balls on the x axis before eight cameras around them, of which some see one behind the other.
class TwoBalls : public testing::Test {
 protected:
  static constexpr double kRadius = 0.25;
  static constexpr double kAt[] = {-0.5, 0.5};

  TwoBalls() : rig_(synthetic_rig({.cameras = 8, .width = 160, .height = 120, .distance = 4})) {
    for (const RigCamera& camera : rig_.cameras) {
      Image who(camera.model.width, camera.model.height, 1), sum = who;
      for (int y = 0; y < who.height; ++y)
        for (int x = 0; x < who.width; ++x) {
          *who.at(x, y) = seen(camera, x, y);
          *sum.at(x, y) = *who.at(x, y) ? 255 : 0;
        }
      mattes_.push_back(make_matte({}, sum));
      who_.push_back(std::move(who));
    }
  }

  // Which ball is nearest along a pixel's ray: 1, 2, or 0.
  static std::uint8_t seen(const RigCamera& camera, int x, int y) {
    const Vector3d ray = camera.cam_from_world.rotation.conjugate() *
                         unproject(camera.model, {x + 0.5, y + 0.5})->normalized(),
                   from = camera.cam_from_world.center();
    double nearest = 1e9;
    std::uint8_t who = 0;
    for (int ball = 0; ball < 2; ++ball) {
      const Vector3d to = Vector3d(kAt[ball], 0, 1) - from;
      const double along = to.dot(ray), aside = (to - along * ray).norm();
      if (aside < kRadius && along < nearest) nearest = along, who = static_cast<std::uint8_t>(ball + 1);
    }
    return who;
  }

  LabelVolume carve(double edge = 0.04) const {
    Result<LabelVolume> volume = LabelVolume::carve(rig_, mattes_, edge, 2, 2);
    EXPECT_THAT(volume, IsOk());
    return std::move(*volume);
  }

  Vector3d middle(const LabelVolume& volume, std::size_t v) const {
    return volume.voxel() * (volume.places()[v].cast<double>() + Vector3d::Constant(0.5));
  }

  // What the pictures say, as hear() wants it.
  std::vector<float> says(std::size_t camera) const {
    std::vector<float> out(2 * who_[camera].pixels.size(), 0.F);
    for (std::size_t p = 0; p < who_[camera].pixels.size(); ++p)
      if (const int who = who_[camera].pixels[p]; who > 0) out[2 * p + static_cast<std::size_t>(who - 1)] = 1;
    return out;
  }

  const Rig rig_;
  std::vector<Matte> mattes_;
  std::vector<Image> who_;
};

TEST_F(TwoBalls, HoldsBothOfThem) {
  const LabelVolume volume = carve();
  for (const double at : kAt) {
    const auto near = [&](const Eigen::Vector3i& p) {
      return (volume.voxel() * (p.cast<double>() + Vector3d::Constant(0.5)) - Vector3d(at, 0, 1)).norm() <
             kRadius / 2;
    };
    const double in_ball = 4.0 / 3 * 3.14159 * std::pow(kRadius / 2, 3) / std::pow(volume.voxel(), 3);
    EXPECT_NEAR(static_cast<double>(std::count_if(volume.places().begin(), volume.places().end(), near)),
                in_ball, 0.2 * in_ball);
  }
}

TEST_F(TwoBalls, TakesTheLabelsThatItsCamerasSee) {
  const LabelVolume volume = carve();
  LabelVolume::Costs costs = volume.no_costs();
  for (std::size_t v = 0; v < volume.size(); ++v) costs[3 * v] = 0.5F;
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c)
    volume.hear(static_cast<int>(c), {}, says(c), 1, costs);
  const std::vector<std::uint8_t> labels = volume.label(costs, 0.5);
  for (std::size_t v = 0; v < volume.size(); ++v)
    for (int ball = 0; ball < 2; ++ball)
      if ((middle(volume, v) - Vector3d(kAt[ball], 0, 1)).norm() < kRadius - 0.05) {
        ASSERT_EQ(labels[v], ball + 1) << middle(volume, v).transpose();
      }
}

TEST_F(TwoBalls, IsSeenWithWhatIsInFrontHidingTheRest) {
  const LabelVolume volume = carve();
  std::vector<std::uint8_t> labels;
  for (std::size_t v = 0; v < volume.size(); ++v) labels.push_back(middle(volume, v).x() < 0 ? 1 : 2);
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    const Image picture = volume.picture(static_cast<int>(c), labels);
    int right = 0, all = 0;
    for (std::size_t p = 0; p < picture.pixels.size(); ++p) {
      if (!who_[c].pixels[p]) continue;
      ++all, right += picture.pixels[p] == who_[c].pixels[p];
    }
    EXPECT_GT(right, 0.85 * all) << rig_.cameras[c].serial << ", whose cells are "
                                 << volume.cell(static_cast<int>(c));
  }
}

TEST_F(TwoBalls, LetsNobodysVoxelsHideNobody) {
  const LabelVolume volume = carve();
  std::vector<std::uint8_t> labels;
  for (std::size_t v = 0; v < volume.size(); ++v) labels.push_back(middle(volume, v).x() < 0 ? 1 : 0);
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    const Image picture = volume.picture(static_cast<int>(c), labels);
    EXPECT_EQ(std::count(picture.pixels.begin(), picture.pixels.end(), 2), 0);
    EXPECT_GT(std::count(picture.pixels.begin(), picture.pixels.end(), 1), 100);
  }
}

TEST_F(TwoBalls, MeasuresWaysThroughVoxelsOnly) {
  const LabelVolume volume = carve();
  std::size_t left = 0, right = 0;
  for (std::size_t v = 0; v < volume.size(); ++v) {
    if ((middle(volume, v) - Vector3d(kAt[0], 0, 1)).norm() < volume.voxel()) left = v;
    if ((middle(volume, v) - Vector3d(kAt[1], 0, 1)).norm() < volume.voxel()) right = v;
  }
  const std::vector<std::size_t> start = {left};
  EXPECT_EQ(volume.way_from(start)[left], 0);
  EXPECT_EQ(volume.way_from(start)[right], LabelVolume::kFar) << "there is air between the balls";
  const std::vector<Eigen::Vector3i> place = {volume.places()[left]};
  EXPECT_NEAR(volume.distance_to(place)[right] * volume.voxel(), 1, 0.15);
}

TEST_F(TwoBalls, KnowsHowMuchOfALabelIsNearAnother) {
  const LabelVolume volume = carve();
  std::vector<std::uint8_t> apart, mixed;
  for (std::size_t v = 0; v < volume.size(); ++v) {
    apart.push_back(middle(volume, v).x() < 0 ? 1 : 2);
    mixed.push_back(v % 2 ? 1 : 2);
  }
  EXPECT_EQ(volume.merged(apart, 3)[1], 0);
  EXPECT_GT(volume.merged(mixed, 3)[1], 0.95);
}

TEST_F(TwoBalls, IsTheSameAtAnyNumberOfThreads) {
  Result<LabelVolume> one = LabelVolume::carve(rig_, mattes_, 0.05, 2, 1),
                      four = LabelVolume::carve(rig_, mattes_, 0.05, 2, 4);
  EXPECT_EQ(one->places(), four->places());
}

TEST_F(TwoBalls, HasNoEdgeWhereNobodyIs) {
  std::vector<Matte> nobody;
  for (const RigCamera& c : rig_.cameras)
    nobody.push_back(make_matte({}, Image(c.model.width, c.model.height, 1)));
  EXPECT_EQ(LabelVolume::edge_for(rig_, nobody, 1000), 0);
}

TEST_F(TwoBalls, RefusesMoreVoxelsThanMemoryHolds) {
  EXPECT_THAT(LabelVolume::carve(rig_, mattes_, 1e-4, 2, 1), FailsWith(ErrorCode::BadData, "too many"));
}

}  // namespace
}  // namespace floatstage::recon
