#include <limits>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

using testing::AllOf;

class RenderErrors : public OnEachBackEnd {
 protected:
  RenderErrors() : stage_(photographed(arc(3, 20), ball(0.25F, 8), ball(0.25F, 8))) {}

  Result<void> set(const std::vector<bool>& usable = {}) {
    return scene_.set(stage_.rig, stage_.scene, usable);
  }
  Result<RenderedView> render(const View& view, const RendererOptions& options = {}) {
    renderer_ = make("linear");
    return renderer_->render(scene_, view, options);
  }

  Stage stage_;
  render::Scene scene_;
  std::unique_ptr<ViewRenderer> renderer_;
};
FLOATSTAGE_ON_EACH_BACK_END(RenderErrors);

TEST_P(RenderErrors, NamesTheCameraWhosePictureHasTheWrongSize) {
  stage_.scene.images.frames[1] = make_frame({}, Image(80, 60, 3));
  EXPECT_THAT(set(), FailsWith(ErrorCode::BadData, "camera 'cam1'"));
}

TEST_P(RenderErrors, NamesTheCameraWhoseMatteHasTheWrongSize) {
  stage_.scene.mattes[2] = make_matte({}, Image(80, 60, 1));
  EXPECT_THAT(set(), FailsWith(ErrorCode::BadData, "camera 'cam2'"));
}

TEST_P(RenderErrors, ATruncatedPictureIsBadData) {
  stage_.scene.images.frames[0].layout.size_bytes -= 100;
  EXPECT_THAT(set(), FailsWith(ErrorCode::BadData, "camera 'cam0'"));
}

TEST_P(RenderErrors, CountsMustAgree) {
  stage_.scene.images.frames.pop_back();
  EXPECT_THAT(set(), FailsWith(ErrorCode::InvalidArgument, "3 cameras"));
}

TEST_P(RenderErrors, AtLeastOneCameraMustBeLeft) {
  EXPECT_THAT(set({false, false, false}), FailsWith(ErrorCode::InvalidArgument, "no camera"));
}

TEST_P(RenderErrors, NotANumberInTheRigIsRefused) {
  stage_.rig.cameras[1].model.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(set());
}

TEST_P(RenderErrors, NotANumberInTheMeshIsRefused) {
  stage_.scene.mesh.positions[5].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(set(), FailsWith(ErrorCode::BadData, "vertex 5"));
}

TEST_P(RenderErrors, ATriangleMayNotReferToAVertexThatIsNotThere) {
  stage_.scene.mesh.triangles[0] = 1000000;
  EXPECT_THAT(set(), FailsWith(ErrorCode::BadData, "1000000"));
}

TEST_P(RenderErrors, AFailedSetLeavesTheOldScene) {
  ASSERT_THAT(set(), IsOk());
  const auto before = render(view_at(3));
  ASSERT_THAT(before, IsOk());
  const Image picture = download(*before);
  stage_.scene.mattes[2] = make_matte({}, Image(80, 60, 1));
  ASSERT_FALSE(set());
  const auto after = render(view_at(3));
  ASSERT_THAT(after, IsOk());
  EXPECT_EQ(download(*after), picture);
}

TEST_P(RenderErrors, AViewWithALensIsRefused) {
  ASSERT_THAT(set(), IsOk());
  View view = view_at(0);
  view.model.lens = BrownConrady{-0.1, 0, 0, 0, 0};
  EXPECT_THAT(render(view), FailsWith(ErrorCode::InvalidArgument, "lens"));
}

TEST_P(RenderErrors, AViewWithoutSizePlanesOrPlaceIsRefused) {
  ASSERT_THAT(set(), IsOk());
  View view = view_at(0);
  view.model.width = 0;
  EXPECT_THAT(render(view), FailsWith(ErrorCode::InvalidArgument, "size"));
  view = view_at(0);
  view.near_plane = 2;
  view.far_plane = 1;
  EXPECT_THAT(render(view), FailsWith(ErrorCode::InvalidArgument, "near < far"));
  view = view_at(0);
  view.view_from_world.translation.x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(render(view), FailsWith(ErrorCode::InvalidArgument, "finite"));
}

TEST_P(RenderErrors, RenderingBeforeASceneIsSetIsRefused) {
  EXPECT_THAT(render(view_at(0)), FailsWith(ErrorCode::InvalidArgument, "set pictures"));
}

TEST_P(RenderErrors, OptionsOutOfRangeAreRefused) {
  ASSERT_THAT(set(), IsOk());
  RendererOptions options;
  options.cameras = 0;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "photographs"));
  options = {};
  options.soft_radius = -1;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "radius"));
  options = {};
  options.background[1] = 2;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "background"));
}

TEST_P(RenderErrors, UnknownRenderersAreListedAgainstKnownOnes) {
  EXPECT_THAT(make_renderer("magic", GetParam()), FailsWith(ErrorCode::InvalidArgument, "linear"));
}

}  // namespace
}  // namespace floatstage::render
