// Every format that `import` reads, by the program itself: on a set as the format's own documentation, or
// another program, writes it, and broken in every way that it can be. The table that it prints stands in
// docs/calibration-formats.md.
#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/pipeline/import/foreign_sets.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d, Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kLeastAgreement = 1e-3;  // px

const std::vector<Vector3d> kPoints = {
    {0.1, 0.2, 3}, {-0.3, 0.1, 2.5}, {0.5, -0.4, 4}, {0.2, 0.3, 2.8}, {0, 0, 3.3}};

class FormatTable : public testing::TestWithParam<std::size_t> {
 protected:
  const Format& format() const { return foreign_sets()[GetParam()]; }
  fs::path in() const { return folder_ / "in"; }

  void begin() {
    fs::remove_all(in());
    format().write(in());
  }

  Ended import(const Words& more = {}) {
    std::string command = text(FLOATSTAGE_PROGRAM, " import ", format().name, " '", in().string(), "' -o '",
                               (folder_ / "out").string(), "'");
    for (const Words& words : {format().more, more})
      for (const std::string& word : words) command += " " + word;
    return run_command(command);
  }

  /// The set as it is now is refused, by a sentence that has these words, and nothing is left. The exit
  /// status.
  int refused(const std::string& what, int code, const Words& words, const Words& more = {}) {
    const Ended ended = import(more);
    EXPECT_EQ(ended.code, code) << format().name << ", " << what << ": " << ended.output;
    for (const std::string& word : words)
      EXPECT_THAT(ended.output, HasSubstr(word)) << format().name << ", " << what;
    EXPECT_EQ(folder_.names(), std::vector<std::string>{"in"}) << format().name << ", " << what;
    return ended.code;
  }

  /// "6", or "–" where the format has no such thing.
  std::string changed(const char* what, const std::optional<Change>& change) {
    if (!change) return "–";
    begin();
    if (change->do_it) {
      change->do_it(in());
    } else {
      std::string content = *read_file(in() / change->file);
      const std::size_t at = content.find(change->from);
      EXPECT_NE(at, std::string::npos) << format().name << " writes no '" << change->from << "'";
      if (at != std::string::npos)
        put(in() / change->file, content.replace(at, change->from.size(), change->to));
    }
    return text(refused(what, change->code, {fs::path(change->file).filename().string(), change->words}));
  }

  const TempFolder folder_;
};

TEST_P(FormatTable, ReadsAForeignSetAndRefusesABrokenOne) {
  begin();
  const Ended ended = import();
  ASSERT_EQ(ended.code, 0) << format().name << ": " << ended.output;
  EXPECT_THAT(ended.output, HasSubstr(": 1 frames of ")) << "a view's other pictures are no film";
  Result<Rig> rig = load_rig(folder_ / "out/rig.json");
  ASSERT_THAT(rig, IsOk());
  ASSERT_GE(rig->cameras.size(), 2u);
  std::sort(rig->cameras.begin(), rig->cameras.end(),
            [](const RigCamera& a, const RigCamera& b) { return a.serial < b.serial; });
  double worst = 0;
  for (int i = 0; i < 2; ++i)
    for (const Vector3d& point : kPoints) {
      const Vector3d p = format().name == "lightfield" ? Vector3d(point.x(), point.z(), -point.y()) : point;
      const RigCamera& c = i == 0 ? rig->cameras.front() : rig->cameras.back();
      const Vector2d wanted = format().seen ? format().seen(i, p) : by_opencv(i, p, format().lens);
      const auto seen = project(c.model, c.cam_from_world * p);
      ASSERT_TRUE(seen.has_value());
      worst = std::max(worst, (*seen - wanted).norm());
    }
  EXPECT_LT(worst, kLeastAgreement) << format().name;
  fs::remove_all(folder_ / "out");

  int cut = 0;
  for (const std::string& file : format().files) {
    begin();
    std::string content = *read_file(in() / file);
    put(in() / file, content.substr(0, content.size() * 3 / 4));
    cut = refused(file + " is cut off", kBadData, {fs::path(file).filename().string()});
  }
  begin();
  for (const std::string& picture : format().pictures) fs::remove(in() / picture);
  const int missing = refused("no pictures", format().without_pictures, {in().string()});
  begin();
  refused("no scale", kInvalidArgument, {"--scale"}, {"--scale", "0"});

  const std::string version = changed("another version", format().version),
                    model = changed("an unknown lens", format().model),
                    zero = changed("no focal length", format().zero);
  const std::string row = text("| `", format().name, "` | ", format().written_by, " | ",
                               worst < kLeastAgreement ? "< 1e-3" : "no", " | ", cut, " | ", version, " | ",
                               missing, " | ", model, " | ", zero, " |");
  std::printf("%s   (%.1e px)\n", row.c_str(), worst);
  EXPECT_NE(read_file(source_folder() / "docs/calibration-formats.md")->find(row), std::string::npos)
      << "docs/calibration-formats.md has another row for " << format().name;
}

INSTANTIATE_TEST_SUITE_P(OfEveryFormat, FormatTable, testing::Range<std::size_t>(0, foreign_sets().size()),
                         [](const auto& format) { return foreign_sets()[format.param].name; });

TEST(FormatTable, HasARowForEveryFormat) {
  std::set<std::string> there, tested;
  for (const calib::RigFormat& format : calib::rig_formats()) there.emplace(format.name);
  for (const Format& format : foreign_sets()) tested.insert(format.name);
  EXPECT_EQ(tested, there);
}

// Videos in the place of pictures, made by ffmpeg: their sound, and one that is announced and has no sample.
TEST(FormatTable, ReadsVideosAndRefusesAnEmptySoundTrack) {
  const TempFolder folder;
  put(folder / "in/x_par.txt", middlebury());
  const auto film = [&](const char* name, const char* sound, const char* coded) {
    const Ended made = run_command(
        text("ffmpeg -nostdin -y -v error -f lavfi -i testsrc=size=64x48:rate=25:duration=1 ", sound,
             " -c:v libx264 -pix_fmt yuv420p ", coded, " '", (folder / "in" / name).string(), "'"));
    ASSERT_EQ(made.code, 0) << made.output;
  };
  film("a.mp4", "-f lavfi -i sine=r=48000:d=1", "-c:a aac");
  film("b.mp4", "-f lavfi -i anullsrc=r=48000:d=1 -filter:a 'aselect=0'", "-c:a pcm_s16le -f matroska");
  const std::string command = text(FLOATSTAGE_PROGRAM, " import middlebury '", (folder / "in").string(),
                                   "' -o '", (folder / "out").string(), "'");
  const Ended refused = run_command(command);
  EXPECT_EQ(refused.code, kBadData) << refused.output;
  EXPECT_THAT(refused.output, testing::AllOf(HasSubstr("b.mp4"), HasSubstr("--no-sound")));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"in"});
  const Ended silent = run_command(command + " --no-sound");
  EXPECT_EQ(silent.code, 0) << silent.output;
}

// docs/exporting.md says which program reads what leaves, and which test shows it.
TEST(FormatTable, OfExportsHasARowForEveryVerbAndATestForEveryRow) {
  const std::string docs = *read_file(source_folder() / "docs/exporting.md");
  const std::string table = docs.substr(docs.find("## What reads it back"));
  std::istringstream help(run_command(FLOATSTAGE_PROGRAM " export --help").output);
  std::string line;
  while (std::getline(help, line) && line != "Verbs:") continue;
  int verbs = 0;
  for (; std::getline(help, line) && line.starts_with("  "); ++verbs) {
    const std::string verb = line.substr(2, line.find(' ', 2) - 2);
    EXPECT_NE(table.find("| `export " + verb + "`"), std::string::npos) << verb;
  }
  EXPECT_GE(verbs, 5);

  std::string tests;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(source_folder() / "tests"))
    if (file.path().extension() == ".cpp") tests += *read_file(file.path());
  std::istringstream rows(table);
  int named = 0;
  while (std::getline(rows, line)) {
    if (!line.starts_with("| `")) continue;
    const std::size_t end = line.rfind('`'), begin = line.rfind('`', end - 1) + 1,
                      dot = line.find('.', begin);
    const std::string suite = line.substr(begin, dot - begin), name = line.substr(dot + 1, end - dot - 1);
    EXPECT_NE(tests.find("(" + suite + ", " + name + ")"), std::string::npos) << suite << "." << name;
    ++named;
  }
  EXPECT_GE(named, 12);
}

}  // namespace
}  // namespace floatstage
