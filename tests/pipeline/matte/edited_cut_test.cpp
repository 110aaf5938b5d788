// Where a click makes the key, every stroke makes another one: the editor must make what the verb would.

#include <algorithm>
#include <cstdio>

#include "core/file.h"
#include "core/matte.h"
#include "core/png.h"
#include "pipeline/matte/edited_camera.h"
#include "pipeline/matte/matte_take.h"
#include "tests/matting/operator_strokes.h"
#include "tests/support/clip_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

std::vector<Image> mattes_of(const fs::path& take, int frames) {
  std::vector<Image> all;
  for (int f = 0; f < frames; ++f) {
    Result<Image> matte = load_png(TakeLayout(take).matte("cam0", f));
    EXPECT_THAT(matte, IsOk());
    all.push_back(matte ? std::move(*matte) : Image());
  }
  return all;
}

TEST(EditingACut, MakesTheBytesOfTheVerbAfterEveryStrokeAndMask) {
  constexpr int kFrames = 6;
  const MatteClip clip = make_clip(studio_cutout(2, 240, 240), cluttered_place(180, 120, 2),
                                   {.width = 180, .height = 120, .frames = kFrames, .seed = 2});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip), replay = clip_take(folder, clip, "replay");
  CameraEdits edits;
  std::vector<CameraEdits> steps;
  edits.keyframes.push_back({0, {{MatteLabel::Foreground, 3, {{90, 60}}}}});
  steps.push_back(edits);
  edits.masks.push_back({MatteLabel::Background, {{0, 0}, {90, 0}, {90, 40}}, 0, 2});
  steps.push_back(edits);
  edits.keyframes.push_back({3, {{MatteLabel::Background, 2, {{20, 100}}}}});
  steps.push_back(edits);
  edits.keyframes.clear();
  steps.push_back(edits);
  Result<std::unique_ptr<EditedCamera>> camera =
      EditedCamera::open({.take = take, .serial = "cam0", .how = "closed-form", .threads = 2});
  ASSERT_THAT(camera, IsOk());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i == 2) {  // another session goes on
      camera = EditedCamera::open({.take = take, .serial = "cam0"});
      ASSERT_THAT(camera, IsOk());
    }
    for (const fs::path& t : {take, replay}) {
      ASSERT_THAT(make_folder(TakeLayout(t).mattes()), IsOk());
      ASSERT_THAT(save_matte_edits({{{"cam0", steps[i]}}}, TakeLayout(t).edits()), IsOk());
    }
    const Result<std::vector<int>> changed = (*camera)->remake(steps[i], {});
    ASSERT_THAT(changed, IsOk());
    if (i == 1) {
      EXPECT_LE(changed->size(), 3u) << "a mask changes its frames only";
    }
    ASSERT_THAT(
        matte_take({.take = replay, .how = "closed-form", .threads = 2, .redo = true, .hull_frames = 0}),
        IsOk());
    EXPECT_EQ(mattes_of(take, kFrames), mattes_of(replay, kFrames)) << "step " << i;
  }
}

double mean_overlap(const std::vector<Image>& mattes, const std::vector<Image>& truth) {
  double sum = 0;
  for (std::size_t f = 0; f < truth.size(); ++f)
    sum += iou(make_matte({}, mattes[f]), make_matte({}, truth[f]));
  return sum / static_cast<double>(truth.size());
}

// The first click cuts the dancer out, or chooses components; each that is right after it may only help, in
// its frame and in all of them.
class ClicksWithoutAKey : public testing::TestWithParam<std::string> {};

TEST_P(ClicksWithoutAKey, NeverMakeTheMattesWorse) {
  constexpr int kFrames = 6;
  const MatteClip clip = make_clip(studio_cutout(3, 240, 240), cluttered_place(180, 120, 3),
                                   {.width = 180, .height = 120, .frames = kFrames, .seed = 3, .scale = 0.7});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  Result<std::unique_ptr<EditedCamera>> camera =
      EditedCamera::open({.take = take, .serial = "cam0", .how = GetParam(), .threads = 2});
  ASSERT_THAT(camera, IsOk());
  std::vector<Image> now(kFrames, Image(180, 120, 1));
  CameraEdits edits;
  for (const int frame : {2, 2, 2, 4, 4, 3}) {
    const matting::Operator person(clip.truth[static_cast<std::size_t>(frame)]);
    const MatteStroke stroke = person.next(now[static_cast<std::size_t>(frame)], false);
    if (stroke.points.empty()) continue;
    const auto at = std::find_if(edits.keyframes.begin(), edits.keyframes.end(),
                                 [&](const MatteKeyframe& k) { return k.frame >= frame; });
    if (at != edits.keyframes.end() && at->frame == frame)
      at->strokes.push_back(stroke);
    else
      edits.keyframes.insert(at, {frame, {stroke}});
    ASSERT_THAT(make_folder(TakeLayout(take).mattes()), IsOk());
    ASSERT_THAT(save_matte_edits({{{"cam0", edits}}}, TakeLayout(take).edits()), IsOk());
    ASSERT_THAT((*camera)->remake(edits, {}), IsOk());
    std::vector<Image> made = mattes_of(take, kFrames);
    const std::size_t f = static_cast<std::size_t>(frame);
    EXPECT_NE(made[f], now[f]) << "it acts where it was given";
    EXPECT_GE(mean_overlap({made[f]}, {clip.truth[f]}), mean_overlap({now[f]}, {clip.truth[f]}) - 0.01);
    EXPECT_GE(mean_overlap(made, clip.truth), mean_overlap(now, clip.truth) - 0.01);
    std::printf("  %s, frame %d: %.4f\n", GetParam().c_str(), frame, mean_overlap(made, clip.truth));
    now = std::move(made);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, ClicksWithoutAKey, testing::Values("closed-form", "spectral"),
                         [](const auto& suite) {
                           return suite.param == "spectral" ? "Spectral" : "ClosedForm";
                         });

}  // namespace
}  // namespace floatstage::pipeline
