#include "pipeline/matte/label_take.h"

#include <filesystem>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/chosen_take.h"
#include "pipeline/label_record.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "tests/support/small_take.h"

// Two performers who walk past one another, and who is who.
namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

// A take of two, with true mattes of both together.
fs::path take_of_two(const TempFolder& folder, SyntheticCast cast, int frames, int width = 200,
                     double fps = 12.5) {
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig = {.cameras = 8, .width = width, .height = width * 3 / 4};
  options.studio.samples = 4;
  options.studio.frame_rate = fps;
  options.studio.cast = cast;
  options.frames = frames;
  EXPECT_THAT(synthesize_take(options), IsOk());
  const TakeLayout layout(options.out);
  for (int c = 0; c < options.rig.cameras; ++c)
    for (int f = 0; f < frames; ++f) {
      const std::string serial = text("cam0", c);
      fs::create_directories(layout.mattes() / serial);
      fs::copy_file(layout.truth().matte(serial, f), layout.matte(serial, f));
    }
  return options.out;
}

// The middle of a label's true matte, where a person would click.
LabelClick click_on(const fs::path& take, const std::string& label, const std::string& serial, int frame) {
  const Image truth = *load_png(TakeLayout(take).truth().label_matte(serial, label, frame));
  LabelClick click{label, serial, frame, 0, 0};
  int best = -1;
  for (int y = 2; y < truth.height - 2; ++y)
    for (int x = 2; x < truth.width - 2; ++x) {
      int full = 0;  // how far it is covered to each side
      while (full < x && full<truth.width - 1 - x&& * truth.at(x - full, y)> 250 &&
             *truth.at(x + full, y) > 250)
        ++full;
      if (full > best) best = full, click.x = x + 0.5, click.y = y + 0.5;
    }
  return click;
}

LabelChoice only(const std::string& label) { return {{label}, {}}; }
LabelChoice without(std::vector<std::string> labels) { return {{}, std::move(labels)}; }

// IoU over all cameras of these frames.
double iou_of(const fs::path& take, const std::string& label, int first, int end) {
  const TakeLayout layout(take);
  double both = 0, either = 0;
  for (int c = 0; c < 8; ++c)
    for (int f = first; f < end; ++f) {
      const std::string serial = text("cam0", c);
      const Image is = *load_png(layout.label_matte(serial, label, f)),
                  real = *load_png(layout.truth().label_matte(serial, label, f));
      for (std::size_t p = 0; p < is.pixels.size(); ++p) {
        const bool a = is.pixels[p] >= 128, b = real.pixels[p] >= 128;
        both += a && b, either += a || b;
      }
    }
  return both / either;
}

LabelTakeOptions clicks_of(const fs::path& take, int frame = 0) {
  LabelTakeOptions options{.threads = 2};
  options.said = LabelsSaid{};
  for (const char* label : {"first", "second"})
    options.said->clicks.push_back(click_on(take, label, "cam00", frame));
  return options;
}

TEST(LabelTake, FollowsTwoWhoCrossFromOneClickEach) {
  const TempFolder folder;
  const fs::path take = take_of_two(folder, SyntheticCast::Two, 24);
  const Result<LabelTakeReport> report = label_take(take, clicks_of(take));
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, IsEmpty());
  EXPECT_EQ(report->made, 2 * 8 * 24);
  for (const char* label : {"first", "second"}) {
    EXPECT_GE(iou_of(take, label, 0, 24), 0.95) << label;
    for (int f = 0; f < 24; ++f) EXPECT_GE(iou_of(take, label, f, f + 1), 0.85) << label << " in frame " << f;
    EXPECT_GE(iou_of(take, label, 20, 24), 0.96) << label << " after they crossed";
  }
  // They add up to the sum, to the last digit.
  const TakeLayout layout(take);
  for (const int f : {0, 12, 23}) {
    const Image sum = *load_png(layout.matte("cam03", f)),
                a = *load_png(layout.label_matte("cam03", "first", f)),
                b = *load_png(layout.label_matte("cam03", "second", f));
    for (std::size_t p = 0; p < sum.pixels.size(); ++p) ASSERT_EQ(a.pixels[p] + b.pixels[p], sum.pixels[p]);
  }
}

TEST(LabelTake, SaysWhereTwoOfTheSameLookAreOneBody) {
  const TempFolder folder;
  const fs::path take = take_of_two(folder, SyntheticCast::Alike, 9, 100, 5);
  const Result<LabelTakeReport> report = label_take(take, clicks_of(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_THAT(report->doubts, testing::Not(IsEmpty()));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("have the same colours"));
  const Result<LabelTakeReport> again = label_take(take, {});
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 0);
  EXPECT_EQ(again->doubts.size(), report->doubts.size()) << "until it is made another way";
}

class TwoApart : public testing::Test {
 protected:
  TwoApart() : take_(take_of_two(folder_, SyntheticCast::Two, 2, 100)), layout_(take_) {}
  fs::path masks_of(const std::string& label, const std::string& serial, int frame) const {
    const fs::path file = folder_ / ("masks " + label) / serial / layout_.matte(serial, frame).filename();
    fs::create_directories(file.parent_path());
    fs::copy_file(layout_.truth().label_matte(serial, label, frame), file,
                  fs::copy_options::overwrite_existing);
    return folder_ / ("masks " + label);
  }
  Result<LabelTakeReport> say(LabelsSaid said) const {
    return label_take(take_, {.said = std::move(said), .threads = 2});
  }
  LabelsSaid both_clicked() const { return *clicks_of(take_).said; }

  const TempFolder folder_;
  const fs::path take_;
  const TakeLayout layout_;
};

TEST_F(TwoApart, AreToldApartByMasksOfOneCamera) {
  const LabelsSaid said{
      {{"first", masks_of("first", "cam02", 0)}, {"second", masks_of("second", "cam02", 0)}}, {}};
  ASSERT_THAT(say(said), IsOk());
  for (const char* label : {"first", "second"}) EXPECT_GE(iou_of(take_, label, 0, 2), 0.93) << label;
  EXPECT_TRUE(fs::exists(layout_.label_masks() / "first/cam02/000000.png"))
      << "what was said stays in the take";
}

TEST_F(TwoApart, AreMadeAnewWhenAMatteHasChanged) {
  ASSERT_EQ(say(both_clicked())->made, 32);
  EXPECT_EQ(label_take(take_, {})->kept, 32);
  Image sum = *load_png(layout_.matte("cam01", 1));
  *sum.at(0, 0) = 255;
  ASSERT_THAT(save_png(sum, layout_.matte("cam01", 1)), IsOk());
  EXPECT_THAT(open_chosen(take_, only("first")), FailsWith(ErrorCode::NotFound, "older than the matte"));
  EXPECT_EQ(label_take(take_, {})->made, 32);
  EXPECT_THAT(open_chosen(take_, only("first")), IsOk());
}

TEST_F(TwoApart, LeaveSomebodysLabelMattesAlone) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const fs::path file = layout_.label_matte("cam01", "first", 1);
  const Image theirs = *load_png(layout_.truth().label_matte("cam01", "first", 1));
  ASSERT_THAT(save_png(theirs, file), IsOk());
  const Result<LabelTakeReport> report = label_take(take_, {});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->others, 1);
  EXPECT_EQ(*load_png(file), theirs);
}

TEST_F(TwoApart, HaveHullsOfTheirOwn) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const auto size_of = [&](LabelChoice choice) {
    const Result<ProcessReport> report =
        process_take({.take = take_, .frames = {0}, .threads = 2, .labels = choice});
    EXPECT_THAT(report, IsOk());
    Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(take_, choice);
    EXPECT_THAT(take, IsOk());
    const Result<SceneFrame> scene = SceneLoader(**take, false).load(0);
    EXPECT_THAT(scene, IsOk());
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : scene->mesh.positions) box.extend(p);
    return box;
  };
  const Eigen::AlignedBox3f all = size_of({}), first = size_of(only("first")),
                            rest = size_of(without({"first"}));
  EXPECT_GT(all.sizes().x(), 2);
  EXPECT_LT(first.sizes().x(), 1.2);
  EXPECT_LT(rest.sizes().x(), 1.2);
  EXPECT_LT(first.max().x(), rest.min().x()) << "one stands on the left";
}

TEST_F(TwoApart, AreRefusedWithASentence) {
  const LabelsSaid good = both_clicked();
  EXPECT_THAT(label_take(take_, {}), IsOkAnd(testing::Field(&LabelTakeReport::labels, IsEmpty())));
  EXPECT_THAT(say({{}, {good.clicks[0]}}), FailsWith(ErrorCode::InvalidArgument, "everybody on stage"));
  LabelsSaid bad = good;
  bad.clicks[0].label = "../x";
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "cannot be a label"));
  bad = good;
  bad.clicks[0].x = 1, bad.clicks[0].y = 1;
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "is on nobody"));
  bad.clicks[0].x = 1000;
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "outside the picture"));
  bad = good;
  bad.clicks[0].serial = "cam99";
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "which the take does not have"));
  const fs::path masks = masks_of("first", "cam00", 0);
  ASSERT_THAT(save_png(Image(10, 10, 1), masks / "cam00/000000.png"), IsOk());
  EXPECT_THAT(say({{{"first", masks}}, {good.clicks[1]}}),
              FailsWith(ErrorCode::BadData, "the mask is 10x10"));
  EXPECT_THAT(say({{{"first", folder_ / "nowhere"}}, {good.clicks[1]}}),
              FailsWith(ErrorCode::NotFound, "is no folder"));
  EXPECT_FALSE(fs::exists(layout_.label_record())) << "nothing was kept of what was refused";
  ASSERT_THAT(say(good), IsOk());
  EXPECT_THAT(open_chosen(take_, only("third")),
              FailsWith(ErrorCode::NotFound, "has no label 'third'; it has first, second"));
  EXPECT_THAT(open_chosen(take_, without({"first", "second"})),
              FailsWith(ErrorCode::InvalidArgument, "nobody is left"));
}

TEST_F(TwoApart, LeaveAFolderOfUnknownOriginWhereItIs) {
  const fs::path theirs = layout_.label_masks() / "notes.txt";
  fs::create_directories(theirs.parent_path());
  ASSERT_THAT(write_file(theirs, "mine"), IsOk());
  EXPECT_THAT(say(both_clicked()), FailsWith(ErrorCode::AlreadyExists, "move it away"));
  EXPECT_TRUE(fs::exists(theirs));
  EXPECT_FALSE(fs::exists(layout_.label_record()));
}

TEST(LabelRecord, IsTheSameAfterwards) {
  const TempFolder folder;
  const TakeLayout layout(folder.path());
  fs::create_directories(layout.mattes());
  const LabelRecord record{.labels = {"woman", "man"},
                           .clicks = {{"woman", "cam00", 3, 10.5, 20}},
                           .inputs = "abc",
                           .sums = {{"cam00", {{0, "1"}, {3, "2"}}}},
                           .files = {{"woman", {{"cam00", {{3, "4"}}}}}},
                           .doubts = {{"why", "cam00", 3, 2, "label.png"}}};
  ASSERT_THAT(save_label_record(record, layout), IsOk());
  EXPECT_EQ(*load_label_record(layout), record);
  // Cut off anywhere, it says so.
  const std::string whole = *read_file(layout.label_record());
  for (std::size_t n = 0; n + 2 < whole.size(); n += 7) {
    ASSERT_THAT(write_file(layout.label_record(), whole.substr(0, n)), IsOk());
    EXPECT_THAT(load_label_record(layout), FailsWith(ErrorCode::BadData, "give the labels again")) << n;
  }
}

}  // namespace
}  // namespace floatstage::pipeline
