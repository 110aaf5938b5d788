// The table of calibration formats: what every row keeps to.

#include "calib/rig_formats.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rig_io.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

// Where each format's files are looked for below a folder.
const std::vector<std::pair<std::string, std::string>> kNames = {{"middlebury", "temple_par.txt"},
                                                                 {"colmap", "sparse/0"},
                                                                 {"opencv", "."},
                                                                 {"kalibr", "camchain-stage.yaml"},
                                                                 {"qualisys", "calib.qca.txt"}};

class RigFormats : public testing::Test {
 protected:
  // The sample rig in that format, below a folder of its own.
  std::filesystem::path written(const std::string& name, const std::string& file, const Rig& rig) {
    const std::filesystem::path folder = folder_ / name;
    std::filesystem::create_directories(folder / file.substr(0, file.rfind('/') + 1));
    const Result<const RigFormat*> format = rig_format(name, {});
    EXPECT_THAT(format, IsOk());
    std::vector<std::string> images;
    for (const RigCamera& c : rig.cameras) images.push_back(c.serial);
    EXPECT_THAT((*format)->write(rig, images, folder / file), IsOk());
    return folder;
  }

  TempFolder folder_;
};

TEST_F(RigFormats, HaveNamesOfTheirOwnAndSayWhatTheyRead) {
  std::set<std::string_view> names = {kAnyRigFormat};
  for (const RigFormat& f : rig_formats()) {
    EXPECT_TRUE(names.insert(f.name).second) << f.name;
    EXPECT_FALSE(f.title.empty() || f.files.empty()) << f.name;
    EXPECT_TRUE(f.read && f.recognises) << f.name;
    EXPECT_EQ(f.write == nullptr, f.written.empty()) << f.name;
    EXPECT_THAT(rig_format_names(), HasSubstr(std::string(f.name)));
  }
}

TEST_F(RigFormats, RecogniseWhatTheyWroteAndReadItBack) {
  const Rig rig = sample_rig(std::monostate{});
  std::size_t written_ones = 0;
  for (const RigFormat& f : rig_formats()) written_ones += f.write != nullptr;
  EXPECT_EQ(written_ones, kNames.size()) << "this test should know every format that is written";
  for (const auto& [name, file] : kNames) {
    const std::filesystem::path folder = written(name, file, rig);
    const Result<const RigFormat*> format = rig_format(kAnyRigFormat, folder);
    ASSERT_THAT(format, IsOk()) << name;
    EXPECT_EQ((*format)->name, name);
    const Result<ForeignRig> back = read_rig({.path = folder});
    ASSERT_THAT(back, IsOk()) << name;
    ASSERT_EQ(back->rig.cameras.size(), rig.cameras.size()) << name;
    EXPECT_EQ(back->image_names.size(), rig.cameras.size()) << name;
    // A camchain has no world: what is between cameras is what it keeps.
    const auto second_from_first = [](const Rig& r) {
      return (r.cameras[1].cam_from_world * r.cameras[0].cam_from_world.inverse()).translation;
    };
    EXPECT_LT((second_from_first(back->rig) - second_from_first(rig)).norm(), 1e-9) << name;
  }
}

TEST_F(RigFormats, RecogniseAFileAsWellAsItsFolder) {
  const Rig rig = sample_rig(std::monostate{});
  for (const auto& [name, file] : kNames) {
    if (name == "colmap" || name == "opencv") continue;  // two files: only their folder says all
    const Result<const RigFormat*> format = rig_format(kAnyRigFormat, written(name, file, rig) / file);
    ASSERT_THAT(format, IsOk()) << name;
    EXPECT_EQ((*format)->name, name);
  }
}

TEST_F(RigFormats, HoldOurOwnRigs) {
  const Rig rig = sample_rig(KannalaBrandt{0.01, 0, 0, 0});
  ASSERT_THAT(save_rig(rig, folder_ / "rig.json"), IsOk());
  ASSERT_THAT(save_rig(rig, folder_ / "yesterday.json"), IsOk());
  for (const std::filesystem::path& path : {folder_.path(), folder_ / "yesterday.json"}) {
    const Result<ForeignRig> back = read_rig({.path = path});
    ASSERT_THAT(back, IsOk());
    expect_same(rig, back->rig);
    EXPECT_EQ(back->image_names.front(), rig.cameras.front().serial);
    EXPECT_EQ(back->pictures, folder_.path());
  }
}

TEST_F(RigFormats, TakeTheUnitOfThoseThatStateNone) {
  folder_.write("calibration.txt", "0\n100 0 50\n0 100 40\n0 0 1\n0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n");
  for (const double unit : {0.1, 1.0}) {
    const Result<ForeignRig> rig = read_rig({.path = folder_.path(), .metres_per_unit = unit});
    ASSERT_THAT(rig, IsOk());
    EXPECT_DOUBLE_EQ(rig->rig.cameras[0].cam_from_world.translation.z(), 3 * unit);
    EXPECT_EQ(rig->pictures, folder_ / "images");
  }
}

TEST_F(RigFormats, AskForANameWhereSeveralFit) {
  const Rig rig = sample_rig(std::monostate{});
  const std::filesystem::path folder = written("qualisys", "calib.qca.txt", rig);
  ASSERT_THAT(save_rig(rig, folder / "rig.json"), IsOk());
  EXPECT_THAT(read_rig({.path = folder}),
              FailsWith(ErrorCode::InvalidArgument, "could be rig or qualisys; name the format"));
  EXPECT_THAT(read_rig({.format = "qualisys", .path = folder}), IsOk());
}

TEST_F(RigFormats, SayWhatIsMissing) {
  EXPECT_THAT(read_rig({.path = folder_ / "nowhere"}), FailsWith(ErrorCode::NotFound, "nowhere"));
  EXPECT_THAT(read_rig({.path = folder_.path()}), FailsWith(ErrorCode::NotFound, "auto, rig, middlebury"));
  for (const RigFormat& f : rig_formats())
    EXPECT_THAT(read_rig({.format = std::string(f.name), .path = folder_.path()}),
                FailsWith(ErrorCode::NotFound, folder_.path().string()))
        << f.name;
  EXPECT_THAT(read_rig({.format = "blender", .path = folder_.path()}),
              FailsWith(ErrorCode::InvalidArgument, "'blender' is no calibration format; there are auto"));
  folder_.write("a_par.txt", "");
  folder_.write("b_par.txt", "");
  EXPECT_THAT(read_rig({.format = "middlebury", .path = folder_.path()}),
              FailsWith(ErrorCode::InvalidArgument, "a_par.txt, b_par.txt"));
}

}  // namespace
}  // namespace floatstage::calib
