#include "pipeline/matte/matte_take.h"

#include <chrono>
#include <filesystem>

#include "core/file.h"
#include "core/matte.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "pipeline/matte/export_layers.h"
#include "pipeline/matte/hull_agreement.h"
#include "pipeline/matte/matte_how.h"
#include "tests/support/child_process.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

MatteTakeOptions options_for(const fs::path& take, std::string method = "auto") {
  MatteTakeOptions options;
  options.take = take;
  options.how = std::move(method);
  options.threads = 2;
  return options;
}

Image matte_of(const fs::path& take, const char* serial, int frame) {
  Result<Image> matte = load_png(TakeLayout(take).matte(serial, frame));
  EXPECT_THAT(matte, IsOk());
  return matte ? std::move(*matte) : Image();
}

double iou_with_truth(const fs::path& take, const char* serial, int frame) {
  return iou(make_matte({}, matte_of(take, serial, frame)),
             make_matte({}, matte_of(take / "truth", serial, frame)));
}

class EveryMethod : public testing::TestWithParam<std::string> {};

TEST_P(EveryMethod, MattesAllCamerasOfATakeInOneCall) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  const Result<MatteReport> report = matte_take(options_for(take, GetParam()));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 12);
  EXPECT_GT(report->seconds_per_frame, 0);
  for (const CameraMattes& c : report->cameras) {
    EXPECT_EQ(c.made, 2) << c.serial;
    EXPECT_THAT(c.failures, testing::IsEmpty());
    for (int f = 0; f < 2; ++f)
      EXPECT_GE(iou_with_truth(take, c.serial.c_str(), f), 0.9) << c.serial << " " << f;
    ASSERT_TRUE(c.hull_agreement) << c.serial;
    EXPECT_GT(*c.hull_agreement, 0.6);
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const MatteMethod& m : matte_methods())
    if (m.name != "given" && m.name != "luminance") all.push_back(m.name);  // the cloth is not black
  return all;
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(names()), [](const auto& suite) {
  std::string name = suite.param;
  std::erase(name, '-');
  return name;
});

TEST(MatteTake, GoesOnWhereItStopped) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ASSERT_THAT(matte_take(options_for(take)), IsOk());
  const Image before = matte_of(take, "cam02", 1);
  fs::remove(TakeLayout(take).matte("cam02", 1));
  const Result<MatteReport> again = matte_take(options_for(take));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 1);
  EXPECT_EQ(again->cameras[0].kept, 2);
  EXPECT_EQ(matte_of(take, "cam02", 1), before) << "the same bytes";
}

TEST(MatteTake, KeepsTheMattesOfATakeThatWasCopiedOrMoved) {
  TempFolder folder;
  const fs::path take = small_take(folder), copy = folder / "another name";
  ASSERT_EQ(matte_take(options_for(take, "chroma"))->made, 12);
  fs::copy(take, copy, fs::copy_options::recursive);
  const Result<MatteReport> report = matte_take(options_for(copy, "chroma"));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 0);
}

TEST(MatteTake, MakesAgainOnlyOnRequestAndOnlyWhatWasMadeOtherwise) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(matte_take(options_for(take, "chroma")), IsOk());
  MatteTakeOptions other = options_for(take, "closed-form");
  EXPECT_THAT(matte_take(other), FailsWith(ErrorCode::AlreadyExists, "--redo"));
  EXPECT_TRUE(fs::exists(TakeLayout(take).matte("cam00", 0)));
  MatteEdits edits;
  edits.cameras["cam03"].masks.push_back(
      {MatteLabel::Background, {{0, 0}, {160, 0}, {160, 120}, {0, 120}}, 0, {}});
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
  MatteTakeOptions same = options_for(take, "chroma");
  const Result<MatteReport> again = matte_take(same);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 1) << "cam03 alone has new edits";
  EXPECT_EQ(matte_of(take, "cam03", 0), Image(160, 120, 1)) << "all of it is garbage now";
  other.redo = true;
  const Result<MatteReport> redone = matte_take(other);
  ASSERT_THAT(redone, IsOk());
  EXPECT_EQ(redone->made, 6);
  EXPECT_EQ(redone->cameras[0].method, "closed-form");
  EXPECT_TRUE(fs::exists(TakeLayout(take).edits())) << "a person's work";
}

TEST(MatteTake, UsesMattesOfUnknownOriginAndNeverTouchesThem) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  const fs::path painted = TakeLayout(take).matte("cam02", 1);
  ASSERT_THAT(make_folder(painted.parent_path()), IsOk());
  ASSERT_THAT(save_png(Image(160, 120, 1, 77), painted), IsOk());
  const std::string bytes = *read_file(painted);
  MatteTakeOptions options = options_for(take, "chroma");
  for (const bool redo : {false, true}) {
    options.redo = redo;
    const Result<MatteReport> report = matte_take(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->made, 11);
    EXPECT_EQ(report->cameras[2].others, 1);
    EXPECT_EQ(*read_file(painted), bytes);
  }
  // Painted over what was made: from then on it is somebody's.
  ASSERT_THAT(save_png(Image(160, 120, 1, 33), TakeLayout(take).matte("cam04", 0)), IsOk());
  options.redo = true;
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 10);
  EXPECT_EQ(matte_of(take, "cam04", 0), Image(160, 120, 1, 33));
}

TEST(MatteTake, MakesNothingWhereSomebodyGaveMattesUnlessAsked) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  fs::copy(TakeLayout(take).truth().mattes(), TakeLayout(take).mattes(), fs::copy_options::recursive);
  fs::remove(TakeLayout(take).matte("cam05", 0));
  MatteTakeOptions options = options_for(take);
  options.how.reset();
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 0);
  EXPECT_EQ(report->cameras[0].key, "given");
  EXPECT_EQ(report->cameras[0].others, 1);
  EXPECT_EQ(report->cameras[5].gaps, 1);
  EXPECT_FALSE(fs::exists(TakeLayout(take).made_mattes())) << "nothing was made";
  MatteEdits edits;
  edits.cameras["cam01"].masks.push_back({MatteLabel::Background, {{2, 2}}, 0, {}, 2});
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
  EXPECT_THAT(matte_take(options)->remarks,
              testing::ElementsAre(HasSubstr("camera 'cam01': 1 mattes of unknown")))
      << "an edit that has no effect is said";
  options.how = "chroma";
  const Result<MatteReport> asked = matte_take(options);
  ASSERT_THAT(asked, IsOk());
  EXPECT_EQ(asked->made, 1) << "what was missing";
}

TEST(MatteTake, TriesOneInstantFirstAndGoesOnWithWhatWasTried) {
  TempFolder folder;
  const fs::path take = small_take(folder, 3);
  MatteTakeOptions one = options_for(take, "chroma");
  one.frames = {1};
  one.cameras = {"cam00", "cam01"};
  EXPECT_EQ(matte_take(one)->made, 2);
  one.how = "closed-form";
  EXPECT_THAT(matte_take(one), FailsWith(ErrorCode::AlreadyExists, "--redo"));
  one.redo = true;
  EXPECT_EQ(matte_take(one)->made, 2);
  MatteTakeOptions all = options_for(take);
  all.how.reset();
  const Result<MatteReport> report = matte_take(all);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 16);
  for (const CameraMattes& c : report->cameras) EXPECT_EQ(c.method, "closed-form") << c.serial;
  // Another way at one instant leaves the others as they are until they are asked for.
  const std::string before = *read_file(TakeLayout(take).matte("cam00", 2));
  one.how = "chroma";
  EXPECT_EQ(matte_take(one)->made, 2);
  EXPECT_EQ(*read_file(TakeLayout(take).matte("cam00", 2)), before);
  EXPECT_EQ(matte_take(all)->made, 4) << "the other instants of the two cameras";
  EXPECT_NE(*read_file(TakeLayout(take).matte("cam00", 2)), before);
  one.frames = {7};
  EXPECT_THAT(matte_take(one), FailsWith(ErrorCode::InvalidArgument, "frame 7"));
}

TEST(MatteTake, MakesMattesAgainWhosePlateWasShotSince) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  const MatteTakeOptions options = options_for(take, "difference");
  ASSERT_THAT(matte_take(options), IsOk());
  Result<Image> plate = load_png(TakeLayout(take).plate("cam01"));
  ASSERT_THAT(plate, IsOk());
  plate->pixels[0] ^= 1;
  ASSERT_THAT(save_png(*plate, TakeLayout(take).plate("cam01")), IsOk());
  EXPECT_EQ(matte_take(options)->made, 1);
  EXPECT_EQ(matte_take(options)->made, 0);
}

TEST(MatteTake, KnowsItsFilesWhenItWasKilled) {
  TempFolder folder;
  const fs::path take = small_take(folder, 4);
  MatteTakeOptions options = options_for(take, "chroma");
  ChildProcess child([&](const std::function<void()>& report) {
    class Watch : public Progress {
     public:
      explicit Watch(const std::function<void()>& tell) : tell_(tell) {}
      void begin(const std::string& what, std::size_t) override { mattes_ = what == "mattes"; }
      void advance(std::size_t) override {
        if (mattes_) tell_();
      }
      void end() override {}
      bool cancelled() const override { return false; }

     private:
      const std::function<void()>& tell_;
      bool mattes_ = false;
    } watch(report);
    options.progress = &watch;
    return matte_take(options) ? 0 : 1;
  });
  EXPECT_TRUE(child.wait_for_reports(3));
  child.kill();
  child.wait();
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  int kept = 0;
  for (const CameraMattes& c : report->cameras) {
    EXPECT_EQ(c.others, 0) << c.serial;
    kept += c.kept;
  }
  EXPECT_GE(kept, 3);
}

TEST(MatteTake, GivesTheSameBytesAtAnyNumberOfThreads) {
  TempFolder one, many;
  const fs::path a = small_take(one), b = small_take(many);
  MatteTakeOptions alone = options_for(a), together = options_for(b);
  alone.threads = 1;
  together.threads = 4;
  ASSERT_THAT(matte_take(alone), IsOk());
  ASSERT_THAT(matte_take(together), IsOk());
  for (const char* serial : {"cam00", "cam03", "cam05"})
    for (int f = 0; f < 2; ++f) EXPECT_EQ(matte_of(a, serial, f), matte_of(b, serial, f));
}

// A guide with two people: the truth and a square that is nobody.
fs::path guide_with_a_stranger(const TempFolder& folder, const fs::path& take) {
  const fs::path guide = folder / "guide";
  fs::copy(TakeLayout(take).truth().mattes(), guide, fs::copy_options::recursive);
  for (int f = 0; f < 3; ++f) {
    Image matte = matte_of(take / "truth", "cam01", f);
    for (int y = 5; y < 25; ++y) std::fill_n(matte.at(4, y), 20, std::uint8_t{255});
    EXPECT_THAT(save_png(matte, guide / "cam01" / TakeLayout(take).matte("cam01", f).filename()), IsOk());
  }
  return guide;
}

TEST(MatteTake, FollowsTheClickedPartBothWays) {
  TempFolder folder;
  const fs::path take = small_take(folder, 3);
  MatteTakeOptions options = options_for(take, "closed-form");
  options.guide = guide_with_a_stranger(folder, take);
  options.cameras = {"cam01"};
  MatteEdits edits;
  edits.cameras["cam01"].keyframes.push_back(
      {1, {{MatteLabel::Background, 2, {{14, 15}}}, {MatteLabel::Foreground, 1, {{80, 60}}}}});
  ASSERT_EQ(*matte_of(take / "truth", "cam01", 1).at(80, 60), 255) << "the click is on the dancer";
  ASSERT_THAT(make_folder(TakeLayout(take).mattes()), IsOk());
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].clicks, 2);
  for (int f = 0; f < 3; ++f) {
    EXPECT_EQ(*matte_of(take, "cam01", f).at(14, 15), 0) << "frame " << f;
    EXPECT_GE(iou_with_truth(take, "cam01", f), 0.9) << "frame " << f;
  }
}

TEST(MatteTake, TakesOthersMattesAsAGuideAndNamesTheOneThatDoesNotFit) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  MatteTakeOptions options = options_for(take, "closed-form");
  options.guide = folder / "guide";
  fs::copy(TakeLayout(take).truth().mattes(), options.guide, fs::copy_options::recursive);
  ASSERT_THAT(
      save_png(Image(80, 60, 1), options.guide / "cam04" / TakeLayout(take).matte("cam04", 1).filename()),
      IsOk());
  const Result<MatteReport> report = matte_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->made, 11);
  ASSERT_EQ(report->cameras[4].failures.size(), 1u);
  EXPECT_THAT(report->cameras[4].failures[0], HasSubstr("80x60"));
  EXPECT_EQ(report->cameras[0].key, "guide");
  options.guide = folder / "nowhere";
  options.redo = true;
  EXPECT_THAT(matte_take(options), FailsWith(ErrorCode::NotFound, "nowhere"));
  EXPECT_TRUE(fs::exists(TakeLayout(take).matte("cam00", 0))) << "nothing goes before all cameras have a key";
}

TEST(MatteTake, NamesWhatItDoesNotKnow) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  EXPECT_THAT(matte_take(options_for(take, "magic")), FailsWith(ErrorCode::InvalidArgument, "closed-form"));
  MatteTakeOptions options = options_for(take);
  options.cameras = {"cam77"};
  EXPECT_THAT(matte_take(options), FailsWith(ErrorCode::InvalidArgument, "cam77"));
  MatteEdits edits;
  edits.cameras["cam99"] = {};
  ASSERT_THAT(make_folder(TakeLayout(take).mattes()), IsOk());
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
  EXPECT_THAT(matte_take(options_for(take)), FailsWith(ErrorCode::BadData, "cam99"));
  EXPECT_THAT(matte_take(options_for(folder / "nowhere")), FailsWith(ErrorCode::NotFound, "nowhere"));
}

TEST(MatteTake, KeepsFinishedMattesWhenTheDiskIsFull) {
  TempFolder folder;
  const fs::path take = small_take(folder, 2);
  MatteTakeOptions options = options_for(take, "chroma");
  options.threads = 1;
  ChildProcess child([&](const std::function<void()>&) {
    let_files_grow_to(1500);  // room for a record and small mattes, not for all
    const Result<MatteReport> report = matte_take(options);
    return !report && report.error().code == ErrorCode::Io ? 0 : 1;
  });
  EXPECT_EQ(child.wait(), 0);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(TakeLayout(take).mattes()))
    if (entry.path().extension() == ".png") {
      EXPECT_THAT(load_png(entry.path()), IsOk()) << entry.path();
    }
}

TEST(MatteTake, MattesACutOffVideoUpToTheCut) {
  TempFolder folder;
  const fs::path take = small_take(folder, 4), media = take / "cam02.mkv";
  fs::resize_file(media, fs::file_size(media) * 6 / 10);
  const Result<MatteReport> report = matte_take(options_for(take, "chroma"));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[1].made, 4);
  EXPECT_GT(report->cameras[2].made, 0);
  EXPECT_LT(report->cameras[2].made, 4);
  EXPECT_EQ(report->cameras[2].made + report->cameras[2].gaps, 4);
}

// A take of pictures of one colour.
fs::path flat_take(const TempFolder& folder, std::array<std::uint8_t, 3> color) {
  SyntheticRigOptions rig;
  rig.cameras = 2, rig.width = 64, rig.height = 48;
  auto writer = capture::TakeWriter::create(folder / "flat", synthetic_rig(rig), {});
  EXPECT_THAT(writer, IsOk());
  for (int f = 0; f < 3; ++f)
    for (int c = 0; c < 2; ++c) {
      Image picture(64, 48, 3);
      for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = color[i % 3];
      FrameInfo info;
      info.camera = c, info.sequence = static_cast<std::uint64_t>(f), info.exposure_start = {f * 40'000'000};
      EXPECT_THAT((*writer)->write(make_frame(info, picture)), IsOk());
    }
  EXPECT_THAT((*writer)->finish(), IsOk());
  return folder / "flat";
}

TEST(MatteTake, SeesNobodyInPicturesOfOneColour) {
  for (const std::array<std::uint8_t, 3> color :
       {std::array<std::uint8_t, 3>{40, 120, 50}, {90, 90, 90}, {0, 0, 0}, {255, 255, 255}}) {
    TempFolder folder;
    const fs::path take = flat_take(folder, color);
    const Result<MatteReport> report = matte_take(options_for(take));
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->made, 6);
    EXPECT_EQ(matte_of(take, "cam00", 1), Image(64, 48, 1));
    EXPECT_THAT(report->worst, testing::IsEmpty()) << "no subject, no hull";
  }
  TempFolder folder;
  EXPECT_THAT(matte_take(options_for(flat_take(folder, {90, 90, 90}), "chroma")),
              FailsWith(ErrorCode::NotFound, "camera 'cam00'"));
}

TEST(HullAgreement, PutsTheCameraFirstWhoseMatteIsWrong) {
  TempFolder folder;
  const fs::path path = small_take(folder, 1);
  fs::copy(TakeLayout(path).truth().mattes(), TakeLayout(path).mattes(), fs::copy_options::recursive);
  auto take = capture::TakeReader::open(path);
  ASSERT_THAT(take, IsOk());
  const auto good = hull_agreement(**take, {0}, 1);
  ASSERT_THAT(good, IsOk());
  ASSERT_EQ(good->size(), 6u);
  for (const recon::SilhouetteAgreement& a : *good)
    EXPECT_LT(a.surplus, 0.1) << a.serial << ": the true matte lies inside the others' hull";
  Image wrong = matte_of(path / "truth", "cam03", 0);
  for (int y = 0; y < 40; ++y) std::fill_n(wrong.at(100, y), 60, std::uint8_t{255});
  ASSERT_THAT(save_png(wrong, TakeLayout(path).matte("cam03", 0)), IsOk());
  const auto bad = hull_agreement(**take, {0}, 1);
  ASSERT_THAT(bad, IsOk());
  EXPECT_EQ(bad->front().serial, "cam03");
  EXPECT_GT(bad->front().surplus, 0.2);
}

TEST(ExportLayers, WritesTheSubjectWithStraightAlpha) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  MatteTakeOptions one = options_for(take, "chroma");
  one.cameras = {"cam01"};
  ASSERT_THAT(matte_take(one), IsOk());
  const ExportOptions options{
      .take = take, .out = folder / "layers", .format = "png8", .cameras = {"cam01"}, .threads = 1};
  EXPECT_THAT(export_layers(options), IsOkAnd(1));
  const Result<Image> layer = load_png(folder / "layers" / "cam01" / "000000.png");
  ASSERT_THAT(layer, IsOk());
  ASSERT_EQ(layer->channels, 4);
  const Image matte = matte_of(take, "cam01", 0);
  int green = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const std::uint8_t* p = layer->at(x, y);
      EXPECT_EQ(p[3], *matte.at(x, y));
      green += p[3] > 20 && p[1] > std::max(p[0], p[2]) + 30;
    }
  EXPECT_LT(green, 5) << "no cloth in the subject's colours";
}

TEST(ExportLayers, WritesSixteenBitsAndExr) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(matte_take(options_for(take, "chroma")), IsOk());
  ExportOptions options{
      .take = take, .out = folder / "wide", .format = "png16", .cameras = {"cam01"}, .threads = 1};
  EXPECT_THAT(export_layers(options), IsOkAnd(1));
  const Result<std::string> bytes = read_file(folder / "wide" / "cam01" / "000000.png");
  ASSERT_THAT(bytes, IsOk());
  EXPECT_EQ((*bytes)[24], 16) << "bits a channel in the PNG header";
  EXPECT_THAT(load_png(folder / "wide" / "cam01" / "000000.png"),
              IsOkAnd(testing::Field(&Image::channels, 4)));
  options.out = folder / "exr";
  options.format = "exr";
  EXPECT_THAT(export_layers(options), IsOkAnd(1));
  const Result<std::string> exr = read_file(folder / "exr" / "cam01" / "000000.exr");
  ASSERT_THAT(exr, IsOk());
  EXPECT_EQ(exr->substr(0, 4), std::string("\x76\x2f\x31\x01", 4)) << "EXR's magic number";
  options.format = "tiff";
  EXPECT_THAT(export_layers(options), FailsWith(ErrorCode::InvalidArgument, "png16"));
}

TEST(ExportLayers, KeepWhatIsDoneAndFollowNewMattesAndFormats) {
  TempFolder folder;
  const fs::path take = small_take(folder, 2);
  ASSERT_THAT(matte_take(options_for(take, "chroma")), IsOk());
  ExportOptions options{
      .take = take, .out = folder / "layers", .format = "png8", .cameras = {"cam01"}, .threads = 1};
  const fs::path first = folder / "layers" / "cam01" / "000000.png",
                 second = folder / "layers" / "cam01" / "000001.png";
  ASSERT_THAT(export_layers(options), IsOkAnd(2));
  ASSERT_THAT(save_png(Image(1, 1, 4), second),
              IsOk());  // stands for what was exported: newer than its matte
  fs::remove(first);
  ASSERT_THAT(export_layers(options), IsOkAnd(2));
  EXPECT_THAT(load_png(first), IsOkAnd(testing::Field(&Image::width, 160))) << "was missing";
  EXPECT_THAT(load_png(second), IsOkAnd(testing::Field(&Image::width, 1))) << "was there";
  ASSERT_THAT(save_png(Image(160, 120, 1), TakeLayout(take).matte("cam01", 1)), IsOk());
  fs::last_write_time(TakeLayout(take).matte("cam01", 1),
                      fs::last_write_time(second) + std::chrono::seconds(1));
  ASSERT_THAT(export_layers(options), IsOkAnd(2));
  EXPECT_THAT(load_png(second), IsOkAnd(testing::Field(&Image::width, 160))) << "its matte is newer";
  options.format = "png16";
  ASSERT_THAT(export_layers(options), IsOkAnd(2));
  EXPECT_EQ((*read_file(first))[24], 16) << "another format under the same name";
}

TEST(ExportLayers, AskForMattesFirst) {
  TempFolder folder;
  const ExportOptions options{
      .take = small_take(folder, 1), .out = folder / "layers", .format = "png8", .cameras = {}, .threads = 1};
  EXPECT_THAT(export_layers(options), FailsWith(ErrorCode::NotFound, "floatstage matte"));
}

}  // namespace
}  // namespace floatstage::pipeline
