#include "pipeline/evaluate/evaluate_mattes.h"

#include <filesystem>

#include "core/file.h"
#include "core/png.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class EvaluateMattes : public testing::Test {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(small_take(folder_, 3));
    ASSERT_THAT(opened, IsOk());
    take_ = std::move(*opened);
    fs::copy(take_->layout().truth().mattes(), take_->layout().mattes(), fs::copy_options::recursive);
  }
  Result<std::vector<CameraMatteScores>> scores() const {
    return evaluate_mattes(*take_, take_->layout().truth().mattes(), {0, 1, 2});
  }
  TempFolder folder_;
  std::unique_ptr<capture::TakeReader> take_;
};

TEST_F(EvaluateMattes, FindsNoFaultInTheTruth) {
  const auto all = scores();
  ASSERT_THAT(all, IsOk());
  ASSERT_EQ(all->size(), 6u);
  for (const CameraMatteScores& c : *all) {
    EXPECT_EQ(c.frames, 3);
    EXPECT_EQ(c.mean.sad, 0);
    EXPECT_EQ(c.mean.iou, 1);
    EXPECT_EQ(c.dtssd, 0.0);
  }
}

TEST_F(EvaluateMattes, NamesTheWorstFrameAndItsFlicker) {
  ASSERT_THAT(save_png(Image(160, 120, 1), take_->layout().matte("cam02", 1)), IsOk());
  const auto all = scores();
  ASSERT_THAT(all, IsOk());
  const CameraMatteScores& c = (*all)[2];
  EXPECT_EQ(c.serial, "cam02");
  EXPECT_EQ(c.worst_frame, 1);
  EXPECT_EQ(c.worst_iou, 0);
  EXPECT_NEAR(c.mean.iou, 2.0 / 3, 1e-9);
  EXPECT_GT(*c.dtssd, 0.1);
  EXPECT_EQ((*all)[1].mean.sad, 0) << "the others are not touched";
}

TEST_F(EvaluateMattes, LeavesOutFramesWithoutATruthAndHasNoFlickerWithoutNeighbours) {
  fs::remove(take_->layout().truth().matte("cam00", 1));
  const auto all = scores();
  ASSERT_THAT(all, IsOk());
  EXPECT_EQ((*all)[0].frames, 2);
  EXPECT_FALSE((*all)[0].dtssd);
}

TEST_F(EvaluateMattes, CountsTheOperatorsEffort) {
  MatteEdits edits;
  edits.cameras["cam03"].keyframes.push_back(
      {0, {{MatteLabel::Foreground, 3, {{80, 60}}}, {MatteLabel::Background, 3, {{5, 5}}}}});
  ASSERT_THAT(save_matte_edits(edits, take_->layout().edits()), IsOk());
  const auto all = scores();
  ASSERT_THAT(all, IsOk());
  EXPECT_EQ((*all)[3].effort.keyframes, 1);
  EXPECT_EQ((*all)[3].effort.clicks, 2);
  EXPECT_EQ((*all)[0].effort.clicks, 0);
}

TEST_F(EvaluateMattes, ReadsTheAlphaOfATruthInColour) {
  const fs::path file = take_->layout().truth().matte("cam01", 0);
  const Image alpha = *load_png(file);
  Image layer(alpha.width, alpha.height, 4);
  for (std::size_t p = 0; p < alpha.pixels.size(); ++p) layer.pixels[4 * p + 3] = alpha.pixels[p];
  ASSERT_THAT(save_png(layer, file), IsOk());
  const auto all = scores();
  ASSERT_THAT(all, IsOk());
  EXPECT_EQ((*all)[1].mean.sad, 0);

  Image photograph(alpha.width, alpha.height, 3);
  photograph.pixels[0] = 200;
  ASSERT_THAT(save_png(photograph, file), IsOk());
  EXPECT_THAT(scores(), FailsWith(ErrorCode::BadData, "cam01"));
}

TEST_F(EvaluateMattes, RefusesWhatIsNoPair) {
  ASSERT_THAT(save_png(Image(80, 60, 1), take_->layout().matte("cam01", 0)), IsOk());
  EXPECT_THAT(scores(), FailsWith(ErrorCode::BadData, "80x60"));
  EXPECT_THAT(evaluate_mattes(*take_, folder_ / "nothing", {0}), FailsWith(ErrorCode::NotFound, "nothing"));
}

}  // namespace
}  // namespace floatstage::pipeline
