#include "pipeline/matte/contradiction.h"

#include <algorithm>
#include <filesystem>

#include "core/png.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

MatteTakeOptions given(const fs::path& take) {
  MatteTakeOptions options;
  options.take = take;
  options.how = "given";
  return options;
}

// The true mattes, but those of some cameras pushed into a corner.
fs::path take_with_given(const TempFolder& folder, int pushed) {
  const fs::path take = small_take(folder, 1);
  const Rig rig = *load_rig(take / "rig.json");
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const std::string& serial = rig.cameras[i].serial;
    Image matte = *load_png(TakeLayout(take / "truth").matte(serial, 0));
    if (static_cast<int>(i) < pushed) {
      std::fill(matte.pixels.begin(), matte.pixels.end(), std::uint8_t{0});
      for (int y = 0; y < matte.height / 6; ++y)
        std::fill_n(matte.at(0, y), matte.width / 6, std::uint8_t{255});
    }
    fs::create_directories(TakeLayout(take).matte(serial, 0).parent_path());
    EXPECT_THAT(save_png(matte, TakeLayout(take).matte(serial, 0)), IsOk());
  }
  return take;
}

TEST(Contradiction, TrueMattesDoNotContradictOneAnother) {
  TempFolder folder;
  const Result<MatteReport> report = matte_take(given(take_with_given(folder, 0)));
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, testing::IsEmpty());
}

// A frame of six cameras, `many` of which are denied that share of their subject.
std::vector<recon::SilhouetteAgreement> denied(int many, double share) {
  std::vector<recon::SilhouetteAgreement> all;
  for (int c = 0; c < 6; ++c) {
    const double one = c < many ? share : 0.01;
    all.push_back({"cam0" + std::to_string(c), 0, 1 - one, one, one});
  }
  return all;
}

TEST(Contradiction, IsATwentiethInHalfOfTheCameras) {
  TempFolder folder;
  const auto take = *capture::TakeReader::open(take_with_given(folder, 0));
  const auto asked = [&](int many, double share) { return *contradiction_in(*take, denied(many, share)); };
  EXPECT_FALSE(asked(2, 0.4));
  EXPECT_FALSE(asked(6, 0.04));
  ASSERT_TRUE(asked(3, 0.07));
  EXPECT_THAT(asked(3, 0.07)->cameras, testing::ElementsAre("cam00", "cam01", "cam02"));
  EXPECT_THAT(sentence(*asked(3, 0.07)), testing::HasSubstr("denies 7 % of the subject"));
}

// Each camera sees a sleeve before the shirt that another sees before the cloth.
TEST(Contradiction, IsSaidWhereThePerformerWearsTheClothsColour) {
  TempFolder folder;
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig.width = 240, options.rig.height = 180;
  options.studio.samples = 4;
  options.studio.stage = SyntheticStage::GreenClothes;
  options.frames = 1;
  ASSERT_THAT(synthesize_take(options), IsOk());
  for (int run = 0; run < 2; ++run) {
    const Result<MatteReport> mattes = matte_take({.take = options.out, .how = "chroma"});
    ASSERT_THAT(mattes, IsOk());
    ASSERT_EQ(mattes->doubts.size(), 1u);
    EXPECT_THAT(sentence(mattes->doubts[0]), testing::HasSubstr("wear the cloth's colour"));
    const Result<ProcessReport> all = process_take({.take = options.out});
    ASSERT_THAT(all, IsOk());
    EXPECT_EQ(all->meshes.made, run == 0);
    ASSERT_EQ(all->doubts.size(), 1u) << "also where the mesh was there";
    EXPECT_THAT(sentence(all->doubts[0]), testing::HasSubstr("wear the cloth's colour"));
    EXPECT_THAT(load_png(all->doubts[0].picture), IsOk());
  }
}

TEST(Contradiction, IsSaidWithAPictureOfTheCamerasThatAreDenied) {
  TempFolder folder;
  const fs::path take = take_with_given(folder, 3);
  const Result<MatteReport> report = matte_take(given(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->doubts.size(), 1u);
  const MatteDoubt& doubt = report->doubts.front();
  EXPECT_GE(doubt.cameras.size(), 3u);
  EXPECT_THAT(sentence(doubt), testing::HasSubstr("denies more than half of the subject"));
  EXPECT_EQ(doubt.picture.parent_path(), doubts_folder(TakeLayout(take)));
  EXPECT_THAT(load_png(doubt.picture), IsOk());
}

fs::path green_clothes(const TempFolder& folder, SyntheticStage stage, int cameras = 8, int seed = 1) {
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig = {.cameras = cameras, .width = 320, .height = 240};
  options.studio.samples = 4;
  options.studio.stage = stage;
  options.studio.seed = static_cast<std::uint64_t>(seed);
  options.frames = 1;
  EXPECT_THAT(synthesize_take(options), IsOk());
  return options.out;
}

// Few cameras deny little of one another, however much all of them lack.
TEST(Contradiction, OfFewCamerasIsToldByWholePieces) {
  for (const auto& [stage, cameras] :
       {std::pair{SyntheticStage::GreenClothes, 3}, std::pair{SyntheticStage::GreenClothes, 4},
        std::pair{SyntheticStage::Room, 4}}) {
    SCOPED_TRACE(testing::Message() << static_cast<int>(stage) << ' ' << cameras);
    TempFolder folder;
    const fs::path take = green_clothes(folder, stage, cameras, 3);
    const bool cloth = stage == SyntheticStage::GreenClothes;
    const Result<MatteReport> mattes = matte_take({.take = take, .how = cloth ? "chroma" : "plate"});
    ASSERT_THAT(mattes, IsOk());
    const Result<ProcessReport> all = process_take({.take = take});
    ASSERT_THAT(all, IsOk());
    if (!cloth) {
      EXPECT_THAT(mattes->doubts, testing::IsEmpty());
      EXPECT_THAT(all->doubts, testing::IsEmpty());
      continue;
    }
    for (const std::vector<MatteDoubt>& doubts : {mattes->doubts, all->doubts}) {
      ASSERT_THAT(doubts, testing::SizeIs(1));
      EXPECT_THAT(doubts[0].why, testing::HasSubstr("% of the subject in whole pieces, in half of the"));
      EXPECT_THAT(doubts[0].why, testing::HasSubstr("wear the cloth's colour"));
      EXPECT_THAT(load_png(doubts[0].picture), IsOk());
    }
  }
}

// A furnished room without plates, where mattes are wrong, and hulls cut where few cameras look.
TEST(Contradiction, IsSaidByProcessAsByMatteWhereHullsAreCut) {
  TempFolder folder;
  const fs::path take = green_clothes(folder, SyntheticStage::Room, 4, 3);
  fs::remove_all(take / "plates");
  const Result<ProcessReport> all = process_take({.take = take, .matte = "consistent"});
  ASSERT_THAT(all, IsOk());
  EXPECT_EQ(all->cut_frames, 1);
  const Result<MatteReport> mattes = matte_take({.take = take});
  ASSERT_THAT(mattes, IsOk());
  ASSERT_FALSE(mattes->doubts.empty());
  ASSERT_FALSE(all->doubts.empty());
  EXPECT_EQ(all->doubts.front().cameras, mattes->doubts.front().cameras);
}

// One camera's mattes cannot contradict one another: the other cameras are keyed likewise, for that alone.
TEST(Contradiction, OfOneCameraAloneIsToldByKeysOfTheOthers) {
  for (const SyntheticStage stage : {SyntheticStage::Green, SyntheticStage::GreenClothes}) {
    TempFolder folder;
    const fs::path take = green_clothes(folder, stage);
    MatteTakeOptions options;
    options.take = take;
    options.how = "chroma";
    options.cameras = {"cam02"};
    const Result<MatteReport> report = matte_take(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_FALSE(fs::exists(TakeLayout(take).matte("cam01", 0))) << "keys of others are not kept";
    if (stage == SyntheticStage::Green) {
      EXPECT_THAT(report->doubts, testing::IsEmpty());
      continue;
    }
    ASSERT_THAT(report->doubts, testing::SizeIs(1));
    EXPECT_THAT(report->doubts[0].cameras, testing::ElementsAre("cam02"));
    EXPECT_THAT(report->doubts[0].why, testing::HasSubstr("the other cameras keyed likewise"));
    EXPECT_THAT(report->doubts[0].why, testing::HasSubstr("the cloth's colour?"));
  }
}

// Consistent matting knows itself that its cameras deny one another; no key can have mistaken a colour.
TEST(Contradiction, OfConsistentMattesIsSaidOnceAndWithoutAHintAtCloth) {
  TempFolder folder;
  const fs::path take = green_clothes(folder, SyntheticStage::Room);
  fs::remove_all(take / "plates");  // by which the room is no riddle
  MatteTakeOptions options;
  options.take = take;
  options.how = "consistent";
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  int said = 0;
  const auto count = [&](const std::string& sentence) {
    said += sentence.find("denie") != std::string::npos;
    EXPECT_THAT(sentence, testing::Not(testing::HasSubstr("colour?")));
  };
  for (const std::string& remark : report->remarks) count(remark);
  for (const MatteDoubt& doubt : report->doubts) count(doubt.why);
  EXPECT_EQ(said, 1);
}

}  // namespace
}  // namespace floatstage::pipeline
