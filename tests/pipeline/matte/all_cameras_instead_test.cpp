// What `auto` does on a stage whose cloth covers the floor and no wall: keys take walls for the performer,
// and all cameras together know better.
#include "pipeline/matte/all_cameras_instead.h"

#include <optional>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/random.h"
#include "pipeline/import/import.h"
#include "pipeline/metrics/matte_metrics.h"
#include "pipeline/plan/process_plan.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr int kCameras = 8;

// A studio's pictures, in which cloth above `horizon` (a share of the height) is a wall of patches; or in the
// pictures of one camera alone, which sees no more than a mat.
class ACarpetOfCloth {
 public:
  explicit ACarpetOfCloth(double horizon, std::optional<std::size_t> alone = {}) {
    SynthesizeOptions options;
    options.out = folder_ / "studio";
    options.rig = {.cameras = kCameras, .width = 320, .height = 240};
    options.studio = {.seed = 5, .samples = 4, .defects = {.noise = 1}};
    options.frames = 1;
    EXPECT_THAT(synthesize_take(options), IsOk());
    const auto studio = *capture::TakeReader::open(options.out);
    for (std::size_t c = 0; c < studio->rig().cameras.size(); ++c) {
      const std::string& serial = studio->rig().cameras[c].serial;
      Image picture = *to_rgb(*studio->frame(static_cast<int>(c), 0));
      const int line = static_cast<int>(horizon * picture.height);
      if (!alone || c == *alone) hang_wall(c, line, alone ? picture.width / 3 : 0, truth(serial), picture);
      fs::create_directories(folder_ / "pictures" / serial);
      EXPECT_THAT(save_png(picture, folder_ / "pictures" / serial / "000000.png"), IsOk());
    }
    ImportOptions import;
    import.calibration = {"rig", options.out / "rig.json"};
    import.pictures = folder_ / "pictures";
    import.out = take();
    EXPECT_THAT(import_take(import), IsOk());
  }

  fs::path take() const { return folder_ / "take"; }
  Result<MatteReport> made(const std::optional<std::string>& how, bool redo = false,
                           const std::vector<std::string>& cameras = {}) const {
    return matte_take({.take = take(), .how = how, .cameras = cameras, .redo = redo, .check = false});
  }
  std::string matte(const std::string& serial) const {
    return *read_file(TakeLayout(take()).matte(serial, 0));
  }
  double iou(const std::string& serial) const {
    return matte_iou(*load_png(TakeLayout(take()).matte(serial, 0)), truth(serial));
  }
  const TempFolder& folder() const { return folder_; }

 private:
  Image truth(const std::string& serial) const {
    return *load_png(folder_ / "studio" / "truth" / "mattes" / serial / "000000.png");
  }
  // And beside what lies below the horizon, `beside` pixels from the left and from the right.
  static void hang_wall(std::size_t camera, int horizon, int beside, const Image& truth, Image& picture) {
    Random random(100 + camera);
    constexpr int kPatch = 16;
    for (int y = 0; y < (beside > 0 ? picture.height : horizon); y += kPatch)
      for (int x = 0; x < picture.width; x += kPatch) {
        if (y >= horizon && x >= beside && x < picture.width - beside) continue;
        const int grey = 60 + static_cast<int>(60 * random.uniform());
        const int tint[3] = {grey + 25, grey + 10, grey};
        for (int v = y; v < std::min(y + kPatch, beside > 0 ? picture.height : horizon); ++v)
          for (int u = x; u < std::min(x + kPatch, picture.width); ++u)
            for (int k = 0; k < 3; ++k) {
              const int alpha = *truth.at(u, v), noise = static_cast<int>(std::lround(random.normal()));
              std::uint8_t& value = picture.at(u, v)[k];
              value = static_cast<std::uint8_t>((alpha * value + (255 - alpha) * (tint[k] + noise)) / 255);
            }
      }
  }

  TempFolder folder_;
};

std::vector<std::string> methods(const MatteReport& report) {
  std::vector<std::string> all;
  for (const CameraMattes& camera : report.cameras) all.push_back(camera.method);
  return all;
}

TEST(AllCamerasInstead, MakeTheMattesWhereKeysDoNotHold) {
  const ACarpetOfCloth stage(0.5);
  const Result<MatteReport> report = stage.made("auto");
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(methods(*report), testing::Each("consistent"));
  EXPECT_THAT(report->remarks,
              Contains(AllOf(HasSubstr("frame 0: keys do not hold (they tell nobody in 0 of 8 cameras"),
                             HasSubstr("--matte consistent"))));
  EXPECT_EQ(report->distrusted, 0);
  EXPECT_TRUE(report->doubts.empty());
  double sum = 0;
  for (const CameraMattes& camera : report->cameras) sum += stage.iou(camera.serial);
  EXPECT_GE(sum / kCameras, 0.93);

  const std::string before = stage.matte("cam03");
  for (const std::optional<std::string>& how :
       {std::optional<std::string>(), std::optional<std::string>("auto")}) {
    const Result<MatteReport> again = stage.made(how);
    ASSERT_THAT(again, IsOk());
    EXPECT_EQ(again->made, 0) << "what auto came to stands";
    EXPECT_THAT(methods(*again), testing::Each("consistent"));
  }
  const Result<MatteReport> anew = stage.made("auto", true);
  ASSERT_THAT(anew, IsOk());
  EXPECT_EQ(anew->made, kCameras);
  EXPECT_EQ(stage.matte("cam03"), before);
}

TEST(AllCamerasInstead, ComeToTheSameForOneCameraAndForAll) {
  const ACarpetOfCloth stage(0.5);
  const Result<MatteReport> one = stage.made("auto", false, {"cam02"});
  ASSERT_THAT(one, IsOk());
  EXPECT_THAT(methods(*one), testing::Each("consistent")) << "keys of all cameras are asked";
  const std::string first = stage.matte("cam02");
  ASSERT_THAT(stage.made("auto"), IsOk());
  EXPECT_EQ(stage.matte("cam02"), first);
  const std::string in_one_run = stage.matte("cam05");
  ASSERT_THAT(stage.made("auto", true), IsOk());
  EXPECT_EQ(stage.matte("cam05"), in_one_run);
}

TEST(AllCamerasInstead, AreOneItemOfAPlan) {
  const ACarpetOfCloth stage(0.5);
  const Result<Plan> plan = plan_mattes({.take = stage.take(), .how = "auto"}, 1);
  ASSERT_THAT(plan, IsOk());
  ASSERT_FALSE(plan->items.empty());
  EXPECT_EQ(plan->items.front().cameras.size(), static_cast<std::size_t>(kCameras));
  EXPECT_EQ(plan->items.front().with.at("how"), "auto");
  EXPECT_EQ(plan->items.front().with.at("together"), "yes");
  EXPECT_THAT(plan->remarks, testing::ElementsAre(HasSubstr("keys do not hold")))
      << "items do not say it again";
}

TEST(AllCamerasInstead, AreNotAskedWhereKeysHold) {
  const ACarpetOfCloth stage(0);
  const Result<MatteReport> report = stage.made("auto");
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(methods(*report), Not(Contains("consistent")));
  EXPECT_TRUE(report->remarks.empty()) << testing::PrintToString(report->remarks);
}

// Skin before walls of its colour: plates alone lose rims and strands of what all cameras and plates keep.
TEST(AllCamerasInstead, MakeTheMattesWherePlatesWereShotAndAreDeniedLess) {
  TempFolder folder;
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig = {.cameras = kCameras, .width = 320, .height = 240};
  options.studio = {.seed = 7, .samples = 4, .stage = SyntheticStage::Room, .defects = {.noise = 1}};
  options.frames = 1;
  ASSERT_THAT(synthesize_take(options), IsOk());
  const auto mean_iou = [&](const MatteReport& report) {
    double sum = 0;
    for (const CameraMattes& c : report.cameras)
      sum += matte_iou(*load_png(TakeLayout(options.out).matte(c.serial, 0)),
                       *load_png(TakeLayout(options.out).truth().matte(c.serial, 0)));
    return sum / kCameras;
  };
  const Result<MatteReport> plates = matte_take({.take = options.out, .how = "plate", .check = false});
  ASSERT_THAT(plates, IsOk());
  const double by_plates = mean_iou(*plates);
  const Result<MatteReport> report =
      matte_take({.take = options.out, .how = "auto", .redo = true, .check = false});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(methods(*report), testing::Each("consistent"));
  EXPECT_THAT(report->remarks, Contains(HasSubstr("plates were shot")));
  EXPECT_GT(mean_iou(*report), by_plates + 0.02);
}

TEST(AllCamerasInstead, OrAGuessMakeTheMatteOfACameraThatHardlySeesCloth) {
  const ACarpetOfCloth stage(0.85, 3);
  const MatteTakeOptions apart{.take = stage.take(), .how = "auto", .together = false, .check = false};
  const Result<MatteReport> report = matte_take(apart);
  ASSERT_THAT(report, IsOk()) << "the key that refuses this camera's picture is not the run's end";
  EXPECT_EQ(report->made, kCameras);
  EXPECT_EQ(report->cameras[3].method, "spectral");
  EXPECT_NE(report->cameras[2].method, "spectral");
  ASSERT_EQ(report->doubts.size(), 1u);
  EXPECT_THAT(report->doubts.front().why, HasSubstr("nothing tells the subject, so it was guessed"));
  EXPECT_THAT(report->doubts.front().cameras, testing::ElementsAre("cam03"));

  const fs::path picture = report->doubts.front().picture;
  EXPECT_TRUE(fs::exists(picture));
  ASSERT_THAT(stage.made("auto", false, {"cam02"}), IsOk());
  EXPECT_TRUE(fs::exists(picture)) << "nobody asked for that camera";
  const Result<MatteReport> otherwise = stage.made("consistent", true);
  ASSERT_THAT(otherwise, IsOk());
  EXPECT_TRUE(otherwise->doubts.empty());
  EXPECT_FALSE(fs::exists(picture)) << "nothing was guessed this time";
}

TEST(AllCamerasInstead, AreNotAskedWhereAPersonSaysSomethingOrAnotherWay) {
  const ACarpetOfCloth stage(0.5);
  const Result<MatteReport> keyed = stage.made("chroma");
  ASSERT_THAT(keyed, IsOk());
  EXPECT_THAT(methods(*keyed), testing::Each("key"));
  MatteEdits edits;
  edits.cameras["cam00"].keyframes = {
      {0, {{.label = MatteLabel::Foreground, .radius = 3, .points = {{160, 120}, {160, 130}}}}}};
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(stage.take()).edits()), IsOk());
  const Result<MatteReport> another = stage.made("auto", true, {"cam02"});
  ASSERT_THAT(another, IsOk());
  EXPECT_THAT(methods(*another), Not(Contains("consistent")))
      << "strokes in any camera say that keys are guided";
  const Result<MatteReport> guided = stage.made("auto", true);
  ASSERT_THAT(guided, IsOk());
  EXPECT_THAT(methods(*guided), Not(Contains("consistent")));
}

}  // namespace
}  // namespace floatstage::pipeline
