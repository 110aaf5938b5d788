#include "pipeline/matte/plate_correction.h"

#include <filesystem>

#include "core/file.h"
#include "core/matte.h"
#include "core/png.h"
#include "pipeline/keying.h"
#include "pipeline/metrics/matte_metrics.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// One instant of a studio with cloth, and plates that were shot.
class AStageWithPlates {
 public:
  explicit AStageWithPlates(SyntheticStage stage) {
    SynthesizeOptions options;
    options.out = folder_ / "take";
    options.rig = {.cameras = 2, .width = 320, .height = 240};
    options.studio = {.seed = 3, .samples = 4, .stage = stage, .defects = {.noise = 1}};
    options.frames = 1;
    EXPECT_THAT(synthesize_take(options), IsOk());
    take_ = std::move(*capture::TakeReader::open(folder_ / "take"));
  }
  fs::path plate() const { return take_->layout().plate(take_->rig().cameras[0].serial); }

  std::unique_ptr<matting::Keyer> keyer(const std::string& word = "chroma") {
    Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(*take_, 0, word);
    EXPECT_THAT(keyer, IsOk());
    return std::move(*keyer);
  }
  Result<std::shared_ptr<const PlateCorrection>> asked(const matting::Keyer& keyer) {
    return PlateCorrection::of(*take_, 0, keyer);
  }
  std::shared_ptr<const PlateCorrection> correction(const matting::Keyer& keyer) {
    Result<std::shared_ptr<const PlateCorrection>> made = asked(keyer);
    EXPECT_THAT(made, IsOk());
    return *made;
  }
  Frame photograph() { return *take_->frame(0, 0); }
  Image truth() const {
    return *load_png(folder_ / "take" / "truth" / "mattes" / take_->rig().cameras[0].serial / "000000.png");
  }

 private:
  TempFolder folder_;
  std::unique_ptr<capture::TakeReader> take_;
};

struct Gain {
  SyntheticStage stage;
  double least, gain;  ///< IoU with the truth, and what the plate adds to that of the key alone, at least
};

class PlatesOnStages : public testing::TestWithParam<Gain> {};

TEST_P(PlatesOnStages, CorrectAKeyByColour) {
  AStageWithPlates stage(GetParam().stage);
  const auto keyer = stage.keyer();
  const Image key = to_image(*keyer->key(stage.photograph()));
  const auto correction = stage.correction(*keyer);
  ASSERT_TRUE(correction);
  const Result<Image> corrected = correction->correct(stage.photograph(), key);
  ASSERT_THAT(corrected, IsOk());
  const double before = matte_iou(key, stage.truth()), after = matte_iou(*corrected, stage.truth());
  RecordProperty("before", std::to_string(before));
  RecordProperty("after", std::to_string(after));
  EXPECT_GE(after, GetParam().least);
  EXPECT_GE(after - before, GetParam().gain);
}
INSTANTIATE_TEST_SUITE_P(PlateCorrection, PlatesOnStages,
                         testing::Values(Gain{SyntheticStage::Green, 0.96, -0.005},
                                         Gain{SyntheticStage::BlueCyclorama, 0.94, 0.03},
                                         Gain{SyntheticStage::Cables, 0.95, 0.005}),
                         [](const auto& each) {
                           return each.param.stage == SyntheticStage::Green           ? "Green"
                                  : each.param.stage == SyntheticStage::BlueCyclorama ? "Blue"
                                                                                      : "Cables";
                         });

TEST(PlateCorrection, IsNoneWhereNobodyShotAPlate) {
  AStageWithPlates stage(SyntheticStage::Green);
  fs::remove(stage.plate());
  EXPECT_FALSE(stage.correction(*stage.keyer()));
}

TEST(PlateCorrection, IsNoneForAKeyerThatComparesWithThePlateAnyway) {
  AStageWithPlates stage(SyntheticStage::Green);
  EXPECT_FALSE(stage.correction(*stage.keyer("difference")));
}

TEST(PlateCorrection, IsNoneWhereTheLightHasChangedSince) {
  AStageWithPlates stage(SyntheticStage::Green);
  const auto keyer = stage.keyer();
  Image plate = *load_png(stage.plate());
  for (std::uint8_t& p : plate.pixels) p = static_cast<std::uint8_t>(p / 2);
  ASSERT_THAT(save_png(plate, stage.plate()), IsOk());
  EXPECT_FALSE(stage.correction(*keyer));
}

TEST(PlateCorrection, IsNoneWhereTheCameraHasMovedSince) {
  AStageWithPlates stage(SyntheticStage::Cables);
  const auto keyer = stage.keyer();
  const Image plate = *load_png(stage.plate());
  Image moved = plate;
  for (int y = 0; y < plate.height; ++y)
    for (int x = 0; x < plate.width; ++x)
      std::copy_n(plate.at((x + 12) % plate.width, std::min(y + 5, plate.height - 1)), 3, moved.at(x, y));
  ASSERT_THAT(save_png(moved, stage.plate()), IsOk());
  EXPECT_FALSE(stage.correction(*keyer));
}

TEST(PlateCorrection, TakesSeveralPlatesFromAFolder) {
  AStageWithPlates stage(SyntheticStage::Cables);
  const fs::path folder = fs::path(stage.plate()).replace_extension();
  fs::create_directory(folder);
  fs::rename(stage.plate(), folder / "00.png");
  fs::copy_file(folder / "00.png", folder / "01.png");
  EXPECT_TRUE(stage.correction(*stage.keyer()));
}

TEST(PlateCorrection, APlateThatCannotBeReadIsNamed) {
  AStageWithPlates stage(SyntheticStage::Green);
  const auto keyer = stage.keyer();
  ASSERT_THAT(write_file(stage.plate(), "no picture"), IsOk());
  EXPECT_THAT(stage.asked(*keyer), FailsWith(ErrorCode::BadData, stage.plate().filename().string()));
}

}  // namespace
}  // namespace floatstage::pipeline
