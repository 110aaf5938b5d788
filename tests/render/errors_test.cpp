#include <limits>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

using testing::AllOf;

class RenderErrors : public Rendering {
 protected:
  RenderErrors() : stage_(photographed(arc(3, 20), ball(0.25F, 8), ball(0.25F, 8))) {}

  Result<void> upload(const std::vector<bool>& usable = {}) {
    return textures_.upload(stage_.rig, stage_.scene, usable);
  }
  Result<render::RenderedView> render(const View& view, const RendererOptions& options = {}) {
    auto renderer = render::make_renderer("linear");
    EXPECT_THAT(renderer, IsOk());
    return (*renderer)->render(textures_, view, options);
  }

  Stage stage_;
  SceneTextures textures_;
};

TEST_F(RenderErrors, NamesTheCameraWhosePictureHasTheWrongSize) {
  stage_.scene.images.frames[1] = make_frame({}, Image(80, 60, 3));
  EXPECT_THAT(upload(), FailsWith(ErrorCode::BadData, "camera 'cam1'"));
}

TEST_F(RenderErrors, NamesTheCameraWhoseMatteHasTheWrongSize) {
  stage_.scene.mattes[2] = make_matte({}, Image(80, 60, 1));
  EXPECT_THAT(upload(), FailsWith(ErrorCode::BadData, "camera 'cam2'"));
}

TEST_F(RenderErrors, ATruncatedPictureIsBadData) {
  stage_.scene.images.frames[0].layout.size_bytes -= 100;
  EXPECT_THAT(upload(), FailsWith(ErrorCode::BadData, "camera 'cam0'"));
}

TEST_F(RenderErrors, CountsMustAgree) {
  stage_.scene.images.frames.pop_back();
  EXPECT_THAT(upload(), FailsWith(ErrorCode::InvalidArgument, "3 cameras"));
}

TEST_F(RenderErrors, AtLeastOneCameraMustBeLeft) {
  EXPECT_THAT(upload({false, false, false}), FailsWith(ErrorCode::InvalidArgument, "no camera"));
}

TEST_F(RenderErrors, NotANumberInTheRigIsRefused) {
  stage_.rig.cameras[1].model.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(upload());
}

TEST_F(RenderErrors, NotANumberInTheMeshIsRefused) {
  stage_.scene.mesh.positions[5].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(upload(), FailsWith(ErrorCode::BadData, "vertex 5"));
}

TEST_F(RenderErrors, ATriangleMayNotReferToAVertexThatIsNotThere) {
  stage_.scene.mesh.triangles[0] = 1000000;
  EXPECT_THAT(upload(), FailsWith(ErrorCode::BadData, "1000000"));
}

TEST_F(RenderErrors, AFailedUploadLeavesTheOldScene) {
  ASSERT_THAT(upload(), IsOk());
  const auto before = render(view_at(3));
  ASSERT_THAT(before, IsOk());
  const Image picture = render::download(*before);
  stage_.scene.mattes[2] = make_matte({}, Image(80, 60, 1));
  ASSERT_FALSE(upload());
  const auto after = render(view_at(3));
  ASSERT_THAT(after, IsOk());
  EXPECT_EQ(download(*after), picture);
}

TEST_F(RenderErrors, AViewWithALensIsRefused) {
  ASSERT_THAT(upload(), IsOk());
  View view = view_at(0);
  view.model.lens = BrownConrady{-0.1, 0, 0, 0, 0};
  EXPECT_THAT(render(view), FailsWith(ErrorCode::InvalidArgument, "lens"));
}

TEST_F(RenderErrors, AViewWithoutSizePlanesOrPlaceIsRefused) {
  ASSERT_THAT(upload(), IsOk());
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

TEST_F(RenderErrors, RenderingBeforeUploadingIsRefused) {
  EXPECT_THAT(render(view_at(0)), FailsWith(ErrorCode::InvalidArgument, "upload"));
}

TEST_F(RenderErrors, OptionsOutOfRangeAreRefused) {
  ASSERT_THAT(upload(), IsOk());
  render::RendererOptions options;
  options.cameras = 0;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "photographs"));
  options = {};
  options.soft_radius = -1;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "radius"));
  options = {};
  options.background[1] = 2;
  EXPECT_THAT(render(view_at(0), options), FailsWith(ErrorCode::InvalidArgument, "background"));
}

TEST_F(RenderErrors, UnknownRenderersAreListedAgainstKnownOnes) {
  EXPECT_THAT(render::make_renderer("magic"), FailsWith(ErrorCode::InvalidArgument, "linear"));
}

}  // namespace
}  // namespace floatstage::render
