#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "matting/spectral/spectral_matting.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

using testing::ElementsAre;

// `count` upright stripes of opacity 1, softened by `soft`.
MattingComponents stripes(int count, double soft = 0) {
  MattingComponents c{count * 4, 5, Eigen::MatrixXf::Zero(count * 20, count)};
  for (int p = 0; p < count * 20; ++p) {
    const int own = p % (count * 4) / 4;
    c.alpha(p, own) = static_cast<float>(1 - soft);
    c.alpha(p, (own + 1) % count) = static_cast<float>(soft);
  }
  return c;
}

Image picture_of(const MattingComponents& c, const std::vector<bool>& chosen) { return matte_of(c, chosen); }

double energy_of(const MattingComponents& c, const std::vector<SelectionTerm>& terms, unsigned subset) {
  double sum = 0;
  for (Eigen::Index p = 0; p < c.alpha.rows(); ++p) {
    double matte = 0;
    for (int k = 0; k < c.count(); ++k)
      if (subset >> k & 1) matte += c.alpha(p, k);
    for (const auto& t : terms) {
      const double w = t.opinion.weight.empty() ? 1 : t.opinion.weight.pixels[p] / 255.0;
      const double d = t.opinion.opacity.pixels[p] / 255.0 - matte;
      sum += t.strength * w * d * d;
    }
  }
  return sum / static_cast<double>(c.alpha.rows());
}

TEST(SelectComponents, FindsTheSubsetThatMadeTheMatte) {
  for (int count : {5, 16, 20}) {  // the last by the greedy way
    const MattingComponents c = stripes(count, 0.1);
    std::vector<bool> chosen(count);
    for (int k = 0; k < count; ++k) chosen[k] = k % 3 == 1;
    const auto found = select_components(c, {{{picture_of(c, chosen), {}}, 1}});
    ASSERT_THAT(found, IsOk());
    EXPECT_EQ(found->chosen, chosen) << count;
    EXPECT_LT(found->energy, 1e-5);
  }
}

TEST(SelectComponents, IsAsGoodAsTheBestOfAllSubsets) {
  Random random(5);
  MattingComponents c{16, 10, Eigen::MatrixXf(160, 7)};
  for (Eigen::Index i = 0; i < c.alpha.size(); ++i)
    c.alpha(i) = static_cast<float>(random.uniform(-0.1, 0.6));
  std::vector<SelectionTerm> terms(2, {{Image(16, 10, 1), Image(16, 10, 1)}, 1});
  for (auto& t : terms) {
    for (auto& byte : t.opinion.opacity.pixels) byte = static_cast<std::uint8_t>(random.next());
    for (auto& byte : t.opinion.weight.pixels) byte = static_cast<std::uint8_t>(random.next());
  }
  terms[1].strength = 0.4;
  double least = std::numeric_limits<double>::infinity();
  unsigned best = 0;
  for (unsigned subset = 0; subset < 128; ++subset)
    if (const double e = energy_of(c, terms, subset); e < least) {
      least = e;
      best = subset;
    }
  const auto found = select_components(c, terms);
  ASSERT_THAT(found, IsOk());
  EXPECT_NEAR(found->energy, least, 1e-9);
  for (int k = 0; k < 7; ++k) EXPECT_EQ(found->chosen[k], (best >> k & 1) != 0) << k;
}

TEST(SelectComponents, TakesAClickForItsComponentOnly) {
  const MattingComponents c = stripes(4);
  MatteConstraint click{Image(16, 5, 1), Image(16, 5, 1)};
  *click.opacity.at(9, 2) = *click.weight.at(9, 2) = 255;
  const auto found = select_components(c, {{click, 1}});
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(found->chosen, ElementsAre(false, false, true, false));
}

TEST(SelectComponents, LetsTheStrongerOpinionWin) {
  const MattingComponents c = stripes(3);
  const MatteConstraint first{picture_of(c, {true, false, false}), {}},
      second{picture_of(c, {false, true, false}), {}};
  const auto a = select_components(c, {{first, 1}, {second, 0.3}}),
             b = select_components(c, {{first, 0.3}, {second, 1}});
  ASSERT_THAT(a, IsOk());
  ASSERT_THAT(b, IsOk());
  EXPECT_THAT(a->chosen, ElementsAre(true, false, false));
  EXPECT_THAT(b->chosen, ElementsAre(false, true, false));
  EXPECT_GT(a->energy, 0.1) << "they disagree, and the energy says so";
}

TEST(SelectComponents, PersistsInTheChoiceOfTheFrameBefore) {
  const MattingComponents c = stripes(3);
  MatteConstraint vague{Image(12, 5, 1, 128), {}};  // slightly for subject
  const auto alone = select_components(c, {{vague, 1}});
  const auto persistent = select_components(c, {{vague, 1}}, {false, true, false}, 0.1);
  ASSERT_THAT(persistent, IsOk());
  EXPECT_THAT(alone->chosen, ElementsAre(true, true, true));
  EXPECT_THAT(persistent->chosen, ElementsAre(false, true, false));
}

TEST(SelectComponents, TakesNothingWhenNothingIsWanted) {
  const MattingComponents c = stripes(4);
  const auto none = select_components(c, {{{Image(16, 5, 1, 0), {}}, 1}});
  const auto all = select_components(c, {{{Image(16, 5, 1, 255), {}}, 1}});
  ASSERT_THAT(none, IsOk());
  ASSERT_THAT(all, IsOk());
  EXPECT_THAT(none->chosen, ElementsAre(false, false, false, false));
  EXPECT_THAT(all->chosen, ElementsAre(true, true, true, true));
}

TEST(SelectComponents, SaysWhatDoesNotFit) {
  const MattingComponents c = stripes(4);
  const MatteConstraint good{Image(16, 5, 1, 9), {}};
  EXPECT_THAT(select_components(c, {}), FailsWith(ErrorCode::InvalidArgument, "nothing says"));
  EXPECT_THAT(select_components(c, {{{Image(16, 5, 1), Image(16, 5, 1, 0)}, 1}}),
              FailsWith(ErrorCode::InvalidArgument, "nothing says"));
  EXPECT_THAT(select_components(c, {{{Image(15, 5, 1), {}}, 1}}),
              FailsWith(ErrorCode::InvalidArgument, "15x5"));
  EXPECT_THAT(select_components(c, {{{Image(16, 5, 1), Image(16, 4, 1)}, 1}}),
              FailsWith(ErrorCode::InvalidArgument, "weight"));
  EXPECT_THAT(select_components(c, {{good, -1}}), FailsWith(ErrorCode::InvalidArgument, "strength"));
  EXPECT_THAT(select_components(c, {{good, 1}}, {true}, 1),
              FailsWith(ErrorCode::InvalidArgument, "previous"));
}

TEST(GuessSelection, FindsADiscBeforeFields) {
  const DiscPicture scene = disc_picture(90, 60);
  auto solver = EigenSolver::create(90, 60);
  ASSERT_THAT(solver, IsOk());
  const auto pairs = solver->solve(scene.rgb);
  ASSERT_THAT(pairs, IsOk());
  const auto components = matting_components(*pairs);
  const auto laplacian = matting_laplacian(scene.rgb);
  ASSERT_THAT(components, IsOk());
  const auto guess = guess_selection(*components, *laplacian);
  ASSERT_THAT(guess, IsOk());
  EXPECT_LT(mean_square(matte_of(*components, guess->chosen), scene.alpha), 0.01);
  EXPECT_THAT(guess_selection(*components, Eigen::SparseMatrix<double>(9, 9)),
              FailsWith(ErrorCode::InvalidArgument, "9 pixels"));
}

}  // namespace
}  // namespace floatstage::matting
