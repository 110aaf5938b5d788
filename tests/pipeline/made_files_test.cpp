#include "pipeline/made_files.h"

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "pipeline/matte_record.h"
#include "tests/support/child_process.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

TEST(HashOf, IsTheSha256OfTheBytesAndNothingWithoutAFile) {
  TempFolder folder;
  folder.write("abc", "abc");
  EXPECT_THAT(hash_of(folder / "abc"),
              IsOkAnd(std::optional<std::string>(
                  "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad")));
  EXPECT_THAT(hash_of(folder / "none"), IsOkAnd(std::optional<std::string>()));
}

TEST(AJournal, HoldsWholeLinesWhateverHappensToTheLast) {
  TempFolder folder;
  Journal journal(folder / "j.log");
  EXPECT_THAT(read_journal(folder / "j.log"), IsEmpty());
  ASSERT_THAT(journal.add({{"frame", 1}}), IsOk());
  ASSERT_THAT(journal.add({{"frame", 2}}), IsOk());
  const std::string whole = *read_file(folder / "j.log");
  EXPECT_THAT(read_journal(folder / "j.log"), SizeIs(2));
  folder.write("j.log", whole.substr(0, whole.size() - 3));
  EXPECT_THAT(read_journal(folder / "j.log"), SizeIs(1));
  journal.remove();
  EXPECT_THAT(read_journal(folder / "j.log"), IsEmpty());
}

TEST(AJournal, SaysThatTheDiskIsFull) {
  TempFolder folder;
  ChildProcess child([&](const std::function<void()>&) {
    let_files_grow_to(20);
    Journal journal(folder / "j.log");
    if (!journal.add({{"frame", 1}})) return 1;
    const Result<void> second = journal.add({{"frame", 22222}});
    return !second && second.error().code == ErrorCode::Io ? 0 : 2;
  });
  EXPECT_EQ(child.wait(), 0);
  EXPECT_THAT(read_journal(folder / "j.log"), SizeIs(1));
}

CameraRecord record() {
  return {.how = "luminance:30",
          .method = "key",
          .key = "luminance:30",
          .guide = "/a/folder",
          .inputs = std::string(64, '1'),
          .edits = {{{2, {{MatteLabel::Foreground, 1.5, {{0.1, 60}}}}}},
                    {{MatteLabel::Background, {{2, 2}}, 1, 3, 2.25}}},
          .files = {{0, std::string(64, 'a')}, {12, std::string(64, 'b')}},
          .stale = {12}};
}

TEST(TheMatteRecord, ComesBackAsItWas) {
  TempFolder folder;
  const TakeLayout layout(folder.path());
  EXPECT_THAT(load_matte_record(layout), IsOkAnd(IsEmpty()));
  ASSERT_THAT(make_folder(layout.mattes()), IsOk());
  MatteRecord all = {{"left", record()}};
  all["right"].how = "given";
  ASSERT_THAT(save_matte_record(all, layout), IsOk());
  EXPECT_THAT(load_matte_record(layout), IsOkAnd(all));
}

TEST(TheMatteRecord, TakesFromTheJournalWhatLiesInItsPlace) {
  TempFolder folder;
  const TakeLayout layout(folder.path());
  ASSERT_THAT(make_folder(layout.mattes() / "left"), IsOk());
  ASSERT_THAT(save_matte_record({{"left", record()}}, layout), IsOk());
  ASSERT_THAT(write_file(layout.matte("left", 12), "new"), IsOk());
  Journal journal(layout.mattes_journal());
  const std::string hash = **hash_of(layout.matte("left", 12));
  ASSERT_THAT(journal.add({{"camera", "left"}, {"frame", 12}, {"sha256", hash}}), IsOk());
  ASSERT_THAT(journal.add({{"camera", "left"}, {"frame", 0}, {"sha256", hash}}), IsOk());
  const Result<MatteRecord> back = load_matte_record(layout);
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->at("left").files.at(12), hash);
  EXPECT_THAT(back->at("left").stale, IsEmpty()) << "it is made";
  EXPECT_EQ(back->at("left").files.at(0), std::string(64, 'a')) << "killed before it was put there";
}

TEST(TheMatteRecord, IsRefusedByNameWhenItIsDamaged) {
  TempFolder folder;
  const TakeLayout layout(folder.path());
  ASSERT_THAT(make_folder(layout.mattes()), IsOk());
  ASSERT_THAT(save_matte_record({{"left", record()}}, layout), IsOk());
  const std::string whole = *read_file(layout.made_mattes());
  for (std::size_t length = 0; length + 2 < whole.size(); length += 7) {
    ASSERT_THAT(write_file(layout.made_mattes(), whole.substr(0, length)), IsOk());
    EXPECT_THAT(load_matte_record(layout), FailsWith(ErrorCode::BadData, "made.json")) << length;
  }
  ASSERT_THAT(write_file(layout.made_mattes(), R"({"floatstage_mattes": 2, "cameras": {}})"), IsOk());
  EXPECT_THAT(load_matte_record(layout), FailsWith(ErrorCode::Unsupported, "made.json"));
}

}  // namespace
}  // namespace floatstage::pipeline
