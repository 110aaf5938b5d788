#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/apps/verb_runs.h"
#include "tests/support/small_take.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

class TakeVerbs : public VerbRuns {
 protected:
  void SetUp() override { take_ = small_take(folder_, 3).string(); }
  std::unique_ptr<capture::TakeReader> open(const std::string& name) const {
    auto take = capture::TakeReader::open(folder_ / name);
    EXPECT_THAT(take, IsOk());
    return take ? std::move(*take) : nullptr;
  }
  // SERIAL:X:Y of a point, as a hand would read it off three pictures.
  static std::string marks(const Rig& rig, const Vector3d& point) {
    std::string words;
    for (const std::size_t c : {0U, 1U, 3U}) {
      const RigCamera& camera = rig.cameras[c];
      const Eigen::Vector2d at = *project(camera.model, camera.cam_from_world * point);
      words += text(words.empty() ? "" : ",", camera.serial, ":", at.x(), ":", at.y());
    }
    return words;
  }

  std::string take_;
};

TEST_F(TakeVerbs, SetRigMakesANewTakeOfACalibration) {
  Rig rig = open("take")->rig();
  rig.cameras[2].model.fy *= 1.02;
  ASSERT_THAT(save_rig(rig, folder_ / "rig.json"), IsOk());
  ASSERT_THAT(run({"take", "set-rig", take_, file("rig.json"), "-o", file("new"), "--json", file("r.json")}),
              IsOk());
  EXPECT_EQ(open("new")->rig().cameras[2].model.fy, rig.cameras[2].model.fy);
  EXPECT_EQ(report("r.json").at("frames"), 3);
  EXPECT_THAT(run({"take", "verify", file("new")}), IsOk());
  EXPECT_THAT(run({"take", "info", file("new")}), IsOk());
  EXPECT_THAT(run({"take", "set-rig", take_, file("rig.json"), "-o", file("new")}),
              FailsWith(ErrorCode::AlreadyExists, "new"));
}

TEST_F(TakeVerbs, SetRigSaysWhatIsWrongWithACalibrationAndLeavesNothing) {
  ASSERT_THAT(write_file(folder_ / "cut.json", R"({"floatstage_rig": 1, "cameras": [{"serial")"), IsOk());
  EXPECT_THAT(run({"take", "set-rig", take_, file("cut.json"), "--format", "rig", "-o", file("new")}),
              FailsWith(ErrorCode::BadData, "cut.json"));
  EXPECT_THAT(run({"take", "set-rig", take_, file("none.json"), "-o", file("new")}),
              FailsWith(ErrorCode::NotFound, "none.json"));
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

TEST_F(TakeVerbs, TrimAndJoinGiveTheTakeBack) {
  ASSERT_THAT(run({"take", "trim", take_, "--frames", ":1", "-o", file("a")}), IsOk());
  ASSERT_THAT(run({"take", "trim", take_, "--frames", "1:", "-o", file("b"), "--json", file("t.json")}),
              IsOk());
  EXPECT_EQ(report("t.json").at("frames"), 2);
  ASSERT_THAT(run({"take", "join", file("a"), file("b"), "-o", file("c"), "--json", file("j.json")}), IsOk());
  EXPECT_EQ(report("j.json").at("frames"), 3);
  EXPECT_EQ(to_rgb(*open("c")->frame(1, 2))->pixels, to_rgb(*open("take")->frame(1, 2))->pixels);
  EXPECT_THAT(run({"take", "trim", take_, "--frames", "0:3:2", "-o", file("d")}),
              FailsWith(ErrorCode::InvalidArgument, "without a step"));
  EXPECT_THAT(run({"take", "trim", take_, "--frames", "7", "-o", file("d")}),
              FailsWith(ErrorCode::InvalidArgument, "7"));
}

TEST_F(TakeVerbs, SetWorldByAMarkedLengthScalesTheWorld) {
  const Rig rig = open("take")->rig();
  ASSERT_THAT(run({"take", "set-world", take_, "-o", file("new"), "--length", "3", "--from",
                   marks(rig, {0, 0, 0.2}), "--to", marks(rig, {0, 0, 1.7}), "--json", file("w.json")}),
              IsOk());
  EXPECT_NEAR(report("w.json").at("scale"), 2, 1e-3) << "a metre and a half became three";
  EXPECT_LT(
      (open("new")->rig().cameras[0].cam_from_world.center() - 2 * rig.cameras[0].cam_from_world.center())
          .norm(),
      5e-3);
}

TEST_F(TakeVerbs, SetWorldSaysWhatIsMissing) {
  const std::vector<std::string> begin = {"take", "set-world", take_, "-o", file("new")};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.begin(), begin.begin(), begin.end());
    return run(words);
  };
  EXPECT_THAT(with({}), FailsWith(ErrorCode::InvalidArgument, "--board"));
  EXPECT_THAT(with({"--length", "2"}), FailsWith(ErrorCode::InvalidArgument, "--from"));
  EXPECT_THAT(with({"--length", "2", "--from", "cam00:1", "--to", "cam01:1:2"}),
              FailsWith(ErrorCode::InvalidArgument, "SERIAL:X:Y"));
  EXPECT_THAT(with({"--length", "2", "--from", "left:1:2", "--to", "cam01:1:2"}),
              FailsWith(ErrorCode::InvalidArgument, "'left'"));
  EXPECT_THAT(with({"--length", "2", "--from", "cam00:9:9", "--to", "cam01:1:2"}),
              FailsWith(ErrorCode::InvalidArgument, "two cameras"));
  EXPECT_THAT(with({"--scale", "0"}), FailsWith(ErrorCode::InvalidArgument, "scale"));
  EXPECT_THAT(with({"--board", file("none.txt")}), FailsWith(ErrorCode::NotFound, "none.txt"));
  EXPECT_THAT(with({"--up", "ring", "--frame", "9"}), FailsWith(ErrorCode::InvalidArgument, "frame 9"));
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

TEST_F(TakeVerbs, UndistortMakesATakeOfPinholes) {
  EXPECT_THAT(run({"take", "undistort", take_, "-o", file("new")}),
              FailsWith(ErrorCode::InvalidArgument, "straight already"));
  ASSERT_THAT(run({"synthesize", "-o", file("bent"), "--camera-count", "2", "--frame-count", "2", "--size",
                   "160x120", "--samples", "1", "--lens-k1", "0.2"}),
              IsOk());
  ASSERT_THAT(run({"take", "undistort", file("bent"), "-o", file("new"), "--json", file("u.json")}), IsOk());
  EXPECT_TRUE(std::holds_alternative<std::monostate>(open("new")->rig().cameras[0].model.lens));
  EXPECT_EQ(report("u.json").at("frames"), 2);
  EXPECT_GT(report("u.json").at("cameras")[1].at("hidden"), 0);
  EXPECT_THAT(run({"take", "verify", file("new")}), IsOk());
}

TEST_F(TakeVerbs, ListShowsTheTakesOfAFolderWithThumbnails) {
  ASSERT_THAT(run({"take", "trim", take_, "--frames", ":1", "-o", file("part")}), IsOk());
  ASSERT_THAT(run({"take", "list", folder_.path().string(), "--thumbnails", file("pictures"), "--json",
                   file("l.json")}),
              IsOk());
  const nlohmann::json takes = report("l.json").at("takes");
  ASSERT_EQ(takes.size(), 2u);
  EXPECT_EQ(takes[0].at("name"), "part");
  EXPECT_EQ(takes[0].at("frames"), 1);
  EXPECT_EQ(takes[1].at("verdict"), "whole");
  EXPECT_THAT(load_png(folder_ / "pictures" / "part.png"), IsOk());
  EXPECT_THAT(run({"take", "list", file("none")}), FailsWith(ErrorCode::NotFound, "none"));
}

TEST_F(TakeVerbs, ImportsTakeUpScaleAndFloor) {
  const Rig rig = open("take")->rig();
  fs::create_directory(folder_ / "calibration");
  ASSERT_THAT(save_rig(rig, folder_ / "calibration" / "rig.json"), IsOk());
  for (const RigCamera& c : rig.cameras)
    ASSERT_THAT(save_png(*to_rgb(*open("take")->frame(camera_index(rig, c.serial), 0)),
                         folder_ / "calibration" / (c.serial + ".png")),
                IsOk());
  ASSERT_THAT(run({"import", "rig", file("calibration"), "-o", file("new"), "--up", "-y", "--scale", "2",
                   "--floor", "0.5", "--json", file("i.json")}),
              IsOk());
  const Vector3d was = rig.cameras[1].cam_from_world.center(),
                 is = open("new")->rig().cameras[1].cam_from_world.center();
  EXPECT_NEAR(is.z(), -2 * was.y() - 0.5, 1e-9);
  EXPECT_THAT(report("i.json").at("world").get<std::string>(), HasSubstr("--up"));
}

}  // namespace
}  // namespace floatstage::apps
