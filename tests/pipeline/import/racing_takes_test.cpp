// Two runs that want one name for their takes.

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "capture/take.h"
#include "capture/take_check.h"
#include "core/log.h"
#include "core/png.h"
#include "pipeline/import/import.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/child_process.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

enum Outcome { kWon = 0, kRefused = 5, kFailed = 9 };
enum class Maker { Recorder, Importer };

int outcome_of(const Error& error) {
  if (error.code == ErrorCode::AlreadyExists) return kRefused;
  log::error(error.message);
  return kFailed;
}

Frame as_frame(const Image& picture, std::uint64_t sequence) {
  FrameInfo info;
  info.camera = 0;
  info.sequence = sequence;
  info.exposure_start = Timestamp{} + Nanoseconds{40'000'000 * static_cast<std::int64_t>(sequence)};
  return make_frame(info, picture);
}

int record(const fs::path& out) {
  auto writer = capture::TakeWriter::create(out, test_rig(1), {});
  if (!writer) return outcome_of(writer.error());
  for (std::uint64_t i = 0; i < 3; ++i)
    if (const auto ok = (*writer)->write(as_frame(test_picture(0, static_cast<int>(i)), i)); !ok)
      return outcome_of(ok.error());
  if (const auto ok = (*writer)->finish(); !ok) return outcome_of(ok.error());
  const auto sealed = capture::seal_take(out, [](std::uint64_t) { return true; });
  return sealed ? kWon : outcome_of(sealed.error());
}

int import(const fs::path& pictures, const fs::path& out) {
  ImportOptions options;
  options.calibration = {"middlebury", pictures};
  options.out = out;
  options.threads = 1;
  const Result<ImportReport> report = import_take(options);
  return report ? kWon : outcome_of(report.error());
}

void expect_one_winner(const TempFolder& folder, Maker first, Maker second, int delay_us) {
  const fs::path out = folder / "take";
  const auto start = [&](Maker maker, int wait_us) {
    return std::make_unique<ChildProcess>([&folder, out, maker, wait_us](const auto&) {
      log::set_level(log::Level::Error);
      std::this_thread::sleep_for(std::chrono::microseconds(wait_us));
      return maker == Maker::Recorder ? record(out) : import(folder / "in", out);
    });
  };
  const auto a = start(first, 0), b = start(second, delay_us);
  const int ended_a = a->wait(), ended_b = b->wait();
  EXPECT_EQ(std::min(ended_a, ended_b), kWon) << "delay " << delay_us << " us";
  EXPECT_EQ(std::max(ended_a, ended_b), kRefused) << "delay " << delay_us << " us";
  // Threads of ours would not survive the next fork: a child looks at what came out.
  ChildProcess look([&](const auto&) {
    const auto check = capture::check_take(out, [](std::uint64_t) { return true; });
    return check && check->sealed && check->problems.empty() ? 0 : 1;
  });
  EXPECT_EQ(look.wait(), 0) << "the winner's bytes";
  EXPECT_EQ(fs::exists(folder / ".take.tmp"), false);
  fs::remove_all(out);
}

TEST(TakesRacingForOneName, HaveOneWinnerWhoseBytesAreIntact) {
  const TempFolder folder;
  fs::create_directories(folder / "in");
  for (int i = 0; i < 2; ++i)
    ASSERT_THAT(save_png(test_picture(i, 0), folder / "in" / (i ? "b.png" : "a.png")), IsOk());
  ASSERT_THAT(calib::write_middlebury(test_rig(2), {"a.png", "b.png"}, folder / "in" / "x_par.txt"), IsOk());
  const int pairs = wants_long_tests() ? 1000 : 120;
  for (int i = 0; i < pairs && !testing::Test::HasFailure(); ++i) {
    const Maker first = i % 2 ? Maker::Importer : Maker::Recorder,
                second = i % 4 < 2 ? Maker::Importer : Maker::Recorder;
    expect_one_winner(folder, first, second, i % 37 * i % 41 * 100);
  }
}

}  // namespace
}  // namespace floatstage::pipeline
