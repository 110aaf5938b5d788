#include "pipeline/evaluate/evaluate.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "core/mesh_io.h"
#include "pipeline/evaluate/temporal.h"
#include "pipeline/light_field.h"
#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "tests/core/rigs.h"
#include "tests/support/camera_grids.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// Six cameras of 160x120 around a performer, with mattes and meshes; three frames.
class Evaluate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    ASSERT_THAT(
        process_take({.take = small_take(*folder_, 3), .matte = "chroma", .hull = recon::HullOptions{}}),
        IsOk());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override {
    take_ = *capture::TakeReader::open(*folder_ / "take");
    options_.hold_out = {"cam02"};
    options_.methods = {"nearest", "linear"};
    options_.renderer.back_end = render::BackEnd::Cpu;
  }
  Result<std::vector<HeldOutView>> views() {
    std::vector<HeldOutView> list;
    const Result<void> done = evaluate_take(
        *take_, options_, [&](HeldOutView view) { return list.push_back(std::move(view)), Result<void>(); });
    if (!done) return forward(done);
    return list;
  }
  Result<std::map<std::string, TemporalScores>> steadiness(int count) {
    const Subject subject = *find_subject(*take_);
    return evaluate_path(*take_, options_, {orbit_around(take_->rig(), subject, {.seconds = 1}).path, count});
  }
  static TempFolder* folder_;
  std::unique_ptr<capture::TakeReader> take_;
  EvaluateOptions options_;
};
TempFolder* Evaluate::folder_ = nullptr;

TEST_F(Evaluate, FillsInEveryScore) {
  const auto all = views();
  ASSERT_THAT(all, IsOk());
  const HeldOutView& view = all->front();
  for (const auto& [method, s] : view.scores) {
    EXPECT_GT(s.psnr_edge, 5) << method;
    EXPECT_GE(s.psnr_color, s.psnr - 1e-9) << method;
    EXPECT_TRUE(std::isfinite(s.ghosting)) << method;
  }
  EXPECT_LT(view.scores.at("nearest").ghosting, 0.1) << "one photograph has no ghosts";
  EXPECT_GT(view.scores.at("linear").ghosting, 1);
}

TEST_F(Evaluate, SaysOfHowManyPixelsBlendingMakesGhosts) {
  options_.classes = true;
  options_.methods = {"nearest", "linear", "floating"};
  options_.renderer.uncertainty = 0.2;
  const auto all = views();
  ASSERT_THAT(all, IsOk());
  const std::map<std::string, Scores>& scores = all->front().scores;
  EXPECT_EQ(scores.at("nearest").predicted_ghost, 0) << "one photograph has no ghosts";
  EXPECT_GT(scores.at("linear").predicted_ghost, 0.1) << "where two cameras of this wide ring meet";
  EXPECT_LE(scores.at("linear").predicted_ghost + scores.at("linear").predicted_blurred, 1);
  EXPECT_TRUE(std::isnan(scores.at("linear").measured_ghost)) << "it has no flow";
  EXPECT_GE(scores.at("floating").measured_ghost, 0);
  options_.renderer.uncertainty = 0;
  const auto right = views();
  ASSERT_THAT(right, IsOk());
  EXPECT_EQ(right->front().scores.at("linear").predicted_ghost, 0) << "the proxy is said to be right";
  EXPECT_EQ(right->front().scores.at("floating").measured_ghost, scores.at("floating").measured_ghost)
      << "what is measured does not ask";
}

TEST_F(Evaluate, SaysHowMuchErrorsChangeFromFrameToFrame) {
  options_.frames = {0, 1, 2};
  const auto all = views();
  ASSERT_THAT(all, IsOk());
  EXPECT_TRUE(std::isnan((*all)[0].scores.at("linear").flicker)) << "nothing is before the first";
  EXPECT_GT((*all)[1].scores.at("linear").flicker, 0.5);
  EXPECT_GT((*all)[2].scores.at("nearest").flicker, 0.5);
  options_.frames = {2};
  options_.frame_before = 1;
  const auto last = views();
  ASSERT_THAT(last, IsOk());
  ASSERT_EQ(last->size(), 1u);
  EXPECT_EQ(last->front().scores.at("linear").flicker, (*all)[2].scores.at("linear").flicker);
  options_.frames = {0, 2};
  options_.frame_before = -1;
  EXPECT_TRUE(std::isnan(views()->back().scores.at("linear").flicker)) << "they do not follow one another";
}

TEST_F(Evaluate, DrawsOnWhatFilmsAreDrawnOn) {
  const auto films = views();
  options_.proxy.kind = Proxy::Kind::Hull;
  options_.proxy.hull.voting = recon::HullVoting::Strict;
  const auto exact = views();
  options_.proxy.hull.method = recon::HullMethod::Octree;
  options_.proxy.hull.resolution = 64;
  const auto octree = views();
  ASSERT_THAT(films, IsOk());
  ASSERT_THAT(octree, IsOk());
  EXPECT_EQ(films->front().rendered.at("linear"), exact->front().rendered.at("linear"))
      << "the options of the take's meshes";
  EXPECT_NE(films->front().rendered.at("linear"), octree->front().rendered.at("linear"));
}

TEST_F(Evaluate, DrawsOnAFileOrAPlane) {
  options_.proxy = *parse_proxy(take_->layout().mesh(0).string(), {});
  EXPECT_GT(views()->front().scores.at("linear").psnr, 10);
  EXPECT_THAT(parse_proxy("cube", {}), FailsWith(ErrorCode::InvalidArgument, "plane:Z"));
  EXPECT_THAT(parse_proxy("plane:", {}), FailsWith(ErrorCode::InvalidArgument, "plane:Z"));
  EXPECT_THAT(parse_proxy("plane:nan", {}), FailsWith(ErrorCode::InvalidArgument, "plane:Z"));
  options_.proxy = *parse_proxy("none.ply", {});
  EXPECT_THAT(views(), FailsWith(ErrorCode::NotFound, "none.ply"));
  options_.proxy = *parse_proxy("plane:2", {});
  EXPECT_THAT(views(), FailsWith(ErrorCode::InvalidArgument, "all directions")) << "they stand in a ring";
}

TEST_F(Evaluate, ComparesSmallPicturesWithShrunkPhotographs) {
  const double full = views()->front().scores.at("linear").psnr;
  options_.scale = 2;
  const auto half = views();
  ASSERT_THAT(half, IsOk());
  EXPECT_EQ(half->front().truth.width, 80);
  EXPECT_EQ(half->front().rendered.at("linear").height, 60);
  EXPECT_GT(half->front().scores.at("linear").psnr, full) << "what is small is forgiving";
  options_.scale = 1000;
  EXPECT_THAT(views(), FailsWith(ErrorCode::InvalidArgument, "leaves nothing"));
}

TEST_F(Evaluate, DrawsFromTheInputsAlone) {
  const Image all = views()->front().rendered.at("linear");
  options_.inputs = {"cam00", "cam01", "cam02", "cam04"};
  const auto some = views();
  ASSERT_THAT(some, IsOk());
  EXPECT_NE(some->front().rendered.at("linear"), all);
  options_.hold_out.clear();
  EXPECT_EQ(views()->size(), 2u) << "the two that are no inputs";
}

TEST_F(Evaluate, SaysHowSteadyMethodsAre) {
  const auto scores = steadiness(24);
  ASSERT_THAT(scores, IsOk());
  const TemporalScores &nearest = scores->at("nearest"), &linear = scores->at("linear");
  EXPECT_EQ(linear.steps, 23);
  EXPECT_GT(linear.points, 100);
  EXPECT_GT(linear.jitter, 0);
  EXPECT_GT(linear.jitter_p999, linear.jitter);
  EXPECT_GT(linear.pop, 1);
  EXPECT_GE(linear.set_changes, 3) << "six cameras in a turn";
  EXPECT_GT(nearest.jitter, linear.jitter) << "it jumps from photograph to photograph";
  EXPECT_GT(nearest.pop, 1.5 * linear.pop) << "and stands still in between";
  EXPECT_THAT(steadiness(3), FailsWith(ErrorCode::InvalidArgument, "four pictures"));
  EXPECT_THAT(evaluate_path(*take_, options_, {CameraPath{{PathKey{}}}, 9}),
              FailsWith(ErrorCode::InvalidArgument, "one key"));
}

TEST_F(Evaluate, FloatingNeitherPopsNorTremblesMuchMoreThanLinear) {
  options_.methods = {"linear", "floating"};
  const auto scores = steadiness(48);
  ASSERT_THAT(scores, IsOk());
  const TemporalScores &linear = scores->at("linear"), &floating = scores->at("floating");
  EXPECT_LE(floating.jitter, 1.3 * linear.jitter) << "fields between cameras 60 degrees apart tremble";
  EXPECT_LE(floating.jitter_p999, 1.5 * linear.jitter_p999);
  EXPECT_LE(floating.pop, 1.25 * linear.pop);
}

TEST(PlaneBefore, CoversWhatTheCamerasSee) {
  const Rig wall = camera_wall(3, 3);
  const Result<Mesh> plane = plane_before(wall, 1);
  ASSERT_THAT(plane, IsOk());
  const Eigen::AlignedBox3f box = bounding_box(*plane);
  EXPECT_NEAR(box.min().y(), 0, 1e-6) << "it stands across the viewing direction";
  EXPECT_NEAR(box.max().y(), 0, 1e-6);
  const double half = 0.5 / 1.5 + 0.1;  // half of a picture at a metre, and the outer cameras' places
  EXPECT_NEAR(box.max().x(), half, 1e-6);
  EXPECT_NEAR(box.max().z(), 0.75 * 0.5 / 1.5 + 0.1, 1e-6);
  EXPECT_LT(signed_volume({plane->positions, plane->triangles}), 1e-6);
  for (const double behind : {0.0, -1.0})
    EXPECT_THAT(plane_before(wall, behind), FailsWith(ErrorCode::InvalidArgument, "not before camera"));
}

}  // namespace
}  // namespace floatstage::pipeline
