// What a job in a confined child makes, and what is left when it is taken over, fails or is stopped.

#include "pipeline/confined_outputs.h"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/claim.h"
#include "core/file.h"
#include "core/working_on.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

class OutputsOfAChild : public testing::Test {
 protected:
  using Job = std::function<Result<void>(const PlaceOf&, Progress*)>;
  Result<void> make(const Job& job, Progress* progress = nullptr, const fs::path& kept = {}) {
    return make_confined({.what = "photos", .outputs = {picture_, tiles_, {}}, .kept = kept}, progress, job);
  }
  std::string said_in(const fs::path& file) const {
    const Result<std::string> bytes = read_file(file);
    return bytes ? *bytes : bytes.error().message;
  }

  const TempFolder folder_;
  const fs::path picture_ = folder_ / "zoom.png", tiles_ = folder_ / "zoom_files";
};

TEST_F(OutputsOfAChild, GetTheirNamesOnceAllIsMade) {
  folder_.write("zoom.png", "old");
  fs::create_directory(tiles_);
  folder_.write("zoom_files/0", "old");
  folder_.write("zoom_files/other", "stays");
  EXPECT_THAT(make([&](const PlaceOf& place, Progress*) -> Result<void> {
                EXPECT_EQ(place({}), fs::path());
                EXPECT_NE(place(picture_), picture_);
                if (Result<void> ok = make_folder(place(tiles_) / "1"); !ok) return ok;
                if (Result<void> ok = write_file(place(tiles_) / "1/a", "a"); !ok) return ok;
                if (Result<void> ok = write_file(place(tiles_) / "0", "new"); !ok) return ok;
                FLOATSTAGE_CHECK(said_in(picture_) == "old", "it has its name too early");
                return write_file(place(picture_), "new");
              }),
              IsOk());
  EXPECT_EQ(said_in(picture_), "new");
  EXPECT_EQ(said_in(tiles_ / "0"), "new");
  EXPECT_EQ(said_in(tiles_ / "1/a"), "a");
  EXPECT_EQ(said_in(tiles_ / "other"), "stays");
  EXPECT_THAT(folder_.names(), ElementsAre("zoom.png", "zoom_files"));
}

TEST_F(OutputsOfAChild, ThatFailsOrCrashesAreNotThere) {
  EXPECT_THAT(make([&](const PlaceOf& place, Progress*) -> Result<void> {
                if (Result<void> ok = write_file(place(picture_), "half"); !ok) return ok;
                return fail(ErrorCode::NotFound, "no photograph");
              }),
              FailsWith(ErrorCode::NotFound, "no photograph"));
  EXPECT_THAT(folder_.names(), IsEmpty());
  if (kSanitized) return;
  EXPECT_THAT(make([&](const PlaceOf& place, Progress*) -> Result<void> {
                if (Result<void> ok = write_file(place(picture_), "half"); !ok) return ok;
                const WorkingOn here("wide.jpg");
                std::abort();
              }),
              FailsWith(ErrorCode::BadData, "wide.jpg: what decodes it crashed"));
  EXPECT_THAT(folder_.names(), IsEmpty());
}

TEST_F(OutputsOfAChild, AreAllThatStaysOfWhatItMade) {
  EXPECT_THAT(make([&](const PlaceOf& place, Progress*) -> Result<void> {
                const fs::path staged = place(picture_).parent_path();
                if (Result<void> ok = write_file(staged / ".bashrc", "exec"); !ok) return ok;
                FLOATSTAGE_CHECK(!write_file(picture_, "past its place"), "it wrote beside its folder");
                return write_file(place(picture_), "a picture");
              }),
              IsOk());
  EXPECT_THAT(folder_.names(), ElementsAre("zoom.png"));
  EXPECT_EQ(said_in(picture_), "a picture");
}

// The child cannot make one; a job that others have touched could.
TEST_F(OutputsOfAChild, AreNoLinks) {
  const fs::path secret = folder_.write("secret", "own");
  const fs::path staged = temporary_name(picture_);
  std::atomic<bool> over = false;
  std::thread meddler([&] {  // once the child is at work: what lay there before is cleared away
    std::error_code error;
    while (!over && !fs::exists(staged / "at work", error)) std::this_thread::yield();
    fs::create_symlink(secret, staged / "zoom.png", error);
  });
  EXPECT_THAT(make([&](const PlaceOf& place, Progress*) -> Result<void> {
                if (Result<void> ok = write_file(staged / "at work", ""); !ok) return ok;
                while (!fs::is_symlink(place(picture_))) std::this_thread::yield();
                return {};
              }),
              FailsWith(ErrorCode::BadData, "zoom.png: what was made for it is no file"));
  over = true;
  meddler.join();
  EXPECT_THAT(folder_.names(), ElementsAre("secret"));
}

TEST_F(OutputsOfAChild, AreNamedInItsErrorsAsTheUserKnowsThem) {
  const Result<void> made =
      make([&](const PlaceOf& place, Progress*) { return write_file(place(tiles_) / "nowhere/a", "a"); });
  EXPECT_THAT(made, FailsWith(ErrorCode::NotFound, (tiles_ / "nowhere/a").string()));
  EXPECT_EQ(made.error().message.find(".tmp"), std::string::npos);
  EXPECT_THAT(make_confined({.what = "x", .outputs = {folder_ / "gone/zoom.png"}}, nullptr,
                            [](const PlaceOf&, Progress*) { return Result<void>(); }),
              FailsWith(ErrorCode::NotFound, "gone/zoom.png"));
  EXPECT_FALSE(fs::exists(folder_ / "gone"));
}

TEST_F(OutputsOfAChild, HaveOneMakerAtATime) {
  const Result<Claim> others = claim_temporary_folder(picture_, IfThere::Replace);
  ASSERT_THAT(others, IsOk());
  EXPECT_THAT(make([](const PlaceOf&, Progress*) { return Result<void>(); }),
              FailsWith(ErrorCode::AlreadyExists, "zoom.png is being written by another run"));
}

/// Ctrl-C once the first item is done.
class Interrupted final : public Progress {
 public:
  void begin(const std::string&, std::size_t) override {}
  void advance(std::size_t) override { done_ = true; }
  void end() override {}
  bool cancelled() const override { return done_; }

 private:
  std::atomic<bool> done_ = false;
};

TEST_F(OutputsOfAChild, AreNotThereAfterCtrlC) {
  const auto begin = std::chrono::steady_clock::now();
  Interrupted progress;
  EXPECT_THAT(make(
                  [&](const PlaceOf& place, Progress* told) -> Result<void> {
                    ProgressPart part(told, "photographs", 2);
                    if (Result<void> ok = write_file(place(picture_), "half"); !ok) return ok;
                    part.advance();
                    for (;;) ::pause();
                  },
                  &progress),
              FailsWith(ErrorCode::Cancelled, "nothing was written"));
  EXPECT_THAT(folder_.names(), IsEmpty());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST_F(OutputsOfAChild, LeaveACacheThatEndsInOrderAfterCtrlC) {
  const fs::path cache = folder_ / "cache";
  Interrupted progress;
  EXPECT_THAT(make(
                  [&](const PlaceOf&, Progress* told) -> Result<void> {
                    ProgressPart part(told, "photographs", 2);
                    part.advance();
                    while (!told->cancelled()) std::this_thread::yield();
                    if (Result<void> ok = write_file(cache / "pairs", "so far"); !ok) return ok;
                    return fail(ErrorCode::Cancelled, "interrupted; the rest is in the cache");
                  },
                  &progress, cache),
              FailsWith(ErrorCode::Cancelled, "the rest is in the cache"));
  EXPECT_THAT(folder_.names(), ElementsAre("cache"));
  EXPECT_EQ(said_in(cache / "pairs"), "so far");
}

TEST_F(OutputsOfAChild, LeaveNoEmptyCache) {
  EXPECT_THAT(make([](const PlaceOf&, Progress*) { return fail(ErrorCode::NotFound, "no photographs"); },
                   nullptr, folder_ / "cache"),
              FailsWith(ErrorCode::NotFound, "no photographs"));
  EXPECT_THAT(folder_.names(), IsEmpty());
}

}  // namespace
}  // namespace floatstage::pipeline
