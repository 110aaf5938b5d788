#include "apps/viewer/play/canvas.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include "tests/apps/viewer/hands.h"
#include "tests/render/stage.h"

namespace floatstage::apps {
namespace {

using Kind = InputEvent::Kind;

// The player's picture without a window: its time, hands and interruptions are the test's.
class CanvasOnTheCpu : public testing::Test {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<render::GlContext>> context = render::GlContext::headless();
    ASSERT_THAT(context, IsOk());
    context_ = std::move(*context);
    ImGui::CreateContext();
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    ImGui::GetIO().DisplaySize = {320, 240};
    ImGui::GetIO().IniFilename = nullptr;
    const Eigen::Vector3d corner = Eigen::Vector3d::Constant(0.25);
    canvas_ = std::make_unique<Canvas>(stage_.rig, Eigen::AlignedBox3d(-corner, corner));
    state_.methods = {"linear", "floating"};
    state_.left = state_.right = 1;
    state_.quick = true;
    state_.renderer.back_end = render::BackEnd::Cpu;
    state_.renderer.threads = 1;
    ASSERT_THAT(canvas_->show(std::make_shared<const SceneFrame>(stage_.scene)), IsOk());
    canvas_->give_up_when([this] { return ++asked_ == hand_comes_at_; });
  }
  void TearDown() override {
    canvas_.reset();
    if (ImGui::GetCurrentContext() != nullptr) ImGui::DestroyContext();
  }

  /// A frame of the window, so many seconds after the last; a hand waits from this question on (0: none).
  void frame(double seconds, int hand_comes_at = 0, std::vector<InputEvent> input = {}) {
    asked_ = 0;
    hand_comes_at_ = hand_comes_at;
    ImGui::GetIO().DeltaTime = static_cast<float>(seconds);
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({320, 240});
    ImGui::Begin("stage");
    EXPECT_THAT(canvas_->draw(state_, input), IsOk());
    ImGui::End();
    ImGui::EndFrame();
  }
  long full() const { return canvas_->times().at_rest.count(); }
  long moving() const { return canvas_->times().moving.count(); }

  static PlayerState player() {
    pipeline::PathKey home;
    home.eye = {1.2, 0.1, 0.2}, home.target = {0, 0, 0}, home.up = {0, 0, 1}, home.fov_y = 30;
    return {TimeLine(1, 25), ViewerCamera(home)};
  }

  const std::vector<InputEvent> drag_ = {at(Kind::Press, 100, 100), at(Kind::Move, 130, 100),
                                         at(Kind::Release, 130, 100)};
  std::unique_ptr<render::GlContext> context_;
  const render::Stage stage_ =
      render::photographed(render::arc(4, 20), render::ball(0.25F, 24), render::ball(0.25F, 24));
  PlayerState state_ = player();
  std::unique_ptr<Canvas> canvas_;
  int asked_ = 0, hand_comes_at_ = 0;
};

TEST_F(CanvasOnTheCpu, GivesAFullPictureUpForAHandAndMovesWithItNext) {
  frame(0.02);
  ASSERT_EQ(full(), 1) << "the first picture of all";
  EXPECT_EQ(asked_, 0) << "which nothing may end: there is no other to show";
  frame(0.02, 1, drag_);
  ASSERT_EQ(moving(), 1) << "and no picture that moves is given up";
  EXPECT_FALSE(canvas_->gave_up());
  frame(1, 3);
  EXPECT_TRUE(canvas_->gave_up()) << "at rest again, and a hand waits";
  EXPECT_FALSE(canvas_->has_full_picture());
  EXPECT_EQ(asked_, 3);
  EXPECT_EQ(full(), 1);
  EXPECT_EQ(canvas_->times().given_up, 1);
  frame(0.02, 1, drag_);
  EXPECT_FALSE(canvas_->gave_up());
  EXPECT_EQ(moving(), 2) << "what the hand wanted";
  frame(1);
  EXPECT_EQ(full(), 2) << "and at rest the full one";
  EXPECT_TRUE(canvas_->has_full_picture());
}

TEST_F(CanvasOnTheCpu, AnswersAHandThatMovesNoCameraWithAQuickPicture) {
  frame(0.02);
  state_.renderer.soft_radius += 1;  // a slider that is being dragged
  frame(0.02, 2);
  ASSERT_TRUE(canvas_->gave_up());
  for (int i = 0; i < 3; ++i) {
    state_.renderer.soft_radius += 1;
    frame(0.02, 1);
    EXPECT_FALSE(canvas_->gave_up());
    EXPECT_EQ(moving(), i + 1) << "there is always a picture, whatever hands do";
    EXPECT_EQ(full(), 1);
  }
  frame(1);
  EXPECT_EQ(full(), 2);
}

TEST_F(CanvasOnTheCpu, DrawsOnePictureForTwoSidesOfOneMethod) {
  state_.split = true;
  frame(0.02);
  EXPECT_GT(canvas_->times().left_ms, 0);
  EXPECT_EQ(canvas_->times().right_ms, 0);
  state_.left = 0;
  frame(0.02);
  EXPECT_GT(canvas_->times().right_ms, 0);
}

TEST_F(CanvasOnTheCpu, ShowsAnotherOutputOnEachSideOfOneMethod) {
  state_.split = true;
  state_.right_output = render::RenderOutput::Confidence;
  frame(0.02);
  EXPECT_GT(canvas_->times().left_ms, 0);
  EXPECT_GT(canvas_->times().right_ms, 0) << "two pictures";
  const long before = full();
  state_.right_output = render::RenderOutput::Measured;
  frame(1);
  EXPECT_EQ(full(), before + 1) << "another output is another picture";
  state_.renderer.shown_camera = 1;
  frame(1);
  EXPECT_EQ(full(), before + 2) << "and so is another camera";
}

// As a film does: pipeline/film.cpp samples the same path at the second of each picture.
TEST_F(CanvasOnTheCpu, SeesAPathFromWhereAFilmSeesIt) {
  pipeline::CameraPath path;
  for (int i = 0; i < 3; ++i) {
    pipeline::PathKey key = state_.camera.key();
    key.time = i, key.eye.y() += 0.1 * i * i, key.fov_y += 3 * i;
    path.keys.push_back(key);
  }
  state_.path.set(path);
  state_.follow_path = true;
  for (const double second : {0.0, 0.4, 1.0, 1.7}) {
    state_.path_time = second;
    frame(1);
    ASSERT_TRUE(canvas_->view());
    const View& seen = *canvas_->view();
    const View filmed = pipeline::view_of(
        pipeline::sample(path, second), seen.model.width, seen.model.height,
        Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-0.25), Eigen::Vector3d::Constant(0.25)));
    EXPECT_TRUE(seen.view_from_world.matrix() == filmed.view_from_world.matrix()) << second;
    EXPECT_EQ(seen.model.fy, filmed.model.fy) << second;
  }
}

}  // namespace
}  // namespace floatstage::apps
