// `matte` on clips whose truth is exact: what a click does.

#include "apps/evaluate/matte_metrics.h"
#include "apps/matte/matte_take.h"
#include "core/file.h"
#include "core/matte_edits.h"
#include "tests/apps/clip_take.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

double mean_iou(const fs::path& take, int frames) {
  double sum = 0;
  for (int f = 0; f < frames; ++f) {
    const Result<Image> matte = load_png(TakeLayout(take).matte("cam0", f)), truth = load_png(TakeLayout(take / "truth").matte("cam0", f));
    EXPECT_THAT(matte, IsOk());
    EXPECT_THAT(truth, IsOk());
    if (matte && truth) sum += matte_iou(*matte, *truth) / frames;
  }
  return sum;
}

void click(const fs::path& take, int frame, double x, double y, MatteLabel label = MatteLabel::Foreground) {
  MatteEdits edits;
  edits.cameras["cam0"].keyframes.push_back({frame, {{label, 3, {{x, y}}}}});
  ASSERT_THAT(make_folder(TakeLayout(take).mattes()), IsOk());
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
}

// The middle of the subject's longest row.
std::pair<double, double> inside(const Image& truth) {
  int best = 0, bx = 0, by = 0;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0, run = 0; x < truth.width; ++x)
      if (run = *truth.at(x, y) == 255 ? run + 1 : 0; run > best) best = run, bx = x - run / 2, by = y;
  return {bx + 0.5, by + 0.5};
}

MatteTakeOptions options_for(const fs::path& take, const std::string& method) {
  MatteTakeOptions options;
  options.take = take;
  options.method = method;
  options.threads = 2;
  options.hull_frames = 0;
  return options;
}

TEST(MatteClick, FindsTheDancerInAClutteredPlaceWithoutAPlate) {
  const MatteClip clip = make_clip(studio_cutout(2), cluttered_place(270, 180, 2), {.width = 270, .height = 180, .frames = 16, .seed = 2});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  const auto [x, y] = inside(clip.truth[0]);
  click(take, 0, x, y);
  for (const char* method : {"closed-form", "auto", "spectral"}) {
    MatteTakeOptions options = options_for(take, method);
    options.redo = true;
    const Result<MatteReport> report = matte_take(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->cameras[0].key, "cut");
    EXPECT_EQ(report->cameras[0].clicks, 1);
    EXPECT_GE(mean_iou(take, 16), 0.93) << method;
  }
}

TEST(MatteClick, OnTheBackgroundAloneIsNoSubject) {
  const MatteClip clip = make_clip(studio_cutout(1, 240, 240), cluttered_place(160, 120, 1), {.width = 160, .height = 120, .frames = 6});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  click(take, 0, 5, 5, MatteLabel::Background);
  const Result<MatteReport> report = matte_take(options_for(take, "closed-form"));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].key.substr(0, 5), "plate") << "found behind the performance, as without clicks";
}

}  // namespace
}  // namespace floatstage
