#include "apps/terminal/hull_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/matchers.h"

namespace floatstage::apps {
namespace {

struct Parsed {
  CLI::App app;
  HullFlags flags;

  explicit Parsed(const std::string& words) {
    add_hull_flags(app, flags);
    app.parse(words);
  }
};

TEST(HullFlags, KnowWhetherAnythingWasSaid) {
  EXPECT_FALSE(Parsed("").flags.given());
  EXPECT_TRUE(Parsed("--votes auto").flags.given()) << "also when it is the default that was said";
  EXPECT_TRUE(Parsed("--collapse-slivers").flags.given());
  EXPECT_TRUE(Parsed("--volume 0 0 0 1 1 1").flags.given());
}

TEST(HullFlags, ComeBackFromTheirDescription) {
  for (const char* words :
       {"", "--votes strict", "--votes 5 --contour-tolerance 0.25",
        "--hull octree --resolution 96 --smoothing 0.25", "--volume -1 -2 -3 1.5 2 3",
        "--collapse-slivers --smooth 3 --triangles 5000 --cleanup-pixels 1 --cleanup-loss 0.01"}) {
    const Result<recon::HullOptions> options = pipeline::hull_options(Parsed(words).flags);
    ASSERT_THAT(options, IsOk()) << words;
    const std::optional<recon::HullOptions> back = pipeline::parse_hull_options(pipeline::describe(*options));
    ASSERT_TRUE(back) << words;
    EXPECT_EQ(pipeline::describe(*back), pipeline::describe(*options)) << words;
    EXPECT_EQ(back->method, options->method) << words;
    EXPECT_EQ(back->voting, options->voting) << words;
    EXPECT_EQ(back->votes, options->votes) << words;
    EXPECT_EQ(back->cleanup, options->cleanup) << words;
    EXPECT_EQ(back->volume.has_value(), options->volume.has_value()) << words;
  }
}

TEST(HullFlags, AreNotReadFromADescriptionOfSomethingElse) {
  for (const char* text : {"null", "{}", "[1]", R"({"method": "guess"})", R"({"method": 3})",
                           R"({"method": "exact", "votes": [5]})", R"({"method": "exact", "volume": [1, 2]})",
                           R"({"method": "exact", "contour_tolerance": -1})"}) {
    EXPECT_FALSE(pipeline::parse_hull_options(nlohmann::json::parse(text))) << text;
  }
}

}  // namespace
}  // namespace floatstage::apps
