#include "pipeline/orbit.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "pipeline/ring.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

// Cameras on a circle around the z axis that look at (0, 0, 1); `turned_by` rolls each about its own axis.
Rig ring(int cameras, double arc, double radius, double height = 1.5, double turned_by = 0) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {
    const double a = arc * i / cameras;
    RigCamera c;
    c.serial = "c" + std::to_string(i);
    c.model = {
        .width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240, .skew = 0, .lens = {}};
    c.cam_from_world = look_at({radius * std::cos(a), radius * std::sin(a), height}, {0, 0, 1}, {0, 0, 1});
    c.cam_from_world.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turned_by, Vector3d::UnitZ())) * c.cam_from_world.rotation;
    c.cam_from_world.translation =
        Eigen::AngleAxisd(turned_by, Vector3d::UnitZ()) * c.cam_from_world.translation;
    rig.cameras.push_back(c);
  }
  return rig;
}

// The same cameras in a world that lies some other way.
Rig in_world(Rig rig, const Eigen::Quaterniond& new_from_old) {
  for (RigCamera& c : rig.cameras)
    c.cam_from_world.rotation = c.cam_from_world.rotation * new_from_old.conjugate();
  return rig;
}

const Eigen::Quaterniond kOnItsSide(Eigen::AngleAxisd(1.1, Vector3d(0.6, -0.8, 0)));

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / kPi;
}

Mesh box_mesh(const Vector3d& low, const Vector3d& high) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(Eigen::Vector3f(static_cast<float>(i & 1 ? high.x() : low.x()),
                                             static_cast<float>(i & 2 ? high.y() : low.y()),
                                             static_cast<float>(i & 4 ? high.z() : low.z())));
  mesh.triangles = {0, 1, 2};
  return mesh;
}

Subject performer(const Vector3d& low = {-0.4, -0.4, 0}, const Vector3d& high = {0.4, 0.4, 2}) {
  Subject subject;
  add(box_mesh(low, high), subject);
  return subject;
}

TEST(UpAxis, IsTheSideThatNoPictureLeans) {
  EXPECT_LT(degrees_between(up_axis(ring(8, 2 * kPi, 3)).direction, Vector3d::UnitZ()), 1e-6);
  EXPECT_LT(degrees_between(up_axis(ring(12, 1.5, 3)).direction, Vector3d::UnitZ()), 1e-6) << "an arc";
}

TEST(UpAxis, IsFoundInAWorldThatLiesOnItsSide) {
  const Rig rig = in_world(ring(8, 2 * kPi, 3), kOnItsSide);
  const UpAxis up = up_axis(rig);
  EXPECT_EQ(up.from, UpAxis::From::Pictures);
  EXPECT_LT(degrees_between(up.direction, kOnItsSide * Vector3d::UnitZ()), 1e-6);
}

TEST(UpAxis, IsFoundWhenAllPicturesLieOnTheirSide) {
  for (const double turn : {kPi / 2, -kPi / 2}) {
    const Rig rig = in_world(ring(16, 2 * kPi, 0.5, 1.1, turn), kOnItsSide);
    EXPECT_LT(degrees_between(up_axis(rig).direction, kOnItsSide * Vector3d::UnitZ()), 1e-6)
        << "they look down from above";
  }
}

TEST(UpAxis, IsFoundWhenHalfOfTheCamerasStandOnTheirSide) {
  Rig rig = ring(10, 2 * kPi, 3);
  const Rig turned = ring(10, 2 * kPi, 3, 1.5, kPi / 2);
  for (std::size_t i = 0; i < 10; i += 2) rig.cameras[i] = turned.cameras[i];
  rig = in_world(rig, kOnItsSide);
  EXPECT_LT(degrees_between(up_axis(rig).direction, kOnItsSide * Vector3d::UnitZ()), 1e-6);
}

TEST(UpAxis, OfADomeIsThatOfItsPicturesAndNotOfItsCamerasPlane) {
  Rig dome = ring(10, 2 * kPi, 3, 0.5);
  const Rig upper = ring(5, 0.8 * kPi, 1.5, 3.4);  // on one side only: the cameras' plane leans
  dome.cameras.insert(dome.cameras.end(), upper.cameras.begin(), upper.cameras.end());
  dome = in_world(dome, kOnItsSide);
  EXPECT_LT(degrees_between(up_axis(dome).direction, kOnItsSide * Vector3d::UnitZ()), 1e-6);
}

TEST(UpAxis, OfCamerasTurnedAtRandomIsThatOfTheirRing) {
  Rig rig;
  Random random(7);
  for (int i = 0; i < 12; ++i) {
    Rig turned = ring(12, 2 * kPi, 3, 1.5, 2 * kPi * random.uniform());
    rig.cameras.push_back(turned.cameras[static_cast<std::size_t>(i)]);
  }
  const Vector3d up = up_axis(in_world(rig, kOnItsSide)).direction;
  EXPECT_LT(std::min(degrees_between(up, kOnItsSide * Vector3d::UnitZ()),
                     degrees_between(-up, kOnItsSide * Vector3d::UnitZ())),
            0.1);
}

TEST(UpAxis, OfCamerasThatFaceOneWayIsWhatTheirPicturesShow) {
  Rig wall;
  for (int i = 0; i < 9; ++i) {
    RigCamera c = ring(1, 1, 3).cameras.front();
    c.cam_from_world = look_at({3, i % 3 - 1.0, i / 3 + 0.5}, {0, i % 3 - 1.0, i / 3 + 0.5}, {0, 0, 1});
    wall.cameras.push_back(c);
  }
  const UpAxis up = up_axis(wall);
  EXPECT_EQ(up.from, UpAxis::From::MeanUp);
  EXPECT_LT(degrees_between(up.direction, Vector3d::UnitZ()), 1e-6);
}

TEST(FitRing, IsNotDrawnAwayByAFewCamerasElsewhere) {
  Rig rig = ring(12, 2 * kPi, 3);
  const Rig others = ring(3, 0.5, 0.7, 3.5);
  rig.cameras.insert(rig.cameras.end(), others.cameras.begin(), others.cameras.end());
  const Ring found = fit_ring(rig, Vector3d::UnitZ());
  EXPECT_NEAR(found.radius, 3, 0.02);
  EXPECT_LT(found.center.head<2>().norm(), 0.02);
}

TEST(FitRing, SaysThatThreeCamerasOrALineTellNoCentre) {
  EXPECT_TRUE(std::isinf(fit_ring(ring(3, kPi, 3), Vector3d::UnitZ()).center_error));
  Rig line = ring(5, 1, 3);
  for (std::size_t i = 0; i < 5; ++i)
    line.cameras[i].cam_from_world = look_at({3, static_cast<double>(i), 1}, {0, 2, 1}, {0, 0, 1});
  EXPECT_GT(fit_ring(line, Vector3d::UnitZ()).center_error, 1);
}

TEST(Orbit, TurnsOnceAroundWhenCamerasSurroundTheStage) {
  const CameraPath orbit = orbit_around(ring(8, 2 * kPi, 3), performer(), {.seconds = 10}).path;
  EXPECT_DOUBLE_EQ(orbit.duration(), 10);
  EXPECT_LT((orbit.keys.front().eye - orbit.keys.back().eye).norm(), 1e-9);
  double turned = 0;
  for (std::size_t i = 1; i < orbit.keys.size(); ++i) {
    const Vector3d a = orbit.keys[i - 1].eye, b = orbit.keys[i].eye;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.head<2>().dot(b.head<2>()));
  }
  EXPECT_NEAR(std::abs(turned), 2 * kPi, 1e-6);
  for (const PathKey& k : orbit.keys) {
    EXPECT_NEAR(k.eye.head<2>().norm(), 3, 1e-9);
    EXPECT_NEAR(k.eye.z(), 1.5, 1e-9) << "where the cameras stand";
  }
}

TEST(Orbit, StaysInTheArcThatCamerasCover) {
  const Rig rig = ring(10, kPi / 2, 3);  // azimuths 0 … 81°
  for (const PathKey& k : orbit_around(rig, performer(), {.seconds = 4}).path.keys) {
    const double azimuth = std::atan2(k.eye.y(), k.eye.x()) * 180 / kPi;
    EXPECT_GE(azimuth, -1e-6);
    EXPECT_LE(azimuth, 81 + 1e-6);
  }
}

TEST(Orbit, GoesAroundTheCamerasCircleAndLooksAtASubjectThatStandsAside) {
  const Subject aside = performer({0.6, -0.3, 0}, {1.2, 0.3, 1.8});
  for (const PathKey& k : orbit_around(ring(9, 2 * kPi, 3), aside, {}).path.keys) {
    EXPECT_NEAR(k.eye.head<2>().norm(), 3, 1e-6);
    EXPECT_LT((k.target.head<2>() - Eigen::Vector2d(0.9, 0)).norm(), 0.15);
  }
}

TEST(Orbit, HoldsTheSubjectWithRoomToSpareInEveryPicture) {
  for (const double aspect : {4.0 / 3, 16.0 / 9, 9.0 / 16}) {
    const Rig rig = in_world(ring(16, 2 * kPi, 0.9, 1.4, kPi / 2), kOnItsSide);
    Subject subject;
    Mesh mesh = box_mesh({-0.2, -0.1, 0.7}, {0.1, 0.1, 1.2});
    for (Eigen::Vector3f& p : mesh.positions) p = kOnItsSide.cast<float>() * p;
    add(mesh, subject);
    const Orbit orbit = orbit_around(rig, subject, {.aspect = aspect});
    double least_room = 1;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const PathKey& k : orbit.path.keys) {
      const int height = 1000, width = static_cast<int>(height * aspect);
      const View view = view_of(k, width, height, subject.box);
      Eigen::AlignedBox2d box;
      for (const Eigen::Vector3f& p : mesh.positions)
        box.extend(*project(view.model, view.view_from_world * p.cast<double>()));
      const Eigen::Vector2d low = box.min(), high = Eigen::Vector2d(width, height) - box.max();
      least_room =
          std::min({least_room, low.x() / width, low.y() / height, high.x() / width, high.y() / height});
      middle += Eigen::Vector2d(box.center().x() / width, box.center().y() / height) /
                static_cast<double>(orbit.path.keys.size());
    }
    EXPECT_NEAR(least_room, 0.1, 0.002);
    EXPECT_LT((middle - Eigen::Vector2d(0.5, 0.5)).norm(), 0.01);
  }
}

TEST(Orbit, IsWhatItsOptionsSay) {
  const Rig rig = ring(8, 2 * kPi, 3);
  const OrbitOptions options{.height = 2, .distance = 5, .fov = 33, .turns = -2, .start = 90};
  const Orbit orbit = orbit_around(rig, performer(), options);
  const Orbit usual = orbit_around(rig, performer(), {});
  const std::vector<PathKey>& keys = orbit.path.keys;
  for (const PathKey& k : keys) {
    EXPECT_NEAR(k.eye.head<2>().norm(), 5, 1e-9);
    EXPECT_NEAR(k.eye.z(), 3, 1e-9) << "two metres above the subject's middle";
    EXPECT_EQ(k.fov_y, 33);
  }
  const Vector3d first = keys.front().eye, second = keys[1].eye, begin = usual.path.keys.front().eye;
  EXPECT_NEAR(begin.head<2>().dot(first.head<2>()), 0, 1e-6) << "a quarter of a turn on";
  EXPECT_LT(first.x() * second.y() - first.y() * second.x(), 0) << "the other way";
  EXPECT_EQ(keys.size(), 2 * 72 + 1u);
  EXPECT_LT((keys[72].eye - first).norm(), 1e-6) << "twice";
}

TEST(Orbit, AroundASubjectThatNobodyKnowsYetIsWhereTheCamerasLook) {
  const Orbit orbit = orbit_around(ring(8, 2 * kPi, 3), {}, {});
  EXPECT_LT((orbit.path.keys.front().target - Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_NEAR(orbit.fov, 2 * std::atan(240.0 / 600) * 180 / kPi, 1e-9) << "as wide as theirs";
}

}  // namespace
}  // namespace floatstage::pipeline
