// The experiments that need no data, small.
#include "pipeline/reproduce/reproduce.h"

#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "core/synthetic/mesh_photograph.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/reproduce/ball_before_wall.h"
#include "pipeline/reproduce/experiment.h"
#include "render/gl_context.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

json read(const fs::path& file) { return json::parse(*read_file(file)); }

class Reproduce : public testing::Test {
 protected:
  Result<ReproduceReport> run() const { return reproduce(options_); }

  TempFolder folder_;
  ReproduceOptions options_{
      .out = folder_ / "out", .data = {}, .only = {"fig58"}, .small = true, .back_end = render::BackEnd::Cpu};
};

TEST_F(Reproduce, WritesATableASheetAndTheReport) {
  const Result<ReproduceReport> report = run();
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->made, ElementsAre("fig58"));
  const json table = read(options_.out / "fig58/table.json");
  EXPECT_EQ(table.at("rows").size(), 6u) << "linear with two, floating with four";
  EXPECT_EQ(read(options_.out / "report.json").at("fig58"), table);
  const Result<Image> sheet = load_png(options_.out / "fig58/sheet.png");
  ASSERT_THAT(sheet, IsOk());
  EXPECT_GT(sheet->width, 1000);
  EXPECT_THAT(*read_file(options_.out / "report.md"), HasSubstr("fig58/sheet.png"));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(options_.out))
    EXPECT_FALSE(is_temporary(entry.path())) << entry.path();
}

TEST_F(Reproduce, ShowsThatFilledAndSoftVisibilityAreWorthTheirWork) {
  ASSERT_THAT(run(), IsOk());
  std::map<std::string, double> hidden;
  const json table = read(options_.out / "fig58/table.json");
  for (const json& row : table.at("rows"))
    hidden[row.at("method").get<std::string>() + " " + row.at("visibility").get<std::string>() + " " +
           row.at("occluded").get<std::string>()] = row.at("psnr_hidden");
  EXPECT_GT(hidden.at("floating soft filled"), hidden.at("floating soft not filled"));
  EXPECT_GT(hidden.at("floating binary filled"), hidden.at("floating binary not filled"));
  EXPECT_GT(hidden.at("floating soft filled"), hidden.at("linear soft –"));
}

TEST_F(Reproduce, KeepsWhatIsDone) {
  ASSERT_THAT(run(), IsOk());
  const fs::path file = options_.out / "fig58/table.csv";
  ASSERT_THAT(write_file(file, "kept"), IsOk());
  const Result<ReproduceReport> again = run();
  ASSERT_THAT(again, IsOk());
  EXPECT_THAT(again->made, IsEmpty());
  EXPECT_THAT(again->kept, ElementsAre("fig58"));
  EXPECT_EQ(*read_file(file), "kept");
  options_.redo = true;
  ASSERT_THAT(run(), IsOk());
  EXPECT_THAT(*read_file(file), HasSubstr("psnr_hidden"));
}

TEST_F(Reproduce, DoesNotMixWhatWasMadeOtherwise) {
  ASSERT_THAT(run(), IsOk());
  options_.small = false;
  EXPECT_THAT(run(), FailsWith(ErrorCode::AlreadyExists, "--redo"));
}

TEST_F(Reproduce, TouchesNothingThatNoExperimentMade) {
  fs::create_directories(options_.out / "fig58");
  folder_.write("out/fig58/letter.txt", "dear");
  for (const bool redo : {false, true}) {
    options_.redo = redo;
    EXPECT_THAT(run(), FailsWith(ErrorCode::AlreadyExists, "letter.txt"));
  }
  fs::remove(options_.out / "fig58/letter.txt");
  folder_.write("out/fig58/table.json", "{\"rows\": []");
  options_.redo = false;
  EXPECT_THAT(run(), FailsWith(ErrorCode::BadData, "table.json"));
}

TEST_F(Reproduce, SaysByNameWhatIsLeftOutWithoutData) {
  options_.only = {"fig52", "fig58"};
  EXPECT_THAT(run(), FailsWith(ErrorCode::NotFound, "fig52 cannot be made: it needs the set stanford-bunny"));
  EXPECT_FALSE(fs::exists(options_.out)) << "before anything is written";
  options_.data = folder_ / "sets";
  EXPECT_THAT(run(), FailsWith(ErrorCode::NotFound, "no such folder"));
  fs::create_directories(options_.data);
  EXPECT_THAT(run(), FailsWith(ErrorCode::NotFound, "stanford-bunny is not there"));
}

TEST_F(Reproduce, RefusesWhatItDoesNotKnow) {
  options_.only = {"fig99"};
  EXPECT_THAT(run(), FailsWith(ErrorCode::InvalidArgument, "fig99"));
  options_.out.clear();
  EXPECT_THAT(run(), FailsWith(ErrorCode::InvalidArgument, "--out"));
}

// Cancels when so many pictures have been drawn.
class Impatient final : public Progress {
 public:
  explicit Impatient(int pictures) : left_(pictures) {}
  void begin(const std::string&, std::size_t) override {}
  void advance(std::size_t items) override { left_ -= static_cast<int>(items); }
  void end() override {}
  bool cancelled() const override { return left_ <= 0; }

 private:
  int left_;
};

TEST_F(Reproduce, EndsBetweenTwoPicturesAndKeepsWhatWasDone) {
  Impatient impatient(3);
  options_.progress = &impatient;
  EXPECT_THAT(run(), FailsWith(ErrorCode::Cancelled, ""));
  EXPECT_FALSE(fs::exists(options_.out / "fig58"));
  EXPECT_TRUE(read(options_.out / "report.json").contains("left_out"));
  options_.progress = nullptr;
  ASSERT_THAT(run(), IsOk());
  Impatient at_once(0);
  options_.progress = &at_once;
  options_.only = {"fig58", "fig61/hull"};
  EXPECT_THAT(run(), FailsWith(ErrorCode::Cancelled, ""));
  EXPECT_TRUE(fs::exists(options_.out / "fig58/sheet.png"));
}

TEST(Experiments, HaveNamesOfTheirOwn) {
  const std::vector<std::string> names = experiment_names();
  EXPECT_THAT(names, testing::IsSupersetOf({"fig52", "fig53", "fig58", "fig61", "fig61/hull", "sweeps"}));
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_THAT(compared_methods(true), testing::Contains("light-field"));
}

// Of the values of two pictures, how many are more than 12 steps apart.
double share_apart(const Image& a, const Image& b) {
  double apart = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) apart += std::abs(a.pixels[i] - b.pixels[i]) > 12;
  return apart / static_cast<double>(a.pixels.size());
}

TEST(FillHidden, DrawsTheSameOnBothBackEnds) {
  const Result<std::unique_ptr<render::GlContext>> context = render::GlContext::headless();
  ASSERT_THAT(context, IsOk());
  const TestScene scene = ball_before_wall({.width = 200, .height = 150, .views = 1});
  std::map<bool, Image> on_cpu;
  for (const bool fill : {true, false}) {
    Image pictures[2];
    for (const bool gl : {false, true}) {
      render::RendererOptions options;
      options.fill_hidden = fill;
      options.back_end = gl ? render::BackEnd::Gl : render::BackEnd::Cpu;
      const auto views = compare(scene, {.methods = {"floating"}, .renderer = options, .ghosting = false});
      ASSERT_THAT(views, IsOk());
      pictures[gl] = views->front().rendered.at("floating");
    }
    // A flow that is led astray makes more of the last step in which the back-ends' images differ.
    EXPECT_GT(psnr(pictures[0], pictures[1], Image(200, 150, 1, 255)), fill ? 40 : 33) << fill;
    EXPECT_LT(share_apart(pictures[0], pictures[1]), 0.05) << fill;
    on_cpu[fill] = pictures[0];
  }
  EXPECT_LT(psnr(on_cpu[true], on_cpu[false], Image(200, 150, 1, 255)), 45) << "it makes a difference";
}

}  // namespace
}  // namespace floatstage::pipeline
