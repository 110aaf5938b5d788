// floating-static: Eq. 11.4. What all renderers must is in invariants_test.cpp and back_ends_test.cpp.
#include <cstdlib>

#include "render/camera_fields.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

// A flattened ball with a wrong proxy, so that there is something to move.
Mesh true_ball() { return ball(0.25F, 48, 0.6F); }
Stage troubled(const Rig& rig = arc(5, 25)) { return photographed(rig, true_ball(), ball(0.265F, 16, 0.6F)); }
Image truth_at(const View& view) {
  return photograph(true_ball(), view.model, view.view_from_world, 3, random_checker(0.04F, 5)).rgb;
}

const std::vector<CameraPair> kSomePairs = {{1, 2}, {2, 1}, {2, 3}};

class FloatingStatic : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(FloatingStatic);

TEST_P(FloatingStatic, ComesNearTheTruthWhereLinearGhosts) {
  const Stage stage = troubled();
  const View view = view_at(5);
  const Image truth = truth_at(view);
  auto score = [&](const char* method, Positions positions) {
    RendererOptions options;
    options.positions = positions;
    const Image picture = rendered(stage, view, method, options);
    return psnr(picture, truth, [&](int x, int y) { return well_inside(picture, x, y, 3); });
  };
  const double linear = score("linear", Positions::Parallax),
               still = score("floating-static", Positions::Parallax),
               mean = score("floating-static", Positions::Mean),
               moving = score("floating", Positions::Parallax);
  EXPECT_GT(still, linear + 2);
  EXPECT_GT(still, moving - 1);
  EXPECT_GT(mean, linear + 1);
  RecordProperty("psnr",
                 text("linear ", linear, ", static ", still, " (mean ", mean, "), floating ", moving));
}

TEST_P(FloatingStatic, DrawsTheSameBytesOnAnyNumberOfThreads) {
  const Stage stage = troubled();
  RendererOptions one, three;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(rendered(stage, view_at(5), "floating-static", one),
            rendered(stage, view_at(5), "floating-static", three));
}

TEST_P(FloatingStatic, DrawsTheSameBytesWhateverItDrewBefore) {
  const Stage stage = troubled();
  const Image expected = rendered(stage, view_at(5), "floating-static");
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const std::unique_ptr<ViewRenderer> renderer = make("floating-static");
  for (const double degrees : {-20.0, -11.0, 15.0, 5.0}) {
    const Result<RenderedView> picture = renderer->render(scene, view_at(degrees), {});
    ASSERT_THAT(picture, IsOk());
    if (degrees == 5) {
      EXPECT_EQ(download(*picture), expected);
    }
  }
}

TEST_P(FloatingStatic, DrawsTheSameBytesWithFieldsThatItIsGiven) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const Result<FieldSet> made =
      estimate_fields(scene, field_pairs(stage.rig, stage.scene.mesh, 4), RendererOptions());
  ASSERT_THAT(made, IsOk());
  EXPECT_EQ(made->fields.size(), 20U) << "of five cameras each to the four others";
  scene.set_fields(std::make_shared<FieldSet>(*made));
  const std::unique_ptr<ViewRenderer> renderer = make("floating-static");
  const Result<RenderedView> picture = renderer->render(scene, view_at(5), {});
  ASSERT_THAT(picture, IsOk());
  EXPECT_EQ(download(*picture), rendered(stage, view_at(5), "floating-static"));
}

TEST_P(FloatingStatic, DrawsWithTheFieldsThatItIsGivenUntilTheSceneChanges) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  Result<FieldSet> made =
      estimate_fields(scene, field_pairs(stage.rig, stage.scene.mesh, 4), RendererOptions());
  ASSERT_THAT(made, IsOk());
  for (auto& [pair, field] : made->fields) {
    CameraField away = *field;
    for (std::int16_t& step : away.uv) step = 5 * 64;
    field = std::make_shared<const CameraField>(away);
  }
  scene.set_fields(std::make_shared<FieldSet>(*made));
  const std::unique_ptr<ViewRenderer> renderer = make("floating-static");
  auto drawn = [&] {
    const Result<RenderedView> picture = renderer->render(scene, view_at(5), {});
    EXPECT_THAT(picture, IsOk());
    return download(*picture);
  };
  const Image expected = rendered(stage, view_at(5), "floating-static");
  EXPECT_NE(drawn(), expected);
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  EXPECT_EQ(drawn(), expected);
}

TEST_P(FloatingStatic, IsLinearWhereNothingMoves) {
  const Stage stage = troubled();
  RendererOptions options;
  options.flow.backend = "none";
  const Image still = rendered(stage, view_at(5), "floating-static", options),
              linear = rendered(stage, view_at(5), "linear", options);
  EXPECT_GT(psnr(still, linear, [&](int x, int y) { return well_inside(linear, x, y, 4); }), 50);
}

TEST_P(FloatingStatic, DrawsOneTwoAndEightPhotographs) {
  const Stage stage = troubled(arc(9, 12));
  for (const int cameras : {1, 2, 8}) {
    RendererOptions options;
    options.cameras = cameras;
    options.flow.shrink = 2;
    const Image picture = rendered(stage, view_at(5), "floating-static", options);
    const Image truth = truth_at(view_at(5));
    EXPECT_GT(psnr(picture, truth, [&](int x, int y) { return well_inside(picture, x, y, 3); }), 15)
        << cameras;
  }
}

TEST(FieldsOnBothBackEnds, PlaceTheSame) {
  const std::unique_ptr<GlContext> context = std::move(*GlContext::headless());
  for (const Lens& lens : {Lens(), Lens(BrownConrady{-0.25, 0.08, 0.002, -0.001, 0.01}),
                           Lens(KannalaBrandt{0.05, -0.02, 0.01, 0})}) {
    CameraModel model = small_camera();
    model.lens = lens;
    const Stage stage = troubled(arc(5, 12, model));
    render::Scene scene;
    ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
    for (const RenderOutput output : {RenderOutput::Color, RenderOutput::Flow}) {
      RendererOptions options;
      options.output = output;
      options.soft_outlines = false;
      Image pictures[2];
      for (int i = 0; i < 2; ++i) {
        const auto renderer =
            std::move(*make_renderer("floating-static", i == 0 ? render::BackEnd::Cpu : render::BackEnd::Gl));
        const Result<RenderedView> picture = renderer->render(scene, view_at(5), options);
        ASSERT_THAT(picture, IsOk());
        pictures[i] = download(*picture);
      }
      const double alike = psnr(pictures[0], pictures[1], [&](int x, int y) {
        return pictures[0].at(x, y)[3] != 0 && pictures[1].at(x, y)[3] != 0;
      });
      EXPECT_GT(alike, 45) << "lens " << lens.index() << ", output " << static_cast<int>(output);
    }
  }
}

TEST(Fields, BetweenEqualPhotographsAreZero) {
  Rig rig = arc(3, 20);
  rig.cameras[2] = rig.cameras[1];  // the same camera twice
  rig.cameras[2].serial = "again";
  const Stage stage = troubled(rig);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const Result<FieldSet> made = estimate_fields(scene, std::vector<CameraPair>{{1, 2}, {1, 0}}, {});
  ASSERT_THAT(made, IsOk());
  auto largest = [&](CameraPair pair) {
    int most = 0;
    for (const std::int16_t step : made->fields.at(pair)->uv) most = std::max(most, std::abs(int{step}));
    return most;
  };
  EXPECT_EQ(largest({1, 2}), 0);
  EXPECT_GT(largest({1, 0}), 64) << "nothing moves at all: nothing is tested";
}

TEST(Fields, OfAPairDependOnThatPairAlone) {
  const Stage stage = troubled();
  render::Scene all, two;
  ASSERT_THAT(all.set(stage.rig, stage.scene), IsOk());
  ASSERT_THAT(two.set(stage.rig, stage.scene, {false, true, true, false, false}), IsOk());
  const Result<FieldSet> some = estimate_fields(all, kSomePairs, {}),
                         one = estimate_fields(two, std::vector<CameraPair>{{1, 2}}, {});
  ASSERT_THAT(some, IsOk());
  ASSERT_THAT(one, IsOk());
  EXPECT_EQ(some->fields.at({1, 2})->uv, one->fields.at({1, 2})->uv);
  EXPECT_EQ(field_inputs(all).cameras.at(2), field_inputs(two).cameras.at(2));
  EXPECT_EQ(field_inputs(all).mesh, field_inputs(two).mesh);
}

TEST(Fields, KnowWhatTheyWereMadeFrom) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const FieldInputs before = field_inputs(scene);
  Stage other = stage;
  other.scene.mesh.positions[7].x() += 1e-4F;
  Image changed = *to_rgb(stage.scene.images.frames[1]);
  changed.pixels[5000] ^= 1;
  other.scene.images.frames[1] = make_frame({}, changed);
  other.rig.cameras[3].model.cx += 0.25;
  ASSERT_THAT(scene.set(other.rig, other.scene), IsOk());
  const FieldInputs after = field_inputs(scene);
  EXPECT_NE(after.mesh, before.mesh);
  for (const auto& [camera, hash] : before.cameras)
    EXPECT_EQ(after.cameras.at(camera) == hash, camera != 1 && camera != 3) << "camera " << camera;
}

TEST(Fields, AreRoundedToASixtyFourthOfAPixel) {
  EXPECT_EQ(to_steps({0, 1, -1, 0.007F, 0.009F, -0.02F, 1e6F, -1e6F}),
            (std::vector<std::int16_t>{0, 64, -64, 0, 1, -1, 32767, -32767}));
}

TEST(Fields, GoToTheNearestCameras) {
  const Rig rig = arc(6, 20);  // of 2, cameras 0 and 4 are as near
  const std::vector<CameraPair> pairs =
      field_pairs(rig, ball(0.25F), 2, {true, true, true, false, true, true});
  EXPECT_EQ(pairs, (std::vector<CameraPair>{
                       {0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 1}, {2, 4}, {4, 2}, {4, 5}, {5, 2}, {5, 4}}));
}

TEST(Fields, AreNotMadeOfCamerasWithoutAPicture) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene, {true, true, false, true, true}), IsOk());
  EXPECT_THAT(estimate_fields(scene, kSomePairs, {}), FailsWith(ErrorCode::InvalidArgument, "camera 2"));
}

TEST(Fields, ThatAreGivenUpAreMadeTheNextTime) {
  const Stage stage = troubled();
  const View view = view_at(5);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = std::move(*make_renderer("floating-static", render::BackEnd::Cpu));
  int asked = 0;
  RendererOptions options;
  options.threads = 1;  // one of many is asked too seldom
  options.given_up = [&] { return ++asked > 40; };
  const Result<RenderedView> ended = renderer->render(scene, view, options);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::Cancelled);
  const Result<RenderedView> next = renderer->render(scene, view, {});
  ASSERT_THAT(next, IsOk());
  const auto fresh = std::move(*make_renderer("floating-static", render::BackEnd::Cpu));
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const Image found = download(*next);
  const Result<RenderedView> expected = fresh->render(scene, view, {});
  ASSERT_THAT(expected, IsOk());
  EXPECT_EQ(found, download(*expected));
}

}  // namespace
}  // namespace floatstage::render
