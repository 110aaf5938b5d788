#include "studio/live/live_run.h"

#include <set>
#include <thread>

#include <gmock/gmock.h>

#include "pipeline/film.h"
#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "studio/live/take_player.h"
#include "studio/messages/clock.h"
#include "tests/support/small_take.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 160, kHeight = 120, kRows = 4;
constexpr std::array<float, 3> kBlack = {0, 0, 0};

/// A processed take, and the same take played live from one fixed view between two cameras.
class ALiveRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    take_ = small_take(*folder_, kRows);
    ASSERT_THAT(pipeline::process_take({.take = take_, .matte = "chroma", .hull = recon::HullOptions{}}),
                IsOk());
  }
  static void TearDownTestSuite() { delete folder_; }

  struct Shown {
    std::uint64_t instant;
    Image picture;
    bool again;
    std::size_t textures;
  };
  struct Ran {
    std::vector<Shown> pictures;
    LiveReport report;
  };

  static View view(const Rig& rig) {
    return pipeline::view_of(pipeline::sample(pipeline::orbit_around(rig, {}, {.seconds = 1}).path, 0.29),
                             kWidth, kHeight, {});
  }

  /// Slowly enough that any machine keeps up.
  static Ran run(std::size_t quality, double rate = 4) {
    auto player = std::move(*TakePlayer::open(take_, {.rate = rate}));
    LiveRunOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.quality = quality;
    options.target_fps = 0;
    Ran out;
    Result<LiveReport> report = run_live(
        *player, {}, options, [&](double) { return view(player->rig()); }, [] { return false; },
        [&](const LivePicture& p) -> Result<void> {
          std::size_t textures = 0;
          for (const auto& seen : p.scene->views) textures += seen && seen->tile;
          out.pictures.push_back(
              {p.scene->scene.epoch, pipeline::over(p.picture, kBlack), p.again, textures});
          return {};
        });
    EXPECT_THAT(report, IsOk());
    if (report) out.report = std::move(*report);
    return out;
  }

  /// What `render` draws of an instant.
  static Image offline(int frame) {
    auto take = std::move(*capture::TakeReader::open(take_));
    const SceneFrame scene = *pipeline::SceneLoader(*take, true).load(frame);
    render::Scene drawn;
    EXPECT_THAT(drawn.set(take->rig(), scene), IsOk());
    auto renderer = std::move(*render::make_renderer("floating", render::BackEnd::Cpu));
    return pipeline::over(render::download(*renderer->render(drawn, view(take->rig()), {})), kBlack);
  }

  static TempFolder* folder_;
  static std::filesystem::path take_;
};
TempFolder* ALiveRun::folder_ = nullptr;
std::filesystem::path ALiveRun::take_;

TEST_F(ALiveRun, ShowsWhatIsRenderedOfflineOfTheSameInstant) {
  const Ran ran = run(0);
  ASSERT_FALSE(ran.pictures.empty());
  std::set<std::uint64_t> instants;
  for (const Shown& shown : ran.pictures) {
    ASSERT_LT(shown.instant, kRows);
    instants.insert(shown.instant);
    const Image expected = offline(static_cast<int>(shown.instant));
    EXPECT_GT(psnr(shown.picture, expected), 24) << "instant " << shown.instant;
    long covered = 0, wanted = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); i += 3) {
      covered += shown.picture.pixels[i] + shown.picture.pixels[i + 1] + shown.picture.pixels[i + 2] > 30;
      wanted += expected.pixels[i] + expected.pixels[i + 1] + expected.pixels[i + 2] > 30;
    }
    EXPECT_NEAR(static_cast<double>(covered), static_cast<double>(wanted),
                0.15 * static_cast<double>(wanted));
  }
  EXPECT_EQ(instants.size(), static_cast<std::size_t>(kRows)) << "the machine had time for all of them";
}

TEST_F(ALiveRun, FetchesOnlyTheThreeTexturesThatTheViewNeeds) {
  const Ran ran = run(1);
  ASSERT_GT(ran.pictures.size(), 2U);
  EXPECT_EQ(ran.pictures.front().textures, 6U) << "before the first picture anybody may be needed";
  EXPECT_EQ(ran.pictures.back().textures, 3U);
}

TEST_F(ALiveRun, DrawsTheLastSceneOnWhileNoNewOneComes) {
  const Ran ran = run(1);
  long again = 0;
  for (const Shown& shown : ran.pictures) again += shown.again;
  EXPECT_GT(again, 0) << "instants come every 250 ms, pictures every 100 ms";
  EXPECT_EQ(static_cast<long>(ran.pictures.size()) - again, static_cast<long>(ran.report.counters.scenes));
}

TEST_F(ALiveRun, WorksAtEveryQuality) {
  for (std::size_t quality = 0; quality < live_qualities().size(); ++quality) {
    const Ran ran = run(quality, 20);
    ASSERT_FALSE(ran.pictures.empty()) << live_qualities()[quality].name;
    const Shown& last = ran.pictures.back();
    EXPECT_GT(psnr(last.picture, offline(static_cast<int>(last.instant))), 17)
        << live_qualities()[quality].name;
    ASSERT_EQ(ran.report.qualities.size(), 1U);
    EXPECT_THAT(ran.report.qualities[0].quality, HasSubstr(live_qualities()[quality].name));
  }
}

TEST_F(ALiveRun, CountsEveryInstantThatItCouldNotShow) {
  const Ran ran = run(0, 1000);
  const LiveChain::Counters& c = ran.report.counters;
  EXPECT_EQ(c.sets.frames, 6U * kRows);
  EXPECT_EQ(c.sets.sets, c.sets.overtaken + c.scenes + c.failed);
  EXPECT_GE(c.scenes, 1U);
}

// Cameras that deliver nothing, or machines that are switched off.
class SilentFeed final : public SceneFeed {
 public:
  const Rig& rig() const override { return rig_; }
  std::string description() const override { return "nothing"; }
  double frame_rate() const override { return 25; }
  std::shared_ptr<const LiveScene> newest(Timestamp deadline) override {
    std::this_thread::sleep_for(
        std::chrono::nanoseconds(std::max<std::int64_t>(0, (deadline - now()).count)));
    return nullptr;
  }
  void want(const std::vector<int>&) override {}
  Counters counters() const override { return {}; }
  std::string remark() const override { return "its machines are switched off"; }

 private:
  Rig rig_;
};

TEST_F(ALiveRun, EndsWhenItsTimeIsOverThoughNothingCame) {
  SilentFeed feed;
  LiveRunOptions options;
  options.seconds = 1;
  const Timestamp begun = now();
  EXPECT_THAT(run_live(
                  feed, options, [](double) { return View(); }, [] { return false; }, nullptr),
              FailsWith(ErrorCode::Timeout, "no scene came within 3 s: its machines are switched off"));
  EXPECT_LT(seconds(now() - begun), 1 + 5);
}

TEST_F(ALiveRun, RefusesWhatCannotBe) {
  auto player = std::move(*TakePlayer::open(take_, {}));
  const auto run_with = [&](const LiveChainOptions& chain, const LiveRunOptions& options) {
    return run_live(
        *player, chain, options, [&](double) { return view(player->rig()); }, [] { return true; }, {});
  };
  LiveRunOptions options;
  options.quality = 99;
  EXPECT_THAT(run_with({}, options), FailsWith(ErrorCode::InvalidArgument, "99"));
  LiveChainOptions chain;
  chain.key = "guess";
  EXPECT_THAT(run_with(chain, {}), FailsWith(ErrorCode::InvalidArgument, "guess"));
}

}  // namespace
}  // namespace floatstage::studio
