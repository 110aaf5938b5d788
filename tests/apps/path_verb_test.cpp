#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/text.h"
#include "pipeline/camera_path.h"
#include "tests/apps/verb_runs.h"
#include "tests/support/small_take.h"

namespace floatstage::apps {
namespace {

using testing::HasSubstr;

class PathVerb : public VerbRuns {
 protected:
  void SetUp() override {
    pipeline::PathKey key;
    key.eye = {3, 0, 1};
    path_.keys = {key, key};
    path_.keys[1].time = 2, path_.keys[1].eye = {0, 3, 1};
    path_.keys[0].take_time = path_.keys[1].take_time = 0.5;
    ASSERT_THAT(pipeline::save_path(path_, folder_ / "path.json"), IsOk());
  }
  pipeline::CameraPath path_;
};

TEST_F(PathVerb, SaysWhatKeysSay) {
  testing::internal::CaptureStdout();
  ASSERT_THAT(run({"path", "show", file("path.json"), "--json", file("r.json")}), IsOk());
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("take at 0.5 s, frozen from here"));
  EXPECT_EQ(report("r.json"),
            nlohmann::json({{"keys", 2}, {"seconds", 2.0}, {"follows", false}, {"take_times", true}}));
}

TEST_F(PathVerb, GoesOutAndComesBackByVerbs) {
  for (const std::string out : {"camera.gltf", "camera.glb", "cameras"}) {
    ASSERT_THAT(run({"path", "export", file("path.json"), "-o", file(out), "--fps", "10", "--json",
                     file(out + ".json")}),
                IsOk());
    EXPECT_EQ(report(out + ".json").at("cameras"), out == "cameras" ? 20 : 21);
    ASSERT_THAT(run({"path", "import", file(out), "--fps", "10", "-o", file(out + "-path.json")}), IsOk());
    const Result<pipeline::CameraPath> again = pipeline::load_path(folder_ / (out + "-path.json"));
    ASSERT_THAT(again, IsOk());
    EXPECT_NEAR(again->duration(), out == "cameras" ? 1.9 : 2, 1e-6);
    EXPECT_LT((again->keys[10].eye - sample(path_, 1).eye).norm(), 1e-6);
    EXPECT_EQ(again->keys[10].take_time, out == "cameras" ? std::nullopt : std::optional(0.5));
    EXPECT_THAT(run({"path", "import", file(out), "-o", file(out + "-path.json")}),
                FailsWith(ErrorCode::AlreadyExists, "is left as it is"));
    EXPECT_THAT(run({"path", "export", file("path.json"), "-o", file(out)}),
                FailsWith(ErrorCode::AlreadyExists, out));
  }
}

TEST_F(PathVerb, AsksForTheTakeOfAPathThatFollows) {
  path_.keys[0].follow = true;
  ASSERT_THAT(pipeline::save_path(path_, folder_ / "path.json"), IsOk());
  EXPECT_THAT(run({"path", "export", file("path.json"), "-o", file("c.glb")}),
              FailsWith(ErrorCode::InvalidArgument, "--take"));
  const std::string take = small_take(folder_, 2).string();
  EXPECT_THAT(run({"path", "export", file("path.json"), "--take", take, "-o", file("c.glb")}),
              FailsWith(ErrorCode::NotFound, "process"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c.glb"));
}

TEST_F(PathVerb, NamesWhatCannotBeRead) {
  EXPECT_THAT(run({"path", "import", file("none.glb"), "-o", file("p.json")}),
              FailsWith(ErrorCode::NotFound, "none.glb"));
  ASSERT_THAT(write_file(folder_ / "cut.gltf", R"({"asset": {"version": "2)"), IsOk());
  EXPECT_THAT(run({"path", "import", file("cut.gltf"), "-o", file("p.json")}),
              FailsWith(ErrorCode::BadData, "cut.gltf"));
  EXPECT_THAT(run({"path", "import", file("path.json"), "-o", file("p.json")}),
              FailsWith(ErrorCode::InvalidArgument, "neither"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "p.json"));
}

}  // namespace
}  // namespace floatstage::apps
