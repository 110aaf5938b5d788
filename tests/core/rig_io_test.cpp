#include "core/rig_io.h"

#include <bit>
#include <limits>

#include <gtest/gtest.h>

#include "core/file.h"
#include "core/random.h"
#include "core/text.h"
#include "tests/core/rigs.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

// A document in which one piece of text is replaced; the piece must be there.
std::string edited(std::string json, std::string_view from, std::string_view to) {
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return json.replace(at, from.size(), to);
}

std::vector<double> numbers_of(const RigCamera& c) {
  std::vector<double> n = {c.model.fx, c.model.fy, c.model.cx, c.model.cy, c.model.skew};
  if (const auto* b = std::get_if<BrownConrady>(&c.model.lens))
    n.insert(n.end(), {b->k1, b->k2, b->p1, b->p2, b->k3, b->k4, b->k5, b->k6});
  if (const auto* k = std::get_if<KannalaBrandt>(&c.model.lens))
    n.insert(n.end(), {k->k1, k->k2, k->k3, k->k4});
  for (int i = 0; i < 4; ++i) n.push_back(c.cam_from_world.rotation.coeffs()[i]);
  for (int i = 0; i < 3; ++i) n.push_back(c.cam_from_world.translation[i]);
  for (int i = 0; i < 9; ++i) n.push_back(c.color.matrix(i / 3, i % 3));
  return n;
}

TEST(RigJson, BringsEveryNumberBackBitByBit) {
  Random random(7);
  Rig rig = ring(3);
  rig.cameras[0].model.lens = BrownConrady{0.1 + 0.2, -1e-300, 5e-324, -0.0, 1.0 / 3};
  rig.cameras[1].model.lens = KannalaBrandt{random.normal(), random.normal(), random.normal(), 1e300};
  for (RigCamera& c : rig.cameras) {
    c.model.cx = random.uniform(0, 640);
    c.model.skew = random.normal();
    c.cam_from_world.rotation =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    c.cam_from_world.translation = {random.normal(), 1e-17 * random.normal(), 1e17 * random.normal()};
    for (int i = 0; i < 9; ++i) c.color.matrix(i / 3, i % 3) = random.normal();
  }
  const Result<Rig> back = parse_rig(to_json(rig), "rig.json");
  ASSERT_THAT(back, IsOk());
  ASSERT_EQ(back->cameras.size(), rig.cameras.size());
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    EXPECT_EQ(back->cameras[i].serial, rig.cameras[i].serial);
    EXPECT_EQ(back->cameras[i].model.lens.index(), rig.cameras[i].model.lens.index());
    EXPECT_EQ(back->cameras[i].model.width, 640);
    EXPECT_EQ(back->cameras[i].model.height, 480);
    const std::vector<double> before = numbers_of(rig.cameras[i]), after = numbers_of(back->cameras[i]);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t k = 0; k < before.size(); ++k)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(before[k]), std::bit_cast<std::uint64_t>(after[k]))
          << "number " << k << " of camera " << i;
  }
  EXPECT_EQ(to_json(*back), to_json(rig));
}

TEST(RigJson, MayLeaveOutSkewLensAndColour) {
  const auto rig = parse_rig(
      R"({"floatstage_rig": 1, "cameras": [{"serial": "a", "width": 4, "height": 3, "fx": 5, "fy": 5,
      "cx": 2, "cy": 1.5, "cam_from_world": {"rotation_wxyz": [1, 0, 0, 0], "translation": [0, 0, 2]}}]})",
      "rig.json");
  ASSERT_THAT(rig, IsOk());
  EXPECT_TRUE(std::holds_alternative<std::monostate>(rig->cameras[0].model.lens));
  EXPECT_EQ(rig->cameras[0].model.skew, 0);
  EXPECT_TRUE(rig->cameras[0].color.is_identity());
  EXPECT_EQ(rig->cameras[0].cam_from_world.rotation.w(), 1) << "w comes first in the file";
}

TEST(RigJson, SaysAFormatOfItsOwnForRationalLensesOnly) {
  Rig rig = ring(1);
  rig.cameras[0].model.lens = BrownConrady{.k1 = 0.1};
  EXPECT_NE(to_json(rig).find("\"floatstage_rig\": 1"), std::string::npos);
  rig.cameras[0].model.lens = BrownConrady{.k1 = 0.1, .k4 = 0.2, .k6 = 1.0 / 3};
  EXPECT_NE(to_json(rig).find("\"floatstage_rig\": 3"), std::string::npos);
  const Result<Rig> back = parse_rig(to_json(rig), "rig.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(numbers_of(back->cameras[0]), numbers_of(rig.cameras[0]));
}

struct Damage {
  const char* from;
  const char* to;
  const char* complaint;
};

class DamagedRigJson : public testing::TestWithParam<Damage> {};

TEST_P(DamagedRigJson, IsRefusedWithASentenceThatNamesFileAndCamera) {
  const auto rig = parse_rig(edited(to_json(ring(2)), GetParam().from, GetParam().to), "stage/rig.json");
  EXPECT_THAT(rig, FailsWith(ErrorCode::BadData, "stage/rig.json"));
  EXPECT_THAT(rig, FailsWith(ErrorCode::BadData, GetParam().complaint));
}

INSTANTIATE_TEST_SUITE_P(
    Damages, DamagedRigJson,
    testing::Values(
        Damage{"\"fx\": 500.0", "\"fx\": null", "camera 'cam0': 'fx' is not a number"},
        Damage{"\"fx\": 500.0", "\"fx\": \"500\"", "camera 'cam0': 'fx' is not a number"},
        Damage{"\"fx\": 500.0", "\"fx\": 1e999", "not usable as JSON"},
        Damage{"\"fx\": 500.0", "\"fx\": NaN", "not JSON at byte"},
        Damage{"\"fx\": 500.0", "\"fx\": -500.0", "camera 'cam0': focal length"},
        Damage{"\"fx\": 500.0", "\"focal\": 500.0", "camera 'cam0': 'fx' is missing"},
        Damage{"\"skew\"", "\"skeww\"", "unknown key 'skeww'"},
        Damage{"\"width\": 640", "\"width\": 640.5", "'width' is not a whole number"},
        Damage{"\"width\": 640", "\"width\": 99999999999", "'width' is not a whole number"},
        Damage{"\"width\": 640", "\"width\": 18446744073709551615", "'width' is not a whole number"},
        Damage{"\"width\": 640", "\"width\": 0", "camera 'cam0': image size 0x480"},
        Damage{"\"cam1\"", "\"cam0\"", "two cameras have this serial"},
        Damage{"\"cam1\"", "\"../cam1\"", "a serial must be"},
        Damage{"\"cam1\"", "17", "camera 1: 'serial' is not a string"},
        Damage{"\"none\"", "\"fish-eye\"", "unknown lens type 'fish-eye'"},
        Damage{"\"translation\": [", "\"translation\": [1, ", "'translation' is not a list of 3 numbers"},
        Damage{"\"rotation_wxyz\": [", "\"rotation_wxyz\": [[[1]], ",
               "'rotation_wxyz' is not a list of 4 numbers"},
        Damage{"\"cameras\": [", "\"cameras\": 3, \"rest\": [", "'cameras' is not a list"}));

TEST(RigJson, NeedsARotationOfUnitLength) {
  Rig rig = ring(1);
  rig.cameras[0].cam_from_world.rotation.coeffs() *= 1.01;
  EXPECT_THAT(parse_rig(to_json(rig), "rig.json"),
              FailsWith(ErrorCode::BadData, "camera 'cam0': the rotation"));
}

TEST(RigJson, OfALaterFormatIsUnsupportedRatherThanDamaged) {
  EXPECT_THAT(parse_rig(R"({"floatstage_rig": 4, "cameras": []})", "rig.json"),
              FailsWith(ErrorCode::Unsupported, "rig format 4"));
}

TEST(RigJson, WithoutCamerasIsRefused) {
  EXPECT_THAT(parse_rig(R"({"floatstage_rig": 1, "cameras": []})", "rig.json"),
              FailsWith(ErrorCode::BadData, "no camera"));
}

TEST(RigJson, CutOffAnywhereIsRefused) {
  const std::string whole = to_json(ring(1));
  for (std::size_t length = 0; length + 2 < whole.size(); ++length)
    EXPECT_THAT(parse_rig(std::string_view(whole).substr(0, length), "rig.json"),
                FailsWith(ErrorCode::BadData, "rig.json"))
        << length;
}

TEST(RigFile, ComesBackFromTheDisk) {
  const TempFolder folder;
  ASSERT_THAT(save_rig(ring(4), folder / "rig.json"), IsOk());
  const Result<Rig> back = load_rig(folder / "rig.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(to_json(*back), to_json(ring(4)));
  EXPECT_THAT(folder.names(), testing::ElementsAre("rig.json"));
}

TEST(RigFile, ThatIsNotThereIsNotFound) {
  EXPECT_THAT(load_rig("/nowhere/rig.json"), FailsWith(ErrorCode::NotFound, "/nowhere/rig.json"));
}

TEST(RigFile, IsKeptWhenTheNewRigIsNotANumber) {
  const TempFolder folder;
  folder.write("rig.json", "old");
  Rig rig = ring(2);
  rig.cameras[1].model.cx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(save_rig(rig, folder / "rig.json"), FailsWith(ErrorCode::BadData, "camera 'cam1'"));
  EXPECT_THAT(read_file(folder / "rig.json"), IsOkAnd(testing::Eq("old")));
}

TEST(RigJson, NamesAVersionOfItsOwnForColourCurves) {
  Rig rig;
  rig.cameras.push_back({.serial = "a",
                         .model = {.width = 4, .height = 3, .fx = 5, .fy = 5, .cx = 2, .cy = 1, .lens = {}},
                         .cam_from_world = {},
                         .color = {}});
  EXPECT_THAT(to_json(rig), testing::HasSubstr("\"floatstage_rig\": 1"));
  rig.cameras[0].color.decode = {1.8, 2.2, 1.0 / 3};
  rig.cameras[0].color.encode = 2.4;
  EXPECT_THAT(to_json(rig), testing::HasSubstr("\"floatstage_rig\": 2"));
  const Result<Rig> back = parse_rig(to_json(rig), "rig.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->cameras[0].color.decode, rig.cameras[0].color.decode);
  EXPECT_EQ(back->cameras[0].color.encode, 2.4);
  rig.cameras[0].color.encode = 0;
  EXPECT_THAT(check(rig), FailsWith(ErrorCode::BadData, "exponent"));
}

}  // namespace
}  // namespace floatstage
