// Strokes that are carried until two performers cross, and what is said of it.

#include <gmock/gmock.h>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/matte/edited_camera.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/crossing_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

constexpr int kFrames = 18;
constexpr const char* kSerial = "cam00";

class ACrossing : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    crossing_take(*shared_, kFrames);
  }
  static void TearDownTestSuite() { delete shared_; }
  ACrossing() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }

  void say(const CameraEdits& edits) {
    ASSERT_THAT(make_folder(layout_.mattes()), IsOk());
    ASSERT_THAT(save_matte_edits({{{kSerial, edits}}}, layout_.edits()), IsOk());
  }
  Result<MatteReport> matte() {
    return matte_take({.take = take_,
                       .how = "given",
                       .guide = layout_.truth().mattes(),
                       .cameras = {kSerial},
                       .threads = 1,
                       .hull_frames = 0});
  }
  // Share of the performer who was marked as background that the matte has.
  double of_the_second(int frame) const {
    const Result<Image> matte = load_png(layout_.matte(kSerial, frame)),
                        truth = load_png(layout_.truth().label_matte(kSerial, "second", frame));
    if (!matte || !truth) return -1;
    double both = 0, all = 0;
    for (std::size_t p = 0; p < truth->pixels.size(); ++p) {
      if (truth->pixels[p] < 128) continue;
      ++all;
      both += matte->pixels[p] >= 128;
    }
    return both / std::max(1.0, all);
  }

  static TempFolder* shared_;
  TempFolder folder_;
  fs::path take_ = folder_ / "crossing";
  TakeLayout layout_{take_};
};
TempFolder* ACrossing::shared_ = nullptr;

TEST_F(ACrossing, EndsWhatAStrokeChangedAndSaysWhereWithAPicture) {
  say({{{0, {off_the_second()}}}, {}});
  const Result<MatteReport> report = matte();
  ASSERT_THAT(report, IsOk());
  for (const MatteDoubt& d : report->doubts) std::printf("%s\n", sentence(d).c_str());
  ASSERT_LT(of_the_second(10), 0.1) << "he is gone while he stands beside the other";
  ASSERT_GT(of_the_second(kFrames - 1), 0.8) << "and back afterwards";
  EXPECT_THAT(
      report->doubts,
      Contains(AllOf(testing::Field(&MatteDoubt::worst, testing::AllOf(testing::Ge(11), testing::Le(14))),
                     testing::Field(&MatteDoubt::cameras, testing::ElementsAre(kSerial)),
                     testing::Field(&MatteDoubt::why, HasSubstr("followed no further than frame 1")))));
  for (const MatteDoubt& d : report->doubts) {
    EXPECT_TRUE(fs::exists(d.picture)) << d.why;
    EXPECT_GT(of_the_second(d.worst), of_the_second(d.worst - 1) + 0.05) << "frame " << d.worst;
  }
  const Result<MatteReport> again = matte();
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 0);
  EXPECT_EQ(again->doubts.size(), report->doubts.size()) << "it is said as long as the mattes are these";
}

// Who says that it is right so is asked no more.
TEST_F(ACrossing, IsNamedNoMoreWhereSomebodyAnswersAtThePlaceThatIsNamed) {
  CameraEdits edits{{{0, {off_the_second()}}}, {}};
  int answers = 0;
  for (;; ++answers) {
    say(edits);
    const Result<MatteReport> report = matte();
    ASSERT_THAT(report, IsOk());
    if (report->doubts.empty()) break;
    ASSERT_LT(answers, 6) << sentence(report->doubts.front());
    const MatteDoubt& doubt = report->doubts.front();
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(doubt.why.substr(doubt.why.find(": at ")).c_str(), ": at %lf,%lf", &x, &y), 2)
        << doubt.why;
    const MatteStroke subject{MatteLabel::Foreground, 0.5, {{x + 0.5, y + 0.5}}};
    auto at = edits.keyframes.begin();
    while (at != edits.keyframes.end() && at->frame < doubt.worst) ++at;
    if (at != edits.keyframes.end() && at->frame == doubt.worst)
      at->strokes.push_back(subject);
    else
      edits.keyframes.insert(at, {doubt.worst, {subject}});
  }
  EXPECT_GT(answers, 0);
}

TEST_F(ACrossing, EndsTheReachOfAKeyframeInTheEditor) {
  const CameraEdits edits{{{0, {off_the_second()}}}, {}};
  say(edits);
  const auto open = [&] {
    return EditedCamera::open(
        {.take = take_, .serial = kSerial, .how = "given", .guide = layout_.truth().mattes(), .threads = 1});
  };
  Result<std::unique_ptr<EditedCamera>> camera = open();
  ASSERT_THAT(camera, IsOk());
  EXPECT_EQ((*camera)->guided(), std::vector<bool>(kFrames)) << "nothing is made";
  ASSERT_THAT((*camera)->remake(edits, {}), IsOk());
  EXPECT_THAT((*camera)->ended(), Contains(HasSubstr("followed no further than frame 1")));
  const std::vector<bool> guided = (*camera)->guided();
  EXPECT_TRUE(guided[0] && guided[10]);
  EXPECT_FALSE(guided[kFrames - 1]) << "the reach ends where what was said is not carried on";
  const auto doubts = (*camera)->doubts();
  EXPECT_FALSE(doubts.empty());
  camera = open();
  ASSERT_THAT(camera, IsOk());
  EXPECT_EQ((*camera)->guided(), guided) << "known in another session";
  EXPECT_EQ((*camera)->doubts(), doubts);
}

}  // namespace
}  // namespace floatstage::pipeline
