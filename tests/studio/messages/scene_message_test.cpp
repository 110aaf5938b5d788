#include "studio/messages/scene_message.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

StudioScene tetrahedron() {
  StudioScene scene;
  scene.epoch = 12;
  scene.instant = {500};
  scene.produced = {900};
  scene.rig_sha256 = std::string(60, 'a') + "0123";
  scene.cameras = {{"cam0", {498}}, {"cam1", {502}}};
  scene.remark = "camera 'cam1' lacks 20 % of what the others see";
  scene.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.25f}};
  scene.mesh.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  return scene;
}

Result<StudioScene> read(std::string_view bytes) {
  const Result<Message> message = open(bytes);
  if (!message) return forward(message);
  return decode_scene(*message);
}

void expect_same(const StudioScene& a, const StudioScene& b) {
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.instant, b.instant);
  EXPECT_EQ(a.produced, b.produced);
  EXPECT_EQ(a.rig_sha256, b.rig_sha256);
  EXPECT_EQ(a.cameras, b.cameras);
  EXPECT_EQ(a.remark, b.remark);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
}

TEST(SceneMessage, ComesBackBitByBit) {
  const StudioScene scene = tetrahedron();
  const Result<std::string> bytes = encode_scene(scene);
  ASSERT_THAT(bytes, IsOk());
  const Result<StudioScene> again = read(*bytes);
  ASSERT_THAT(again, IsOk());
  expect_same(*again, scene);
}

TEST(SceneMessage, OfAnEmptyStageTravelsToo) {
  StudioScene scene = tetrahedron();
  scene.mesh = {};
  const Result<StudioScene> again = read(*encode_scene(scene));
  ASSERT_THAT(again, IsOk());
  EXPECT_TRUE(again->mesh.empty());
}

TEST(SceneMessage, NumbersCornersWithSixteenBitsUntilTheyNoLongerSuffice) {
  StudioScene scene = tetrahedron();
  scene.mesh.positions.resize(65536, Eigen::Vector3f::Zero());
  scene.mesh.triangles.back() = 65535;
  const std::size_t small = encode_scene(scene)->size();
  expect_same(*read(*encode_scene(scene)), scene);
  scene.mesh.positions.resize(65537, Eigen::Vector3f::Zero());
  scene.mesh.triangles.back() = 65536;
  EXPECT_EQ(encode_scene(scene)->size(), small + 12 + 4 * 3 * 2);
  expect_same(*read(*encode_scene(scene)), scene);
}

TEST(SceneMessage, RefusesAMeshThatIsNone) {
  StudioScene scene = tetrahedron();
  scene.mesh.triangles[0] = 4;
  EXPECT_THAT(encode_scene(scene), FailsWith(ErrorCode::InvalidArgument, "corner that is not there"));
  scene = tetrahedron();
  scene.mesh.positions[1].y() = std::numeric_limits<float>::infinity();
  EXPECT_THAT(encode_scene(scene), FailsWith(ErrorCode::InvalidArgument, "no number"));
  scene = tetrahedron();
  scene.rig_sha256 = "rig";
  EXPECT_THAT(encode_scene(scene), FailsWith(ErrorCode::InvalidArgument, "digest"));
}

TEST(SceneMessage, CarriesNoRemarkThatAWindowCannotShow) {
  StudioScene scene = tetrahedron();
  scene.remark = "two\nlines";
  EXPECT_THAT(encode_scene(scene), FailsWith(ErrorCode::InvalidArgument, "remark"));
  scene.remark = std::string(4097, 'a');
  EXPECT_THAT(encode_scene(scene), FailsWith(ErrorCode::InvalidArgument, "remark"));
  scene = tetrahedron();
  std::string bytes = *encode_scene(scene);
  bytes[bytes.find("lacks") + 5] = '\n';
  EXPECT_THAT(read(bytes), FailsWith(ErrorCode::BadData, "remark"));
}

TEST(SceneMessage, WithACornerOrAPositionSpoiltOnTheWayIsRefused) {
  std::string bytes = *encode_scene(tetrahedron());
  bytes[bytes.size() - 1] = 1;
  EXPECT_THAT(read(bytes), FailsWith(ErrorCode::BadData, "corner that is not there"));
  bytes = *encode_scene(tetrahedron());
  const std::size_t last_z = bytes.size() - 4 * 3 * 2 - 1 - 4;
  const float no_number = std::numeric_limits<float>::quiet_NaN();
  bytes.replace(last_z, sizeof no_number, reinterpret_cast<const char*>(&no_number), sizeof no_number);
  EXPECT_THAT(read(bytes), FailsWith(ErrorCode::BadData, "no number"));
}

TEST(SceneMessage, IsRefusedWhereverItIsCut) {
  const std::string whole = *encode_scene(tetrahedron());
  for (std::size_t size = kHeaderBytes; size < whole.size(); ++size) {
    std::string cut = whole.substr(0, size);
    const auto payload = static_cast<std::uint32_t>(size - kHeaderBytes);
    cut.replace(52, sizeof payload, reinterpret_cast<const char*>(&payload), sizeof payload);
    EXPECT_THAT(read(cut), FailsWith(ErrorCode::BadData, "scene")) << size;
  }
}

}  // namespace
}  // namespace floatstage::studio::wire
