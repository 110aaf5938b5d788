#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/media_file.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/demo/demo.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

using nlohmann::json;

// synthesize → process → evaluate, as the README's commands do it: twelve cameras, one left out.
class SyntheticTake : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    pipeline::SynthesizeOptions studio;
    studio.out = *folder_ / "take";
    studio.rig.cameras = 12;
    studio.studio.samples = 4;
    studio.studio.defects.calibration_error = 0.3;
    studio.frames = 1;
    ASSERT_THAT(pipeline::synthesize_take(studio), IsOk());
    pipeline::ProcessOptions process{.take = studio.out, .matte = "chroma", .hull = recon::HullOptions{}};
    process.hull->resolution = 160;
    ASSERT_THAT(pipeline::process_take(process), IsOk());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::vector<pipeline::HeldOutView> evaluate(const std::vector<std::string>& hold_out) {
    auto take = capture::TakeReader::open(*folder_ / "take");
    EXPECT_THAT(take, IsOk());
    pipeline::EvaluateOptions options{.hold_out = hold_out, .renderer = {}, .proxy = {}};
    options.proxy.kind = pipeline::Proxy::Kind::Hull;
    options.proxy.hull.method = recon::HullMethod::Octree;
    options.proxy.hull.resolution = 160;
    std::vector<pipeline::HeldOutView> views;
    EXPECT_THAT(pipeline::evaluate_take(**take, options,
                                        [&](pipeline::HeldOutView view) {
                                          return views.push_back(std::move(view)), Result<void>();
                                        }),
                IsOk());
    return views;
  }

  static TempFolder* folder_;
};
TempFolder* SyntheticTake::folder_ = nullptr;

TEST_F(SyntheticTake, LooksSharperFloatingThanBlendedFromViewpointsWhereNoCameraStood) {
  double linear = 0, floating = 0, linear_ssim = 0, floating_ssim = 0;
  const std::vector<pipeline::HeldOutView> views = evaluate({"cam00", "cam04", "cam08"});
  ASSERT_EQ(views.size(), 3u);
  for (const pipeline::HeldOutView& view : views) {
    linear += view.scores.at("linear").psnr / 3;
    floating += view.scores.at("floating").psnr / 3;
    linear_ssim += view.scores.at("linear").ssim / 3;
    floating_ssim += view.scores.at("floating").ssim / 3;
  }
  EXPECT_GT(floating, linear);
  EXPECT_GT(floating_ssim, linear_ssim);
  EXPECT_GT(floating, 17) << "and not only less bad";
}

TEST_F(SyntheticTake, NeverUsesTheHeldOutPhotograph) {
  // The held-out camera's photograph and matte are replaced by garbage: the rendered views must not notice.
  const std::vector<pipeline::HeldOutView> before = evaluate({"cam02"});
  auto reader = capture::TakeReader::open(*folder_ / "take");
  ASSERT_THAT(reader, IsOk());
  const std::filesystem::path matte = (*reader)->layout().matte("cam02", 0);
  const std::string kept = *read_file(matte);
  Image garbage(640, 480, 1);
  for (int x = 0; x < 640; ++x)
    for (int y = 100; y < 180; ++y) garbage.at(x, y)[0] = 255;
  ASSERT_THAT(save_png(garbage, matte), IsOk());
  const std::vector<pipeline::HeldOutView> after = evaluate({"cam02"});
  ASSERT_THAT(write_file(matte, kept), IsOk());
  ASSERT_EQ(before.size(), 1u);
  ASSERT_EQ(after.size(), 1u);
  for (const char* method : {"nearest", "linear", "floating"})
    EXPECT_EQ(before[0].rendered.at(method), after[0].rendered.at(method)) << method;
}

TEST_F(SyntheticTake, ComparesWithACameraThatHasNoMatteWhereTheProxyIs) {
  auto reader = capture::TakeReader::open(*folder_ / "take");
  ASSERT_THAT(reader, IsOk());
  const std::filesystem::path matte = (*reader)->layout().matte("cam05", 0);
  std::filesystem::rename(matte, *folder_ / "matte.png");
  const std::vector<pipeline::HeldOutView> views = evaluate({"cam05", "cam04"});
  std::filesystem::rename(*folder_ / "matte.png", matte);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_FALSE(views[0].has_matte);
  EXPECT_TRUE(views[1].has_matte);
  EXPECT_GT(views[0].scores.at("floating").psnr, 15);
  const auto covered = std::count_if(views[0].mask.pixels.begin(), views[0].mask.pixels.end(),
                                     [](std::uint8_t alpha) { return alpha >= 128; });
  EXPECT_GT(covered, 640 * 480 / 50);
}

TEST_F(SyntheticTake, RefusesToHoldOutACameraThatIsNotThere) {
  auto take = capture::TakeReader::open(*folder_ / "take");
  ASSERT_THAT(take, IsOk());
  pipeline::EvaluateOptions options{.hold_out = {"cam99"}, .renderer = {}, .proxy = {}};
  EXPECT_THAT(pipeline::evaluate_take(**take, options, [](pipeline::HeldOutView) { return Result<void>(); }),
              FailsWith(ErrorCode::NotFound, "cam99"));
}

TEST(Demo, MakesBothVideosAndAReportOfScoresAgainstTruth) {
  TempFolder folder;
  pipeline::DemoOptions options = pipeline::default_demo();
  options.out = folder / "demo";
  options.studio.frames = 2;
  options.film_rate = 12;
  options.score_every = 1;
  ASSERT_THAT(pipeline::run_demo(options), IsOk());
  const json report = json::parse(*read_file(options.out / "report.json"));
  EXPECT_GT(report["seconds"].get<double>(), 0);
  for (const char* method : {"linear", "floating"}) {
    EXPECT_GT(report["mean"][method]["psnr_mask"].get<double>(), 17) << method;
    EXPECT_GT(report["mean"][method]["ssim_mask"].get<double>(), 0.5) << method;
  }
  for (const auto& [name, width] : {std::pair{"freeview.mp4", 640}, {"compare.mp4", 1280}}) {
    auto video = capture::MediaReader::open(options.out / name);
    ASSERT_THAT(video, IsOk());
    const Result<Image> first = (*video)->next(), second = (*video)->next();
    ASSERT_THAT(first, IsOk());
    ASSERT_THAT(second, IsOk());
    EXPECT_EQ(first->width, width);
    EXPECT_THAT((*video)->next(), FailsWith(ErrorCode::EndOfStream, ""));
    EXPECT_NE(*first, *second) << "nothing moves";
  }
  EXPECT_THAT(pipeline::run_demo(options), IsOk()) << "a demo may be made again where one was";
}

}  // namespace
}  // namespace floatstage
