#include "tests/apps/verb_runs.h"

namespace floatstage::apps {
namespace {

// A performer before green, processed: what scores are made from.
class EvaluateVerb : public VerbRuns {
 protected:
  void SetUp() override {
    ASSERT_THAT(run({"synthesize", "-o", file("take"), "--stage", "green", "--camera-count", "5",
                     "--frame-count", "1", "--size", "160x120"}),
                IsOk());
    ASSERT_THAT(run({"process", file("take")}), IsOk());
  }
  Result<void> evaluate(const std::string& back_end, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"evaluate", file("take"), "--renderer",
                                      back_end,   "--json",     file(back_end)};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};

// What OpenGL draws with has to be there until the last picture is.
TEST_F(EvaluateVerb, ScoresWithOpenGlAsWithNativeCode) {
  for (const char* back_end : {"cpu", "gl"})
    ASSERT_THAT(evaluate(back_end, {"--hold-out", "cam01", "--methods", "linear"}), IsOk()) << back_end;
  const double cpu = report("cpu").at("mean").at("linear").at("psnr_mask");
  EXPECT_NEAR(report("gl").at("mean").at("linear").at("psnr_mask"), cpu, 0.05);
  EXPECT_GT(cpu, 10) << "nothing is compared";
}

TEST_F(EvaluateVerb, WalksWithOpenGl) {
  ASSERT_THAT(evaluate("gl", {"--orbit", "--steps", "40", "--methods", "linear"}), IsOk());
  EXPECT_TRUE(report("gl").at("mean").contains("linear"));
}

TEST_F(EvaluateVerb, AlignsByDepth) {
  for (const char* back_end : {"cpu", "gl"})
    ASSERT_THAT(evaluate(back_end, {"--hold-out", "cam01", "--methods", "floating", "--alignment", "depth"}),
                IsOk());
  EXPECT_NEAR(report("gl").at("mean").at("floating").at("psnr_mask"),
              double(report("cpu").at("mean").at("floating").at("psnr_mask")), 0.1);
}

TEST_F(EvaluateVerb, RefusesDepthThatOtherFlagsSayNothingOf) {
  for (const std::vector<std::string>& others :
       {std::vector<std::string>{"--flow", "dis"}, {"--flow", "none"}, {"--positions", "mean"}}) {
    std::vector<std::string> words = {"--hold-out", "cam01", "--alignment", "depth"};
    words.insert(words.end(), others.begin(), others.end());
    EXPECT_THAT(evaluate("cpu", words), FailsWith(ErrorCode::InvalidArgument, "--alignment flow"));
  }
}

}  // namespace
}  // namespace floatstage::apps
