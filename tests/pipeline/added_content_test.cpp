// What recorders and converters add to pictures, through every stage: bars and time stamps over the studio's
// dancer, against the same take without them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/added_file.h"
#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "tests/support/burnt_in.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr int kCameras = 8, kFrames = 2;
constexpr AddedContent kBars{.top = 14, .bottom = 14};

struct Stage {
  Rig rig;
  std::vector<std::vector<Image>> pictures;  // [frame][camera]
  std::vector<std::vector<Matte>> truth;
};

Stage dancer() {
  const Result<SyntheticStudio> studio =
      SyntheticStudio::create(synthetic_rig({.cameras = kCameras, .width = 400, .height = 300}),
                              {.samples = 4, .defects = {.noise = 1}});
  Stage stage{studio->published_rig(), {}, {}};
  for (int f = 0; f < kFrames; ++f) {
    stage.pictures.emplace_back(), stage.truth.emplace_back();
    for (int c = 0; c < kCameras; ++c) {
      const SyntheticShot shot = studio->shoot(c, 5 + f);
      stage.pictures[static_cast<std::size_t>(f)].push_back(*to_rgb(shot.frame));
      stage.truth[static_cast<std::size_t>(f)].push_back(shot.matte);
    }
  }
  return stage;
}

std::vector<Stamp> stamps(int frame, std::size_t camera) {
  return {{.words = text("23/11 10:41:0", frame),
           .x = 0.03,
           .y = 0.07,
           .size = 0.04,
           .font = 2,
           .look = StampLook::Outlined},
          {.words = text("CAM 0", camera + 1), .x = 0.74, .y = 0.86, .size = 0.04, .look = StampLook::Boxed}};
}

fs::path written(const Stage& stage, bool with_added, const fs::path& folder) {
  const auto writer = *capture::TakeWriter::create(folder, stage.rig, {});
  for (int f = 0; f < kFrames; ++f)
    for (std::size_t c = 0; c < stage.rig.cameras.size(); ++c) {
      Image picture = stage.pictures[static_cast<std::size_t>(f)][c];
      for (const Stamp& stamp : with_added ? stamps(f, c) : std::vector<Stamp>()) burn_in(stamp, picture);
      if (with_added) picture = with_bars(picture, kBars);
      picture = coded(picture, 92);
      FrameInfo info;
      info.camera = static_cast<int>(c), info.sequence = static_cast<std::uint64_t>(f);
      info.exposure_start = {f * 40'000'000L};
      EXPECT_THAT(writer->write(make_frame(info, picture)), IsOk());
    }
  EXPECT_THAT(writer->finish(), IsOk());
  return folder;
}

// The part of a matte within the bars.
Matte seen(const Matte& matte) {
  Image part = to_image(matte);
  return make_matte({}, with_bars(part, kBars));
}

class AddedToPictures : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    stage = new Stage(dancer());
    folder = new TempFolder();
    written(*stage, false, *folder / "plain");
    written(*stage, true, *folder / "added");
    plain = new Result<ProcessReport>(process_take({.take = *folder / "plain", .matte = "chroma"}));
    added = new Result<ProcessReport>(process_take({.take = *folder / "added", .matte = "chroma"}));
  }
  static void TearDownTestSuite() { delete added, delete plain, delete folder, delete stage; }
  static inline Stage* stage;
  static inline TempFolder* folder;
  static inline Result<ProcessReport>*plain, *added;
};

TEST_F(AddedToPictures, IsSaidOnceAndKeptInTheTake) {
  ASSERT_THAT(*plain, IsOk());
  ASSERT_THAT(*added, IsOk());
  EXPECT_THAT((*plain)->remarks, IsEmpty());
  ASSERT_THAT((*added)->remarks, SizeIs(1)) << "all cameras have the same";
  EXPECT_THAT((*added)->remarks[0], HasSubstr("'cam00', 'cam01'"));
  EXPECT_THAT((*added)->remarks[0], HasSubstr("top 15 px, bottom 15 px; 2 overlays: "));
  EXPECT_THAT((*added)->remarks[0], HasSubstr("--added keep"));
  const Result<capture::AddedFile> file = capture::load_added(TakeLayout(*folder / "added"));
  ASSERT_THAT(file, IsOk());
  EXPECT_EQ(file->cameras.size(), stage->rig.cameras.size());
  EXPECT_THAT(capture::load_added(TakeLayout(*folder / "plain"))->cameras, IsEmpty());
}

TEST_F(AddedToPictures, IsInNoPhotographThatATakeGives) {
  const auto take = *capture::TakeReader::open(*folder / "added");
  for (int f = 0; f < kFrames; ++f)
    for (std::size_t c = 0; c < stage->rig.cameras.size(); ++c) {
      const Image shown = *to_rgb(*take->frame(static_cast<int>(c), f));
      const Image& truth = stage->pictures[static_cast<std::size_t>(f)][c];
      std::size_t off = 0;
      for (std::size_t i = 0; i < shown.pixels.size(); ++i)
        off += std::abs(shown.pixels[i] - truth.pixels[i]) > 40;
      EXPECT_LE(off, shown.pixels.size() / 250) << "camera " << c << ", frame " << f;
    }
}

TEST_F(AddedToPictures, IsInNoMatteAndInNoHull) {
  double mean = 0, without = 0;
  for (int f = 0; f < kFrames; ++f) {
    const auto at = static_cast<std::size_t>(f);
    for (std::size_t c = 0; c < stage->rig.cameras.size(); ++c) {
      const std::string& serial = stage->rig.cameras[c].serial;
      const auto matte_in = [&](const char* take) {
        return seen(make_matte({}, *load_png(TakeLayout(*folder / take).matte(serial, f))));
      };
      const double with = iou(matte_in("added"), seen(stage->truth[at][c])),
                   before = iou(matte_in("plain"), seen(stage->truth[at][c]));
      EXPECT_GE(with, before - 0.03) << serial << " frame " << f;
      mean += with, without += before;
    }
    const Mesh a = *load_ply(TakeLayout(*folder / "added").mesh(f)),
               b = *load_ply(TakeLayout(*folder / "plain").mesh(f));
    EXPECT_NEAR(signed_volume(a) / signed_volume(b), 1, 0.03) << "frame " << f;
  }
  EXPECT_GE(mean, without - 0.005 * kFrames * kCameras);
}

TEST_F(AddedToPictures, IsNotLookedForAgainAndIsShownOnRequest) {
  const fs::path take = *folder / "again";
  fs::copy(*folder / "added", take, fs::copy_options::recursive);
  const Result<ProcessReport> again = process_take({.take = take});
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->mattes.made + again->meshes.made, 0);
  EXPECT_THAT(again->remarks, SizeIs(1)) << "each run says what it hides";
  const Result<ProcessReport> kept = process_take({.take = take, .hide_added = false});
  ASSERT_THAT(kept, IsOk());
  EXPECT_THAT(kept->remarks, IsEmpty());
  EXPECT_EQ(kept->mattes.made, kFrames * kCameras) << "of other pictures";
  const auto reader = *capture::TakeReader::open(take);
  EXPECT_EQ((*to_rgb(*reader->frame(0, 0))).at(5, 5)[1], 0) << "the bar";
  const Result<ProcessReport> hidden = process_take({.take = take, .hide_added = true});
  ASSERT_THAT(hidden, IsOk());
  EXPECT_THAT(hidden->remarks, SizeIs(1));
}

TEST_F(AddedToPictures, MakesMeshesOfGivenMattesAnewWhenItsBarsChange) {
  const fs::path take = *folder / "given";
  fs::copy(*folder / "added", take, fs::copy_options::recursive);
  fs::remove(TakeLayout(take).made_mattes());
  fs::remove_all(take / "meshes");
  const auto process = [&] { return process_take({.take = take, .matte = "given"}); };
  const Result<ProcessReport> first = process();
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(first->mattes.made, 0);
  EXPECT_EQ(first->meshes.made, kFrames);
  capture::AddedFile all = *capture::load_added(TakeLayout(take));
  all.cameras["cam00"].overlays.clear();
  ASSERT_THAT(capture::save_added(all, TakeLayout(take)), IsOk());
  EXPECT_EQ(process()->meshes.made, 0) << "overlays carve like what is around them: mattes tell of them";
  all.cameras["cam00"].left = 20;
  ASSERT_THAT(capture::save_added(all, TakeLayout(take)), IsOk());
  EXPECT_EQ(process()->meshes.made, kFrames) << "behind bars nothing is carved";
}

TEST_F(AddedToPictures, IsNotScored) {
  const auto take = *capture::TakeReader::open(*folder / "added");
  const AddedContent hidden = capture::load_added(take->layout())->of("cam01");
  ASSERT_THAT(hidden.overlays, Not(IsEmpty()));
  EvaluateOptions options;
  options.hold_out = {"cam01"};
  options.methods = {"nearest"};
  options.renderer.back_end = render::BackEnd::Cpu;
  int views = 0;
  EXPECT_THAT(evaluate_take(*take, options,
                            [&](const HeldOutView& view) -> Result<void> {
                              ++views;
                              long scored = 0;
                              const Image seen = seen_by_lens(hidden, view.mask.width, view.mask.height);
                              for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
                                EXPECT_FALSE(view.mask.pixels[i] && !seen.pixels[i]);
                                scored += view.mask.pixels[i] > 0;
                              }
                              EXPECT_GT(scored, 500);
                              return {};
                            }),
              IsOk());
  EXPECT_EQ(views, 1);
}

TEST_F(AddedToPictures, IsABadFileWithASentence) {
  const fs::path take = *folder / "bad";
  fs::copy(*folder / "added", take, fs::copy_options::recursive);
  capture::AddedFile all{.hidden = true, .cameras = {{"cam00", {.top = 200, .bottom = 200}}}};
  ASSERT_THAT(capture::save_added(all, TakeLayout(take)), IsOk());
  const auto opened = capture::TakeReader::open(take);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("the bars of camera 'cam00' leave nothing"));
  for (
      const char* json :
      {"{}",
       R"({"floatstage_added":1,"hidden":true,"cameras":[{"serial":"a","bars":[-1,0,0,0],"overlays":[]}]})",
       R"({"floatstage_added":1,"hidden":true,"cameras":[{"serial":"a","bars":[0,0,0,0],"overlays":[[1,2]]}]})"})
    EXPECT_FALSE(capture::parse_added(json, "added.json")) << json;
}

}  // namespace
}  // namespace floatstage::pipeline
