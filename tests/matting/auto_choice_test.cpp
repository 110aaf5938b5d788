#include <algorithm>

#include "matting/closed_form.h"
#include "matting/consistency.h"
#include "matting/keyer.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

// What `auto` chooses by, against the truth: on every clip the candidate of least residual is as good as the best.
namespace floatstage {
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
  for (std::size_t f = 0; f < mattes.size(); ++f) out.push_back(*refine_matte(clip.frames[f], mattes[f], key_refinement()));
  return out;
}

void expect_the_best(const MatteClip& clip, const std::vector<Candidate>& candidates, const Plate* plate) {
  std::vector<double> residual(candidates.size()), mse;
  for (std::size_t f = 1; f < clip.frames.size(); f += 3) {
    std::vector<Image> mattes;
    for (const Candidate& c : candidates) mattes.push_back(c.mattes[f]);
    const std::vector<double> r = composite_residuals(clip.frames[f], mattes, plate);
    for (std::size_t i = 0; i < r.size(); ++i) residual[i] += r[i];
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ClipScores s = score_clip(candidates[i].mattes, clip.truth);
    mse.push_back(s.mse);
    std::cout << "  " << candidates[i].name << ": residual " << residual[i] << ", " << s << "\n";
  }
  const auto chosen = static_cast<std::size_t>(std::min_element(residual.begin(), residual.end()) - residual.begin());
  const double best = *std::min_element(mse.begin(), mse.end());
  EXPECT_LE(mse[chosen], best) << "chose " << candidates[chosen].name;
}

class AutoChoice : public testing::TestWithParam<std::uint64_t> {};

TEST_P(AutoChoice, IsNeverWorseThanTheBestOverGreenCloth) {
  const MatteClip clip = make_clip(studio_cutout(GetParam()), green_cloth(360, 240, GetParam()), {.seed = GetParam()});
  const std::vector<Image> key = keyed(clip, "chroma", {clip.frames[0]});
  expect_the_best(clip, {{"key", key}, {"closed form", refined(clip, key)}}, nullptr);
}

TEST_P(AutoChoice, IsNeverWorseThanTheBestBeforeACleanPlate) {
  const MatteClip clip = make_clip(studio_cutout(GetParam()), cluttered_place(360, 240, GetParam()), {.seed = GetParam()});
  const std::vector<Image> key = keyed(clip, "plate", {clip.plate});
  const Plate plate = *learn_plate({clip.plate});
  expect_the_best(clip, {{"key", key}, {"closed form", refined(clip, key)}}, &plate);
}

INSTANTIATE_TEST_SUITE_P(Seeds, AutoChoice, testing::Values(1, 2, 3));

}  // namespace
}  // namespace floatstage
