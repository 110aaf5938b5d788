// Fields that stay from one picture to the next: they are the surface's, whoever looks at it.
#include <limits>

#include "render/pairwise_flows.h"
#include "render/remembered_fields.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

RendererOptions remembering(double share = 0.9) {
  RendererOptions options;
  options.field_memory = share;
  return options;
}

int largest_difference(const Image& a, const Image& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    most = std::max(most, std::abs(a.pixels[i] - b.pixels[i]));
  return most;
}

// Turned about its own axis by `roll` degrees, too.
View rolled(double degrees, double elevation, double roll, double distance = 1) {
  View view = view_at(degrees, elevation);
  view.view_from_world = on_orbit(degrees, elevation, distance);
  view.view_from_world =
      Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(roll * M_PI / 180, Eigen::Vector3d::UnitZ())), {0, 0, 0}} *
      view.view_from_world;
  return view;
}

class FieldMemories : public OnEachBackEnd {
 protected:
  void SetUp() override {
    OnEachBackEnd::SetUp();
    set();
    renderer_ = make("floating");
    ASSERT_NE(renderer_, nullptr);
  }
  void set() { ASSERT_THAT(scene_.set(stage_.rig, stage_.scene), IsOk()); }
  Image draw(const View& view, const RendererOptions& options) {
    const Result<RenderedView> picture = renderer_->render(scene_, view, options);
    EXPECT_THAT(picture, IsOk());
    return picture ? download(*picture) : Image();
  }

  const Stage stage_ = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  Scene scene_;
  std::unique_ptr<ViewRenderer> renderer_;
};
FLOATSTAGE_ON_EACH_BACK_END(FieldMemories);

TEST_P(FieldMemories, BeginWithAPictureThatHasNoneBeforeIt) {
  EXPECT_EQ(draw(view_at(4), remembering()), rendered(stage_, view_at(4), "floating"));
}

TEST_P(FieldMemories, AddNothingWhereTheViewRests) {
  const Image first = draw(view_at(4), remembering());
  for (int i = 0; i < 3; ++i) EXPECT_LE(largest_difference(draw(view_at(4), remembering()), first), 2) << i;
}

// What one view has found is what another would find, in its own pixels: turned and nearer as that looks.
TEST_P(FieldMemories, LeadAnotherViewToWhatThePicturesShow) {
  struct Step {
    const char* what;
    View from, to;
  };
  for (const Step& step :
       {Step{"beside", view_at(4), view_at(6)}, Step{"above", view_at(4), view_at(4, 13)},
        Step{"turned", view_at(4), rolled(4, 10, 50)}, Step{"nearer", view_at(4), rolled(4, 10, 0, 0.8)},
        Step{"all at once", rolled(5, 10, -20), rolled(3, 12, 15, 0.9)}}) {
    const Photograph truth =
        photograph(ball(0.25F, 48), step.to.model, step.to.view_from_world, 3, random_checker(0.04F, 5));
    const auto score = [&](const Image& picture) {
      return psnr(picture, truth.rgb, [&](int x, int y) {
        return *truth.alpha.at(x, y) == 255 && well_inside(picture, x, y, 8);
      });
    };
    RendererOptions blind = remembering(0.95);
    blind.flow.backend = "none";
    renderer_->reset_history();
    const double without = score(draw(step.to, blind));
    renderer_->reset_history();
    const double with = score(draw(step.to, remembering()));
    renderer_->reset_history();
    draw(step.from, remembering());
    const double led = score(draw(step.to, blind));
    EXPECT_GT(with, without + 3) << step.what << ": nothing is tested";
    EXPECT_GT(led, without + 0.7 * (with - without)) << step.what << ": " << without << ", " << with;
  }
}

TEST_P(FieldMemories, AreOfOneScene) {
  const Image fresh = rendered(stage_, view_at(6), "floating");
  draw(view_at(4), remembering());
  EXPECT_NE(draw(view_at(6), remembering()), fresh) << "nothing is tested";
  renderer_->reset_history();
  EXPECT_EQ(draw(view_at(6), remembering()), fresh) << "forgotten on demand";
  draw(view_at(4), remembering());
  set();
  EXPECT_EQ(draw(view_at(6), remembering()), fresh) << "a scene that is set anew may be another";
  draw(view_at(4), remembering());
  scene_ = Scene();
  set();
  EXPECT_EQ(draw(view_at(6), remembering()), fresh) << "another scene at the same place";
}

TEST_P(FieldMemories, AreOfOneSizeOfFields) {
  RendererOptions half = remembering();
  half.flow.shrink = 2;
  draw(view_at(4), half);
  EXPECT_EQ(draw(view_at(6), remembering()), rendered(stage_, view_at(6), "floating"));
  const View small = view_at(6, 10, small_camera(96, 72));
  draw(view_at(4), half);
  draw(small, half);  // another size of pictures is another view
  EXPECT_EQ(draw(small, remembering(0)).width, 96);
}

TEST_P(FieldMemories, NeedNoneOfTheCamerasOfBefore) {
  RendererOptions two = remembering();
  two.cameras = 2;
  draw(view_at(-38), two);  // the first two
  const Image picture = draw(view_at(38), two);
  EXPECT_EQ(picture, rendered(stage_, view_at(38), "floating", two));
}

TEST_P(FieldMemories, DependOnTheSequenceAlone) {
  const auto walk = [&](int threads) {
    renderer_->reset_history();
    RendererOptions options = remembering();
    options.threads = threads;
    Image last;
    for (const double degrees : {-6., -3., 0., 3.}) last = draw(view_at(degrees), options);
    return last;
  };
  const Image one = walk(1);
  EXPECT_EQ(walk(1), one);
  EXPECT_EQ(walk(3), one) << "not on the threads";
}

TEST_P(FieldMemories, AreAShareOfThePicture) {
  for (const double share : {-0.1, 1., std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(renderer_->render(scene_, view_at(4), remembering(share)),
                FailsWith(ErrorCode::InvalidArgument, "field memory"));
}

// Two cameras 20 degrees apart, and the share that a view leaves to one so many degrees beside it.
float share_after(double degrees, double share) {
  const Stage stage = photographed(arc(2, 20), ball(0.25F, 24), ball(0.25F, 24));
  Scene scene;
  EXPECT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const FieldsOfPicture before{on_orbit(0).center(), {0, 1}, {true, true}},
      now{on_orbit(degrees).center(), {0, 1}, {true, true}};
  const std::vector<RememberedField> common = remembered_fields(scene.impl(), now, before, share);
  EXPECT_TRUE(common.empty() || common.size() == 2);
  return common.empty() ? 0 : common.front().share;
}

TEST(RememberedFields, ReachHalfWayFromCameraToCameraAtMost) {
  EXPECT_EQ(share_after(0, 0.75), 0.75F);
  EXPECT_EQ(share_after(1, 0.75), 0.75F);
  EXPECT_NEAR(share_after(5, 0.75), 0.5, 0.02) << "half of the reach";
  EXPECT_NEAR(share_after(5, 0.4), 0.4, 1e-6) << "what is left of less than that";
  EXPECT_EQ(share_after(11, 0.75), 0);
}

TEST(RememberedFields, AreThoseOfTheSamePhotographsInWhateverOrder) {
  const Stage stage = photographed(arc(4, 20), ball(0.25F, 24), ball(0.25F, 24));
  Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const Eigen::Vector3d eye = on_orbit(0).center();
  const FieldsOfPicture before{eye, {2, 0, 3}, {true, true, true}};
  FieldsOfPicture now{eye, {1, 3, 2}, {true, true, true}};
  std::vector<RememberedField> common = remembered_fields(scene.impl(), now, before, 0.5);
  ASSERT_EQ(common.size(), 2U) << "between cameras 2 and 3";
  EXPECT_EQ(common[0].now, flow_index_of({1, 2}, 3));  // from 3 to 2
  EXPECT_EQ(common[0].before, flow_index_of({2, 0}, 3));
  EXPECT_EQ(common[1].now, flow_index_of({2, 1}, 3));
  EXPECT_EQ(common[1].before, flow_index_of({0, 2}, 3));
  now.wanted = {true, true, false};
  common = remembered_fields(scene.impl(), now, before, 0.5);
  ASSERT_EQ(common.size(), 1U) << "nobody asks for what leads to camera 2";
  EXPECT_EQ(common[0].now, flow_index_of({2, 1}, 3));
  now.cameras = {1};
  now.wanted = {true};
  EXPECT_TRUE(remembered_fields(scene.impl(), now, before, 0.5).empty());
}

class FieldMemoriesOfBoth : public Rendering {};

TEST_F(FieldMemoriesOfBoth, LeadTheCpuAndOpenGlToTheSamePictures) {
  open(BackEnd::Gl);
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  for (const FlowPlace place : {FlowPlace::Cpu, FlowPlace::Gpu}) {
    RendererOptions options = remembering(0.75);
    options.flow.place = place;
    std::vector<Image> pictures;
    for (const BackEnd back_end : {BackEnd::Cpu, BackEnd::Gl}) {
      Scene scene;
      ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
      Result<std::unique_ptr<ViewRenderer>> renderer = make_renderer("floating", back_end);
      ASSERT_THAT(renderer, IsOk());
      for (const double degrees : {-6., -2., 2., 6.}) {
        const Result<RenderedView> picture = (*renderer)->render(scene, view_at(degrees), options);
        ASSERT_THAT(picture, IsOk());
        if (degrees == 6) pictures.push_back(download(*picture));
      }
    }
    EXPECT_GT(psnr(pictures[0], pictures[1],
                   [&](int x, int y) { return pictures[0].at(x, y)[3] > 0 && pictures[1].at(x, y)[3] > 0; }),
              place == FlowPlace::Cpu ? 50 : 42);
  }
}

TEST(FieldMemory, KnowsNothingOfAPictureThatWasGivenUp) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = *make_renderer("floating", BackEnd::Cpu);
  RendererOptions options = remembering();
  options.threads = 1;
  ASSERT_THAT(renderer->render(scene, view_at(4), options), IsOk());
  const Image expected = download(*renderer->render(scene, view_at(6), options));
  int asks = 0;
  options.given_up = [&] { return ++asks, false; };
  ASSERT_THAT(renderer->render(scene, view_at(20), options), IsOk());
  for (int last = 1; last <= asks; last += std::max(1, asks / 9)) {
    options.given_up = {};
    renderer->reset_history();
    ASSERT_THAT(renderer->render(scene, view_at(4), options), IsOk());
    int asked = 0;
    options.given_up = [&] { return ++asked == last; };
    ASSERT_FALSE(renderer->render(scene, view_at(20), options));
    options.given_up = {};
    EXPECT_EQ(download(*renderer->render(scene, view_at(6), options)), expected) << last << " of " << asks;
  }
}

}  // namespace
}  // namespace floatstage::render
