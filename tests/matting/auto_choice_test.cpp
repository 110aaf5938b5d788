#include <algorithm>

#include "matting/closed_form.h"
#include "matting/keyers/keyer.h"
#include "matting/method_selection.h"
#include "matting/video/video_matting.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/temp_folder.h"

// What `auto` chooses by, against the truth: on every clip the candidate of least score is the best of key,
// closed form and spectral.
namespace floatstage::matting {
namespace {

struct Candidate {
  std::string name;
  std::vector<Image> mattes;
};

std::vector<Image> keyed(const MatteClip& clip, const char* spec, const std::vector<Image>& samples) {
  const auto keyer = make_keyer(spec, samples);
  EXPECT_THAT(keyer, IsOk());
  std::vector<Image> mattes;
  for (const Image& frame : clip.frames) mattes.push_back(to_image(*(*keyer)->key(make_frame({}, frame))));
  return mattes;
}

std::vector<Image> refined(const MatteClip& clip, const std::vector<Image>& mattes) {
  std::vector<Image> out;
  for (std::size_t f = 0; f < mattes.size(); ++f)
    out.push_back(*refine_matte(clip.frames[f], mattes[f], key_refinement()));
  return out;
}

void expect_the_best(const MatteClip& clip, const std::vector<Candidate>& candidates, const Plate* plate) {
  MethodComparison comparison(candidates.size());
  const auto mattes_of = [&](std::size_t f) {
    std::vector<Image> mattes;
    for (const Candidate& c : candidates) mattes.push_back(c.mattes[f]);
    return mattes;
  };
  for (const std::size_t f : {std::size_t{1}, clip.frames.size() - 1}) {
    comparison.add(clip.frames[f], mattes_of(f), plate);
    comparison.add_pair(clip.frames[f - 1], mattes_of(f - 1), clip.frames[f], mattes_of(f));
  }
  std::vector<double> mse;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ClipScores s = score_clip(candidates[i].mattes, clip.truth);
    mse.push_back(s.mse);
    std::cout << "  " << candidates[i].name << ": score " << comparison.scores()[i] << ", " << s << "\n";
  }
  EXPECT_LE(mse[comparison.best(1)], *std::min_element(mse.begin(), mse.end()))
      << "chose " << candidates[comparison.best(1)].name;
}

// Spectral video matting led by the same key.
std::vector<Image> spectral(const MatteClip& clip, const std::vector<Image>& key) {
  MattingClip frames;
  frames.frames = static_cast<int>(clip.frames.size());
  frames.photograph = [&](int f) -> Result<Image> { return clip.frames[static_cast<std::size_t>(f)]; };
  frames.likelihood = [&](int f) -> Result<MatteConstraint> {
    return MatteConstraint{key[static_cast<std::size_t>(f)], {}};
  };
  TempFolder cache;
  VideoMattingOptions options;
  options.likelihood_is_matte = true;
  Result<VideoMatting> video = VideoMatting::create(frames, cache.path(), options);
  EXPECT_THAT(video, IsOk());
  EXPECT_THAT(video->prepare(), IsOk());
  EXPECT_THAT(video->propagate(), IsOk());
  std::vector<Image> mattes;
  for (int f = 0; f < video->frames(); ++f) mattes.push_back(*video->matte(f));
  return mattes;
}

// Seeds on which the weights were chosen, and others.
class AutoChoice : public testing::TestWithParam<std::uint64_t> {
 protected:
  ClipOptions options() const { return {.width = 240, .height = 160, .frames = 4, .seed = GetParam()}; }
};

TEST_P(AutoChoice, IsNeverWorseThanTheBestOverGreenCloth) {
  FLOATSTAGE_LONG_FORM(GetParam() != 1 && GetParam() != 21);
  const MatteClip clip = make_clip(studio_cutout(GetParam()), green_cloth(240, 160, GetParam()), options());
  const std::vector<Image> key = keyed(clip, "chroma", {clip.frames[0]});
  expect_the_best(
      clip, {{"key", key}, {"closed form", refined(clip, key)}, {"spectral", spectral(clip, key)}}, nullptr);
}

TEST_P(AutoChoice, IsNeverWorseThanTheBestBeforeACleanPlate) {
  FLOATSTAGE_LONG_FORM(GetParam() != 1 && GetParam() != 21);
  const MatteClip clip =
      make_clip(studio_cutout(GetParam()), cluttered_place(240, 160, GetParam()), options());
  const std::vector<Image> key = keyed(clip, "plate", {clip.plate});
  const Plate plate = *learn_plate({clip.plate});
  expect_the_best(
      clip, {{"key", key}, {"closed form", refined(clip, key)}, {"spectral", spectral(clip, key)}}, &plate);
}

INSTANTIATE_TEST_SUITE_P(Tuned, AutoChoice, testing::Values(1, 2, 3));
INSTANTIATE_TEST_SUITE_P(Others, AutoChoice, testing::Values(21, 22, 23));

}  // namespace
}  // namespace floatstage::matting
