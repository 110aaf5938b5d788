#include "studio/node/camera_view_maker.h"

#include <cstring>

#include "core/check.h"
#include "tests/studio/synthetic_shots.h"

namespace floatstage::studio {
namespace {

constexpr Instant kInstant{7, {1'000'000}};
constexpr Timestamp kProduced{1'500'000};

class ACameraViewMaker : public testing::Test {
 protected:
  CameraViewMaker node(const std::string& spec = "chroma") {
    Result<CameraViewMaker> made = CameraViewMaker::make("cam00", shots_.rig.cameras[0].model, spec,
                                                         {.pictures = {shots_.studio.plate(0)}});
    EXPECT_THAT(made, IsOk());
    return std::move(*made);
  }
  CameraView look(CameraViewMaker& at, const Frame& frame, bool textured = false,
                  const NodeQuality& quality = {}) {
    const Result<std::shared_ptr<const CameraView>> view =
        at.look(frame, kInstant, kProduced, textured, quality);
    EXPECT_THAT(view, IsOk());
    return view ? **view : CameraView{};
  }

  SyntheticShots shots_;
  const SyntheticShot shot_ = shots_.studio.shoot(0, 0);
};

TEST_F(ACameraViewMaker, FindsTheOutlineOfTheSubjectAtAnyScaleOfTheKey) {
  CameraViewMaker at = node();
  double before = 1;
  for (const auto& [shrink, least] :
       {std::pair(1, 0.97), std::pair(2, 0.95), std::pair(3, 0.92), std::pair(4, 0.89)}) {
    const CameraView view = look(at, shot_.frame, false, {.shrink = shrink, .tolerance = 0.5});
    ASSERT_TRUE(view.known);
    const double agreement = iou(recon::filled(view.outline, view.width, view.height), shot_.matte);
    EXPECT_GT(agreement, least) << "keyed at 1/" << shrink;
    EXPECT_LT(agreement, before + 0.01);
    before = agreement;
  }
}

TEST_F(ACameraViewMaker, LeavesSpecksOutOfTheOutlineAndKeepsThemInTheTile) {
  Image picture = *to_rgb(shot_.frame);
  const Image truth = to_image(shot_.matte);
  for (int y = 100; y < 140; y += 4)  // holes of a pixel, filled with the cloth's colour
    for (int x = 2; x < 318; x += 4)
      if (*truth.at(x, y) == 255 && *truth.at(x - 2, y) == 255 && *truth.at(x + 2, y) == 255)
        std::copy_n(shots_.studio.plate(0).at(x, y), 3, picture.at(x, y));
  const Frame frame = make_frame(shot_.frame.info, picture);
  CameraViewMaker at = node();
  const CameraView all = look(at, frame, true, {.smallest = 0}),
                   large = look(at, frame, true, {.smallest = 2e-4});
  EXPECT_LT(large.outline.polygons(), all.outline.polygons());
  for (int k = 0; k < large.outline.polygons(); ++k) {
    double twice = 0;
    const int begin = large.outline.starts[k], end = large.outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &p = large.outline.points[i],
                            &q = large.outline.points[i + 1 < end ? i + 1 : begin];
      twice += p.x() * q.y() - p.y() * q.x();
    }
    EXPECT_GT(std::abs(twice) / 2, 0.5 * 2e-4 * 320 * 240) << "simplifying moves points a little";
  }
  EXPECT_EQ(large.tile->matte, all.tile->matte);
}

TEST_F(ACameraViewMaker, SaysWhenAndWhereItsPictureWasTaken) {
  CameraViewMaker at = node();
  const CameraView view = look(at, shot_.frame);
  EXPECT_EQ(view.serial, "cam00");
  EXPECT_EQ(view.epoch, kInstant.epoch);
  EXPECT_EQ(view.instant, kInstant.time);
  EXPECT_EQ(view.exposed, shot_.frame.info.exposure_start);
  EXPECT_EQ(view.produced, kProduced);
  EXPECT_EQ(view.width, 320);
  EXPECT_EQ(view.height, 240);
}

TEST_F(ACameraViewMaker, HandsOnATextureOnlyWhenOneIsWanted) {
  CameraViewMaker at = node();
  EXPECT_EQ(look(at, shot_.frame).tile, nullptr);
  EXPECT_NE(look(at, shot_.frame, true).tile, nullptr);
}

TEST_F(ACameraViewMaker, CutsTheTextureOutOfThePhotographItself) {
  CameraViewMaker at = node("difference");  // takes no spill off
  const Image photograph = *to_rgb(shot_.frame), truth = to_image(shot_.matte);
  // Limbs of four pixels are one pixel at a quarter.
  for (const auto& [shrink, most] : {std::pair(1, 0.08), std::pair(2, 0.12), std::pair(4, 0.2)}) {
    const CameraView view = look(at, shot_.frame, true, {.shrink = shrink, .tolerance = 0.5});
    ASSERT_NE(view.tile, nullptr);
    const ForegroundTile& tile = *view.tile;
    EXPECT_LT(tile.picture.width * tile.picture.height, 320 * 240 / 2) << "most of the photograph is cloth";
    ASSERT_EQ(tile.matte.width, tile.picture.width);
    for (int y = 0; y < tile.picture.height; ++y)
      ASSERT_EQ(0, std::memcmp(tile.picture.at(0, y), photograph.at(tile.x, tile.y + y),
                               static_cast<std::size_t>(tile.picture.width) * 3));
    long wrong = 0, subject = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const int u = x - tile.x, v = y - tile.y;
        const bool in = u >= 0 && v >= 0 && u < tile.matte.width && v < tile.matte.height;
        const bool is = in && *tile.matte.at(u, v) >= 128, should = *truth.at(x, y) >= 128;
        wrong += is != should;
        subject += should;
      }
    }
    EXPECT_LT(static_cast<double>(wrong), most * static_cast<double>(subject)) << "keyed at 1/" << shrink;
  }
}

TEST_F(ACameraViewMaker, TakesTheClothsLightOffTheTexture) {
  CameraViewMaker at = node();
  const CameraView view = look(at, shot_.frame, true);
  ASSERT_NE(view.tile, nullptr);
  long greener = 0, all = 0;
  for (std::size_t i = 0; i < view.tile->picture.pixels.size(); i += 3, ++all) {
    const std::uint8_t* p = view.tile->picture.pixels.data() + i;
    greener += p[1] > std::max(p[0], p[2]) + 8;
  }
  EXPECT_EQ(greener, 0) << "of " << all << " pixels";
}

TEST_F(ACameraViewMaker, KnowsNothingOfAnInstantThatItMissed) {
  CameraViewMaker at = node();
  Frame corrupt = shot_.frame;
  corrupt.info.status = FrameStatus::Corrupt;
  for (const Frame& frame : {Frame{}, corrupt}) {
    look(at, shot_.frame, true);  // whose memory is used again
    const CameraView view = look(at, frame, true);
    EXPECT_FALSE(view.known) << "it must not carve";
    EXPECT_TRUE(view.outline.empty());
    EXPECT_EQ(view.tile, nullptr);
    EXPECT_EQ(view.epoch, kInstant.epoch) << "but it says which instant that was";
  }
}

TEST_F(ACameraViewMaker, LeavesAViewAloneAsLongAsSomebodyHasIt) {
  CameraViewMaker at = node();
  const auto looked = [&](int frame) {
    return std::move(*at.look(shots_.studio.shoot(0, frame).frame, kInstant, kProduced, true, {}));
  };
  const std::shared_ptr<const CameraView> held = looked(0);
  const CameraView copy = *held;
  const ForegroundTile tile = *copy.tile;
  const CameraView* dropped = looked(12).get();
  EXPECT_EQ(looked(24).get(), dropped) << "what nobody has is used again";
  EXPECT_EQ(held->outline.points, copy.outline.points);
  EXPECT_EQ(held->tile, copy.tile);
  EXPECT_EQ(held->tile->picture, tile.picture);
  EXPECT_EQ(held->tile->matte, tile.matte);
}

TEST_F(ACameraViewMaker, SeesThatNobodyIsThere) {
  CameraViewMaker at = node();
  const CameraView view = look(at, make_frame(shot_.frame.info, shots_.studio.plate(0)), true);
  EXPECT_TRUE(view.known) << "an empty stage carves all that this camera sees";
  EXPECT_TRUE(view.outline.beyond_counts);
  EXPECT_EQ(view.tile, nullptr);
}

TEST_F(ACameraViewMaker, GivesTheSameViewFromTheSameFrame) {
  CameraViewMaker used = node();
  for (const int shrink : {1, 2, 3}) {
    const NodeQuality quality{.shrink = shrink, .tolerance = 1};
    CameraViewMaker fresh = node();
    for (const int frame : {9, 30})
      for (const int before : {4, shrink})  // what it saw before does not matter
        look(used, shots_.studio.shoot(0, frame).frame, true, {.shrink = before, .tolerance = 1});
    const CameraView a = look(used, shot_.frame, true, quality), b = look(fresh, shot_.frame, true, quality);
    EXPECT_EQ(a.outline.points, b.outline.points) << "keyed at 1/" << shrink;
    EXPECT_EQ(a.tile->picture, b.tile->picture);
    EXPECT_EQ(a.tile->matte, b.tile->matte) << "keyed at 1/" << shrink;
  }
}

TEST_F(ACameraViewMaker, SeesTheSameWhetherItWasPreparedOrNot) {
  CameraViewMaker prepared = node(), surprised = node();
  ASSERT_THAT(prepared.prepare(3), IsOk());
  const NodeQuality quality{.shrink = 3, .tolerance = 1};
  const CameraView a = look(prepared, shot_.frame, false, quality),
                   b = look(surprised, shot_.frame, false, quality);
  EXPECT_FALSE(a.outline.empty());
  EXPECT_EQ(a.outline.points, b.outline.points);
}

TEST_F(ACameraViewMaker, NamesTheCameraWhenSomethingIsWrong) {
  CameraViewMaker at = node();
  EXPECT_THAT(at.look(make_frame({}, Image(64, 48, 3)), kInstant, kProduced, false, {}),
              FailsWith(ErrorCode::BadData, "'cam00' delivers 64x48"));
  EXPECT_THAT(at.look(make_frame({}, Image(320, 240, 1)), kInstant, kProduced, false, {}),
              FailsWith(ErrorCode::Unsupported, "'cam00'"));
  EXPECT_THAT(CameraViewMaker::make("cam07", shots_.rig.cameras[0].model, "guess", {}),
              FailsWith(ErrorCode::InvalidArgument, "'cam07'"));
}

TEST_F(ACameraViewMaker, SaysThatAPlateOfAnotherSizeCorrectsNothing) {
  testing::internal::CaptureStderr();
  Result<CameraViewMaker> at = CameraViewMaker::make(
      "cam07", shots_.rig.cameras[0].model, "chroma",
      {.pictures = {*shrink(make_frame({}, shots_.studio.plate(0)), 2)}, .empty_stage = true});
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("'cam07': its plate is 160x120"));
  ASSERT_THAT(at, IsOk());
  CameraViewMaker plain = node();
  EXPECT_EQ(look(*at, shot_.frame).known, look(plain, shot_.frame).known);
}

TEST(NodeQuality, IsCheckedWithASentence) {
  EXPECT_THAT(check(NodeQuality{}), IsOk());
  EXPECT_THAT(check(NodeQuality{.shrink = 0, .tolerance = 0.5}),
              FailsWith(ErrorCode::InvalidArgument, "1/0"));
  EXPECT_THAT(check(NodeQuality{.shrink = 9, .tolerance = 0.5}),
              FailsWith(ErrorCode::InvalidArgument, "1/9"));
  EXPECT_THAT(check(NodeQuality{.shrink = 2, .tolerance = -1}),
              FailsWith(ErrorCode::InvalidArgument, "tolerance"));
  EXPECT_THAT(check(NodeQuality{.smallest = 0.5}), FailsWith(ErrorCode::InvalidArgument, "islands"));
}

}  // namespace
}  // namespace floatstage::studio
