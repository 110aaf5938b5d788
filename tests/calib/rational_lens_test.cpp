// Lenses with a denominator (k4 to k6), as wide lenses that are no fisheyes yet need them.

#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "calib/solver/projection.h"
#include "calib/solver/scene.h"
#include "calib/uncertainty/working_volume.h"
#include "tests/calib/action_lens.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

constexpr BrownConrady kPlain{.k1 = -0.12, .k2 = 0.06, .p1 = 2e-4, .p2 = -3e-4, .k3 = -0.004};

// Near enough to one another that a board fills their pictures to the border.
Rig wide_rig(const BrownConrady& lens, double focal) {
  Rig rig = ring_rig(3, 1.4, 1.1);
  for (RigCamera& c : rig.cameras) {
    c.model.fx = focal;
    c.model.fy = 1.002 * focal;
    c.model.lens = lens;
  }
  return rig;
}

const CaptureOptions kCapture{.frames = 90, .extent = 0.9, .frame_seconds = 0.4};

Observations seen_by(const Rig& truth, std::optional<int> radial, const CaptureOptions& options = kCapture) {
  Observations seen = capture(truth, two_sided_board(15, 11, 0.08, 0.005), wandering(options), options);
  for (CalibrationCamera& c : seen.cameras) c.terms.radial = radial;
  return seen;
}

// How far apart two models see the rays of the picture, its very corners too; a turn between them, which is
// the pose's, is taken out.
struct Apart {
  double rms = 0, most = 0;
};

Apart apart(const CameraModel& found, const CameraModel& truth) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> rays;
  for (int y = 0; y <= 12; ++y)
    for (int x = 0; x <= 16; ++x)
      if (const Eigen::Vector2d pixel(truth.width * x / 16.0, truth.height * y / 12.0);
          const auto ray = unproject(truth, pixel))
        rays.emplace_back(*ray, pixel);
  EXPECT_GE(rays.size(), 13u * 17u - 4) << "the truth sees its own picture";
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  const solver::Intrinsics packed = solver::pack(found);
  for (int i = 0; i < 10; ++i) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const auto& [ray, pixel] : rays) {
      solver::Projected p;
      const Eigen::Vector3d turned = turn * ray;
      if (!solver::project(packed, LensKind::BrownConrady, turned, p)) continue;
      const Eigen::Matrix<double, 2, 3> j = -p.by_point * solver::cross_matrix(turned);
      normal += j.transpose() * j;
      right -= j.transpose() * (p.pixel - pixel);
    }
    turn = (solver::rotation_from_vector(normal.ldlt().solve(right)) * turn).normalized();
  }
  Apart out;
  constexpr double kLost = 1e3;  // px: a ray that the lens folds over
  for (const auto& [ray, pixel] : rays) {
    const auto there = project(found, turn * ray);
    const double off = there ? (*there - pixel).norm() : kLost;
    out.rms += off * off / static_cast<double>(rays.size());
    out.most = std::max(out.most, off);
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

Apart worst(const Rig& found, const Rig& truth) {
  Apart out;
  for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
    const Apart a = apart(found.cameras[c].model, truth.cameras[c].model);
    out = {std::max(out.rms, a.rms), std::max(out.most, a.most)};
  }
  return out;
}

// In the middle, where every camera sees the board.
double largest_sigma(const Calibration& solved) {
  const WorkingVolume volume = box_volume({-0.15, -0.15, 0.9}, {0.15, 0.15, 1.2});
  const ProjectionUncertainty map(solved, volume.points);
  double most = 0;
  for (int c = 0; c < static_cast<int>(solved.rig.cameras.size()); ++c)
    for (const Eigen::Vector3d& x : volume.points) most = std::max(most, map.sigma_px(c, x));
  return most;
}

bool is_rational(const RigCamera& c) { return std::get<BrownConrady>(c.model.lens).rational(); }

TEST(RationalLens, IsFoundWithSixTermsWhereThreeLeaveMore) {
  const Rig truth = wide_rig(kActionLens, 760);
  const Result<Calibration> three = calibrate(seen_by(truth, 3), {.holdout_every = 0}),
                            six = calibrate(seen_by(truth, 6), {.holdout_every = 0});
  ASSERT_THAT(three, IsOk());
  ASSERT_THAT(six, IsOk());
  const Apart of_three = worst(three->rig, truth), of_six = worst(six->rig, truth);
  std::printf("over the picture: three terms %.3f px RMS, six %.3f px RMS, %.3f px at most; sigma %.4f px\n",
              of_three.rms, of_six.rms, of_six.most, largest_sigma(*six));
  EXPECT_LE(of_six.rms, 0.05);
  EXPECT_LE(of_six.most, 0.15) << "in the very corners, where hardly a point is";
  EXPECT_GT(of_three.rms, 0.5);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_TRUE(is_rational(six->rig.cameras[c]));
    EXPECT_LT(six->cameras[c].rms_px, 0.16) << "noise of 0.1 px a coordinate";
    EXPECT_GT(three->cameras[c].rms_px, 0.18);
    EXPECT_LT(six->cameras[c].outliers, 0.04 * six->cameras[c].points) << "its border is taken back";
    for (const int k : {0, 4, 5, 9}) EXPECT_GT(six->cameras[c].intrinsics_sigma[k], 0) << k;
    ASSERT_TRUE(six->scatter[c]);
    EXPECT_LT(*six->scatter[c], 1.5) << "errors are noise";
  }
  EXPECT_LT(largest_sigma(*six), 0.05);
  EXPECT_TRUE(six->covariance.allFinite());
}

TEST(RationalLens, OfAPlainLensIsAsGoodAsThreeTerms) {
  const Rig truth = wide_rig(kPlain, 1150);
  const Result<Calibration> three = calibrate(seen_by(truth, 3), {.holdout_every = 0}),
                            six = calibrate(seen_by(truth, 6), {.holdout_every = 0});
  ASSERT_THAT(three, IsOk());
  ASSERT_THAT(six, IsOk());
  const Apart of_three = worst(three->rig, truth), of_six = worst(six->rig, truth);
  std::printf("over the picture: three terms %.4f px RMS, six %.4f px RMS\n", of_three.rms, of_six.rms);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_FALSE(is_rational(six->rig.cameras[c])) << "nothing shows a denominator";
    EXPECT_NEAR(*six->cameras[c].rms_px, *three->cameras[c].rms_px, 2e-3);
  }
  EXPECT_LE(of_six.rms, of_three.rms + 0.005);
}

// Chance makes a denominator once in three hundred times; a plain lens must not get one more often.
TEST(RationalLens, IsNotMadeByChance) {
  int rational = 0, cameras = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CaptureOptions options = kCapture;
    options.frames = 20;
    options.seed = seed;
    const Rig truth = wide_rig(kPlain, 1150);
    const Result<Calibration> six = calibrate(seen_by(truth, 6, options), {.holdout_every = 0});
    ASSERT_THAT(six, IsOk()) << seed;
    for (const RigCamera& c : six->rig.cameras) rational += is_rational(c), ++cameras;
  }
  EXPECT_LE(rational, 1) << "of " << cameras;
}

TEST(RationalLens, GoesOnFromYesterday) {
  const Rig truth = wide_rig(kActionLens, 760);
  for (const Prior known : {Prior::Start, Prior::Fixed}) {
    Observations seen = seen_by(truth, std::nullopt);
    for (std::size_t c = 0; c < 3; ++c) {
      seen.cameras[c].intrinsics = known;
      seen.cameras[c].model = truth.cameras[c].model;
      if (known == Prior::Start) seen.cameras[c].model.fx *= 1.01, seen.cameras[c].model.fy *= 1.01;
    }
    const Result<Calibration> solved = calibrate(seen, {.holdout_every = 0});
    ASSERT_THAT(solved, IsOk());
    const Apart off = worst(solved->rig, truth);
    std::printf("from yesterday: %.3f px RMS over the picture\n", off.rms);
    EXPECT_LE(off.rms, known == Prior::Fixed ? 1e-6 : 0.05);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_LT(solved->cameras[c].rms_px, 0.16);
  }
}

}  // namespace
}  // namespace floatstage::calib
