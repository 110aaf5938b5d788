// A wide photograph with closer ones carried into it, against what a camera of that resolution would have
// seen.

#include "detail/compose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/png.h"
#include "detail/float_picture.h"
#include "detail/graph_json.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

using Eigen::Matrix3d;
using test::photograph;
using test::view_of_world;

constexpr int kWidth = 240, kHeight = 180;

class ComposedPhotographs : public testing::Test {
 protected:
  void SetUp() override {
    save("wide.png", wide_);
    save("close.png", close_);
    graph_ = *build_photo_graph(photos_.path(), {});
    ASSERT_EQ(graph_.photos[0].parent, 1);
  }
  void save(const std::string& name, const Matrix3d& view, std::uint64_t seed = 1) {
    ASSERT_THAT(save_png(photograph(kWidth, kHeight, view, seed), photos_ / name), IsOk());
  }
  const Matrix3d wide_ = view_of_world(0, 0, 4), close_ = view_of_world(330, 190, 1.5, 0.05);
  TempFolder photos_;
  PhotoGraph graph_;
};

double psnr_inside(const Image& a, const Image& b, int x0, int y0, int x1, int y1) {
  Image of_a(x1 - x0, y1 - y0, 3), of_b = of_a;
  for (int y = y0; y < y1; ++y) {
    std::copy_n(a.at(x0, y), 3 * (x1 - x0), of_a.at(0, y - y0));
    std::copy_n(b.at(x0, y), 3 * (x1 - x0), of_b.at(0, y - y0));
  }
  return psnr(of_a, of_b);
}

TEST_F(ComposedPhotographs, ShowWhatACloserCameraWouldHaveSeen) {
  ComposeOptions options;
  options.zoom = 3;
  const Result<Composition> made = compose(graph_, options);
  ASSERT_THAT(made, IsOk());
  ASSERT_EQ(made->picture.width, 3 * kWidth);
  const Image truth = photograph(3 * kWidth, 3 * kHeight, view_of_world(0, 0, 4.0 / 3));
  const LightPicture alone =
      warped(to_light(photograph(kWidth, kHeight, wide_)),
             Eigen::DiagonalMatrix<double, 3>(1 / 3.0, 1 / 3.0, 1), 3 * kWidth, 3 * kHeight);
  // The close photograph's middle, in the picture's pixels.
  const double gain = psnr_inside(made->picture, truth, 300, 190, 430, 280) -
                      psnr_inside(to_image(alone), truth, 300, 190, 430, 280);
  EXPECT_GT(gain, 6) << "dB";
  EXPECT_GT(psnr(made->picture, truth), psnr(to_image(alone), truth));
  EXPECT_EQ(psnr_inside(made->picture, to_image(alone), 0, 0, 200, 100),
            std::numeric_limits<double>::infinity())
      << "nothing changes elsewhere";
  ASSERT_EQ(made->photos.size(), 1u);
  EXPECT_NEAR(made->photos[0].zoom, 4 / 1.5, 0.02);
  EXPECT_GT(made->photos[0].used, 0.5);
}

TEST_F(ComposedPhotographs, GoAsFarAsTheClosestUnlessOneSaysHowFar) {
  const Result<Composition> made = compose(graph_, {});
  ASSERT_THAT(made, IsOk());
  EXPECT_NEAR(made->zoom, 4 / 1.5, 0.02);
  ComposeOptions options;
  options.zoom = 0.5;
  EXPECT_THAT(compose(graph_, options), FailsWith(ErrorCode::InvalidArgument, "--zoom 0.5: 1 to 27"));
  options.zoom = 100;
  EXPECT_THAT(compose(graph_, options), FailsWith(ErrorCode::InvalidArgument, "32 million pixels"));
}

TEST_F(ComposedPhotographs, AreTheSameWhateverTheThreads) {
  ComposeOptions one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(compose(graph_, one)->picture, compose(graph_, two)->picture);
}

TEST_F(ComposedPhotographs, CanBeWatchedStepByStep) {
  const TempFolder folder;
  ComposeOptions options;
  options.steps = folder / "steps";
  ASSERT_THAT(compose(graph_, options), IsOk());
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(options.steps))
    names.push_back(file.path().filename());
  EXPECT_THAT(names, testing::UnorderedElementsAre(
                         "close.png-1-parent.png", "close.png-2-child.png", "close.png-3-tones.png",
                         "close.png-4-same.png", "close.png-5-seams.png", "close.png-6-edges.png",
                         "close.png-6-moves.png", "close.png-7-adjusted.png", "close.png-8-mask.png"));
}

TEST_F(ComposedPhotographs, AreRefusedWhenTheyAreNotThoseThatWereRelated) {
  save("close.png", close_, 5);
  EXPECT_THAT(compose(graph_, {}),
              FailsWith(ErrorCode::BadData, "close.png is not the photograph that was related"));
  std::filesystem::remove(photos_ / "close.png");
  EXPECT_THAT(compose(graph_, {}), FailsWith(ErrorCode::NotFound, "close.png"));
}

TEST_F(ComposedPhotographs, LeaveNothingBehindWhenInterrupted) {
  ComposeOptions options;
  options.watch.cancelled = [] { return true; };
  EXPECT_THAT(compose(graph_, options), FailsWith(ErrorCode::Cancelled, "nothing was written"));
}

TEST_F(ComposedPhotographs, AreRefusedWhereTheRootAloneIsTooLarge) {
  graph_.photos[1].photo.width = graph_.photos[1].photo.height = 10'000;
  EXPECT_THAT(compose(graph_, {}), FailsWith(ErrorCode::InvalidArgument, "wide.png has 100 million pixels"));
}

TEST_F(ComposedPhotographs, TooSmallToShowAreNamedAndLeftOut) {
  for (GraphPhoto& photo : graph_.photos)
    if (photo.parent >= 0) {
      photo.zoom *= 20;
      photo.parent_from_child = photo.parent_from_child * Eigen::DiagonalMatrix<double, 3>(0.05, 0.05, 1);
    }
  ComposeOptions options;
  options.zoom = 1;
  const Result<Composition> made = compose(graph_, options);
  ASSERT_THAT(made, IsOk());
  EXPECT_THAT(made->photos[0].why_not, testing::HasSubstr("ask for more --zoom"));
}

}  // namespace
}  // namespace floatstage::detail
