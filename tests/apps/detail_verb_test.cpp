#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "detail/photo_file.h"
#include "tests/apps/verb_runs.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using detail::test::photograph;
using detail::test::view_of_world;

class DetailVerbs : public VerbRuns {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "photos");
    ASSERT_THAT(save_png(photograph(240, 180, view_of_world(0, 0, 4)), folder_ / "photos/wide.png"), IsOk());
    ASSERT_THAT(save_png(photograph(240, 180, view_of_world(330, 190, 1.5)), folder_ / "photos/close.png"),
                IsOk());
    folder_.write("photos/cut.jpg", "\xFF\xD8\xFF");
  }
};

TEST_F(DetailVerbs, RelatePhotographsAndMakeOnePictureOfThem) {
  ASSERT_THAT(run({"detail", "graph", file("photos"), "--json", file("g.json"), "--dot", file("g.dot")}),
              IsOk());
  const nlohmann::json graph = report("g.json");
  EXPECT_EQ(graph.at("folder"), "photos");
  EXPECT_EQ(graph.at("root"), "wide.png");
  EXPECT_EQ(graph.at("photos")[0].at("parent"), "wide.png");
  EXPECT_NEAR(graph.at("photos")[0].at("zoom"), 4 / 1.5, 0.02);
  EXPECT_EQ(graph.at("refused")[0].at("child"), "wide.png");
  EXPECT_EQ(graph.at("unread")[0].at("name"), "cut.jpg");
  EXPECT_TRUE(std::filesystem::exists(file("g.json.cache/pairs.json")));
  EXPECT_TRUE(std::filesystem::exists(file("g.dot")));
  ASSERT_THAT(run({"detail", "compose", file("g.json"), "-o", file("zoom.png"), "--zoom", "2", "--json",
                   file("c.json")}),
              IsOk());
  EXPECT_THAT(load_png(file("zoom.png")), IsOkAnd(testing::Field(&Image::width, 480)));
  EXPECT_EQ(report("c.json").at("photos")[0].at("name"), "close.png");
  ASSERT_THAT(run({"detail", "compose", file("g.json"), "-o", file("zoom.jpg"), "--root", "close.png"}),
              IsOk());
}

TEST_F(DetailVerbs, MakeUpWhatNoClosePhotographShows) {
  ASSERT_THAT(run({"detail", "graph", file("photos"), "--json", file("g.json")}), IsOk());
  ASSERT_THAT(run({"detail", "synthesize", file("g.json"), "-o", file("large.png"), "--zoom", "4",
                   "--provenance", file("from.png"), "--json", file("s.json"), "--threads", "1"}),
              IsOk());
  ASSERT_THAT(
      run({"detail", "synthesize", file("g.json"), "-o", file("again.png"), "--zoom", "4", "--threads", "2"}),
      IsOk());
  const Result<Image> large = load_png(file("large.png"));
  ASSERT_THAT(large, IsOkAnd(testing::Field(&Image::width, 960)));
  EXPECT_EQ(*large, *load_png(file("again.png")));
  EXPECT_THAT(load_png(file("from.png")), IsOkAnd(testing::Field(&Image::height, 720)));
  const nlohmann::json made = report("s.json");
  EXPECT_EQ(made.at("zoom"), 4);
  EXPECT_GT(made.at("like_root"), 40);
  EXPECT_EQ(made.at("photos")[0].at("name"), "close.png");
  double shares = 0;
  for (const auto& share : made.at("shares")) shares += share.get<double>();
  EXPECT_NEAR(shares, 1, 1e-6);
  ASSERT_THAT(run({"detail", "synthesize", file("g.json"), "-o", file("deep.dzi")}), IsOk());
  EXPECT_TRUE(std::filesystem::exists(file("deep_files/0/0_0.jpg")));
  ASSERT_THAT(run({"detail", "synthesize", file("g.json"), "-o", file("deep.tif"), "--zoom", "4"}), IsOk());
  EXPECT_GT(psnr(*detail::load_photo(file("deep.tif")), *large), 38) << "JPEG";
  EXPECT_FALSE(std::filesystem::exists(file("deep.tif.levels")));
}

TEST_F(DetailVerbs, SayWhyNothingIsMadeUp) {
  ASSERT_THAT(run({"detail", "graph", file("photos"), "--json", file("g.json")}), IsOk());
  const auto synthesize = [&](const std::string& out, const std::string& option, const std::string& value) {
    return run({"detail", "synthesize", file("g.json"), "-o", file(out), option, value});
  };
  EXPECT_THAT(synthesize("z.gif", "--zoom", "2"),
              FailsWith(ErrorCode::InvalidArgument, "a picture is a .png"));
  EXPECT_THAT(synthesize("z.png", "--zoom", "3"),
              FailsWith(ErrorCode::InvalidArgument, "2, 4, 8, 16, 32 or 64"));
  EXPECT_THAT(synthesize("z.png", "--zoom", "64"), FailsWith(ErrorCode::InvalidArgument, "million pixels"));
  EXPECT_THAT(synthesize("z.png", "--provenance", "p.jpg"),
              FailsWith(ErrorCode::InvalidArgument, "a .png file"));
  EXPECT_THAT(synthesize("z.png", "--root", "close.png"),
              FailsWith(ErrorCode::InvalidArgument, "nothing lies below close.png"));
  EXPECT_FALSE(std::filesystem::exists(file("z.png")));
}

TEST_F(DetailVerbs, SayWhatIsWrongBeforeAnythingIsWritten) {
  EXPECT_THAT(run({"detail", "graph", file("nothing")}),
              FailsWith(ErrorCode::NotFound, "nothing is no folder"));
  EXPECT_THAT(run({"detail", "graph", file("photos"), "--root", "far.png", "--json", file("g.json")}),
              FailsWith(ErrorCode::InvalidArgument, "--root far.png"));
  EXPECT_FALSE(std::filesystem::exists(file("g.json")));
  ASSERT_THAT(run({"detail", "graph", file("photos"), "--json", file("g.json")}), IsOk());
  EXPECT_THAT(run({"detail", "compose", file("g.json"), "-o", file("zoom.gif")}),
              FailsWith(ErrorCode::InvalidArgument, "a picture is a .png or a .jpg"));
  EXPECT_THAT(run({"detail", "compose", file("g.json"), "-o", file("z.png"), "--root", "far.png"}),
              FailsWith(ErrorCode::InvalidArgument, "no photograph of this name"));
  EXPECT_THAT(run({"detail", "compose", file("g.json"), "-o", file("z.png"), "--zoom", "0.5"}),
              FailsWith(ErrorCode::InvalidArgument, "--zoom 0.5"));
  EXPECT_THAT(run({"detail", "compose", file("photos/wide.png"), "-o", file("z.png")}),
              FailsWith(ErrorCode::BadData, "wide.png"));
  EXPECT_FALSE(std::filesystem::exists(file("z.png")));
}

}  // namespace
}  // namespace floatstage::apps
