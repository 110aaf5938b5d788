#include "capture/take_check.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sha256.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/log.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

bool to_the_end(std::uint64_t) { return true; }

class RecordedTake : public testing::TestWithParam<TakeCodec> {
 protected:
  void SetUp() override { log::set_level(log::Level::Error); }
  void TearDown() override { log::set_level(log::Level::Info); }
  void record(TakeCodec codec = TakeCodec::Ffv1) const { record_small_take(take_, 2, 6, codec, 2); }
  TakeManifest manifest() const {
    return parse_manifest(*read_file(take_ / "take.json"), "take.json").value();
  }
  TakeCheck check() const { return check_take(take_, to_the_end).value(); }

  TempFolder folder_;
  const fs::path take_ = folder_ / "take";
};

TEST_F(RecordedTake, IsSealedWithTheHashOfEveryFile) {
  record();
  EXPECT_THAT(manifest().files, IsEmpty());
  ASSERT_THAT(seal_take(take_, to_the_end), IsOk());
  const TakeManifest sealed = manifest();
  ASSERT_THAT(sealed.files, SizeIs(4)) << "two media files, two side files";
  for (const TakeManifest::File& file : sealed.files) {
    const std::string bytes = *read_file(take_ / file.name);
    EXPECT_EQ(file.bytes, bytes.size());
    EXPECT_EQ(file.sha256, sha256(bytes));
  }
  EXPECT_TRUE(check().sealed);
  EXPECT_THAT(check().problems, IsEmpty());
}

TEST_F(RecordedTake, WithoutASealIsDecoded) {
  record();
  const TakeCheck seen = check();
  EXPECT_FALSE(seen.sealed);
  EXPECT_EQ(seen.pictures, 11) << "six of each camera, and one gap";
  EXPECT_THAT(seen.problems, IsEmpty());
  EXPECT_THAT(seen.remarks, ElementsAre(HasSubstr("is not sealed")));
}

TEST_F(RecordedTake, ThatWasCutOffIsNotSealed) {
  auto writer = TakeWriter::create(take_, small_rig(1, 32, 24), {});
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->write(patterned_frame(PixelFormat::Rgb8, 32, 24, 0, 0)), IsOk());
  writer->reset();
  EXPECT_THAT(seal_take(take_, to_the_end), FailsWith(ErrorCode::InvalidArgument, "cut off"));
  EXPECT_THAT(check().problems, IsEmpty()) << "a cut is no damage";
}

TEST_F(RecordedTake, IsAsItWasWhenSealingIsInterrupted) {
  record();
  const std::string before = *read_file(take_ / "take.json");
  EXPECT_THAT(seal_take(take_, [](std::uint64_t) { return false; }), FailsWith(ErrorCode::Cancelled, ""));
  EXPECT_EQ(*read_file(take_ / "take.json"), before);
}

TEST_F(RecordedTake, WithoutOneOfItsFilesSaysWhich) {
  record();
  ASSERT_THAT(seal_take(take_, to_the_end), IsOk());
  fs::remove(take_ / "cam1.mkv");
  EXPECT_THAT(check().problems, Contains(HasSubstr("cam1.mkv is missing")));
}

// What the codec's own checksums cannot find: H.264 decodes whatever it is given, raw pictures are any bytes.
TEST_P(RecordedTake, KnowsEveryFlippedBitOfItsFiles) {
  record(GetParam());
  ASSERT_THAT(seal_take(take_, to_the_end), IsOk());
  const std::vector<TakeManifest::File> files = manifest().files;
  std::mt19937 random(7);
  for (int i = 0; i < 150; ++i) {
    const TakeManifest::File& file = files[random() % files.size()];
    std::string bytes = *read_file(take_ / file.name);
    const std::size_t bit = random() % (8 * bytes.size());
    const std::string before = bytes;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    ASSERT_THAT(write_file(take_ / file.name, bytes), IsOk());
    EXPECT_THAT(check().problems, Contains(HasSubstr(file.name))) << "bit " << bit << " of " << file.name;
    ASSERT_THAT(write_file(take_ / file.name, before), IsOk());
  }
  EXPECT_THAT(check().problems, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(AllCodecs, RecordedTake,
                         testing::Values(TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264),
                         [](const auto& codec) {
                           return std::string(codec.param == TakeCodec::Ffv1  ? "Ffv1"
                                              : codec.param == TakeCodec::Raw ? "Raw"
                                                                              : "H264");
                         });

class EditedSideFile : public RecordedTake {
 protected:
  void put(const std::string& csv) const { ASSERT_THAT(write_file(side_file_, csv), IsOk()); }
  std::string csv() const { return *read_file(side_file_); }
  std::vector<std::string> said() const {
    const auto take = TakeReader::open(take_);
    return take ? (*take)->warnings() : std::vector<std::string>{take.error().message};
  }
  const fs::path side_file_ = take_ / "cam1.frames.csv";
};

TEST_F(EditedSideFile, ThatIsEmptyIsSaidThoughNothingElseIsMissing) {
  record();
  put(frames_csv_header());
  EXPECT_THAT(said(), Contains(HasSubstr("has no row with a picture, but cam1.mkv is there")));
  put("");
  EXPECT_THAT(said(), Contains(HasSubstr("has no row with a picture")));
}

TEST_F(EditedSideFile, ThatIsCutInALineIsSaid) {
  record();
  put(csv().substr(0, csv().size() - 3));
  EXPECT_THAT(said(), Contains(HasSubstr("is cut in its last line")));
}

TEST_F(EditedSideFile, WhoseTimesRunBackwardIsSaid) {
  record();
  std::string rows = csv();
  put(rows + "900,,1,,lost,\n");
  EXPECT_THAT(said(), Contains(HasSubstr("lies before that of the row above it")));
}

TEST_F(EditedSideFile, WhoseNumbersRepeatIsSaid) {
  record();
  put(csv() + "0,,900000000000,,lost,\n");
  EXPECT_THAT(said(), Contains(HasSubstr("does not follow")));
}

TEST_F(EditedSideFile, AsItWasRecordedSaysNothing) {
  record();
  EXPECT_THAT(said(), IsEmpty());
}

}  // namespace
}  // namespace floatstage::capture
