// Where a click makes the key, every stroke makes another one: the editor must make what the verb would.

#include "core/file.h"
#include "core/png.h"
#include "pipeline/matte/edited_camera.h"
#include "pipeline/matte/matte_take.h"
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

}  // namespace
}  // namespace floatstage::pipeline
