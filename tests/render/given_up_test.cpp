#include <thread>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

// A picture that somebody gives up while it is drawn.
class APictureThatIsGivenUp : public Rendering, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    ASSERT_THAT(scene_.set(stage_.rig, stage_.scene, {}), IsOk());
    renderer_ = make(GetParam());
    ASSERT_NE(renderer_, nullptr);
  }
  Result<RenderedView> draw(const View& view, RendererOptions options = {}) {
    return renderer_->render(scene_, view, options);
  }

  const Stage stage_ = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  Scene scene_;
  std::unique_ptr<ViewRenderer> renderer_;
};
INSTANTIATE_TEST_SUITE_P(All, APictureThatIsGivenUp,
                         testing::Values("nearest", "linear", "band-limited", "filtered", "floating"),
                         [](const auto& param) {
                           std::string name = param.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(APictureThatIsGivenUp, EndsWhereverItIsAndLeavesNoTraceInTheNext) {
  const View before = view_at(3), view = view_at(-8);
  const Image expected = rendered(stage_, view, GetParam());
  int asked = 0;
  RendererOptions options;
  options.threads = 1;  // it asks as often each time
  options.given_up = [&] { return ++asked, false; };
  ASSERT_THAT(draw(view, options), IsOk());
  const int asks = asked;
  ASSERT_GE(asks, 5) << "between stages and between bands of rows";
  for (int last = 1; last <= asks; last += std::max(1, asks / 9)) {
    ASSERT_THAT(draw(before), IsOk());
    asked = 0;
    options.given_up = [&] { return ++asked == last; };
    const Result<RenderedView> ended = draw(view, options);
    ASSERT_FALSE(ended) << "given up at question " << last << " of " << asks;
    EXPECT_EQ(ended.error().code, ErrorCode::Cancelled);
    EXPECT_EQ(asked, last) << "the answer stays";
    const Result<RenderedView> next = draw(view);
    ASSERT_THAT(next, IsOk());
    EXPECT_EQ(download(*next), expected) << "after one that was given up at question " << last;
  }
}

TEST_P(APictureThatIsGivenUp, IsAskedForOnTheThreadThatDrawsAlone) {
  const std::thread::id here = std::this_thread::get_id();
  bool elsewhere = false;
  int asked = 0;
  RendererOptions options;
  options.threads = 3;
  options.given_up = [&] {
    elsewhere = elsewhere || std::this_thread::get_id() != here;
    return ++asked, false;
  };
  ASSERT_THAT(draw(view_at(5), options), IsOk());
  EXPECT_FALSE(elsewhere);
  EXPECT_GT(asked, 0);
}

}  // namespace
}  // namespace floatstage::render
