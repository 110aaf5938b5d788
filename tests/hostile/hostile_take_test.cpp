// Takes that somebody prepared: each file of a take replaced by each kind of trap, then the program's verbs
// on it. Whatever they say, they end: by no signal, with no check of our own failed, soon, and in little
// memory.

#include <vector>

#include <gtest/gtest.h>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/camera_path.h"
#include "pipeline/process/process.h"
#include "tests/hostile/hostile_run.h"
#include "tests/hostile/traps.h"
#include "tests/support/matchers.h"
#include "tests/support/small_take.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

/// A take with everything that a take can hold.
class HostileTake : public testing::TestWithParam<const char*> {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const fs::path take = small_take(*folder_);
    pipeline::ProcessOptions options;
    options.take = take;
    options.matte = "chroma";
    ASSERT_THAT(pipeline::process_take(options), IsOk());
    const pipeline::PathKey a{.time = 0, .eye = {3, 0, 1}, .target = {0, 0, 1}, .fov_y = 40},
        b{.time = 0.1, .eye = {2.9, 0.3, 1}, .target = {0, 0, 1}, .fov_y = 40};
    ASSERT_THAT(pipeline::save_path({{a, b}}, take / "path.json"), IsOk());
    folder_->write("take/mattes/edits.json", to_json(MatteEdits{{{"cam00", CameraEdits()}}}));
    fs::copy(take / "rig.json", take / "colors.json");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static TempFolder* folder_;
};

TempFolder* HostileTake::folder_ = nullptr;

TEST_P(HostileTake, EndsEveryVerbInOrder) {
  const fs::path take = *folder_ / "take", victim = *folder_ / "victim", film = *folder_ / "film.mp4";
  const Result<std::string> was = read_file(take / GetParam());
  ASSERT_THAT(was, IsOk());
  for (const Trap& trap : traps()) {
    for (const std::vector<std::string>& words : {std::vector<std::string>{"take", "info", victim},
                                                  {"take", "verify", victim},
                                                  {"process", victim, "--matte", "chroma"},
                                                  {"render", victim, "--path", victim / "path.json", "--size",
                                                   "64x48", "--method", "linear", "-o", film}}) {
      fs::remove_all(victim);
      fs::remove(film);
      fs::copy(take, victim, fs::copy_options::recursive);
      trap.set(victim / GetParam(), *was);
      std::vector<std::string> command = {FLOATSTAGE_PROGRAM};
      command.insert(command.end(), words.begin(), words.end());
      expect_orderly(command, text(GetParam(), " is ", trap.name, ": ", words[0], ' ', words[1]));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFile, HostileTake,
                         testing::Values("take.json", "rig.json", "cam00.mkv", "cam00.frames.csv",
                                         "colors.json", "plates/cam00.png", "path.json", "mattes/made.json",
                                         "mattes/edits.json", "mattes/cam00/000000.png", "meshes/hull.json",
                                         "meshes/000000.ply"),
                         [](const auto& file) {
                           std::string name = file.param;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace floatstage
