#include "core/take_layout.h"

#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(TakeLayout, NamesFramesWithSixDigits) {
  const TakeLayout take("t");
  EXPECT_EQ(take.matte("left", 12), "t/mattes/left/000012.png");
  EXPECT_EQ(take.mesh(1234567), "t/meshes/1234567.ply");
  EXPECT_EQ(take.truth().mesh(0), "t/truth/meshes/000000.ply");
  EXPECT_EQ(take.frames_csv("left"), "t/left.frames.csv");
  EXPECT_EQ(take.plate("left"), "t/plates/left.png");
}

TEST(TakeLayout, FindsTheFramesThatLieThereByTheirNames) {
  const TempFolder folder;
  const TakeLayout take(folder.path());
  EXPECT_THAT(take.frames_with_meshes(), IsEmpty()) << "no folder";
  ASSERT_TRUE(make_folder(take.meshes()));
  ASSERT_TRUE(make_folder(take.matte("left", 8).parent_path()));
  for (const char* name : {"000012.ply", "000003.ply", "1234567.ply", "3.ply", "000004.png", "-00005.ply",
                           "000006.ply.tmp", "hull.json", "0000007.ply"})
    ASSERT_TRUE(write_file(take.meshes() / name, "mesh"));
  EXPECT_THAT(take.frames_with_meshes(), ElementsAre(3, 12, 1234567));
  ASSERT_TRUE(write_file(take.matte("left", 8), "matte"));
  EXPECT_THAT(take.frames_with_mattes("left"), ElementsAre(8));
  EXPECT_THAT(take.frames_with_mattes("right"), IsEmpty());
}

TakeManifest manifest() {
  return {.version = 1,
          .label = "Probe \"eins\"",
          .created = "2026-11-20T10:00:00Z",
          .writer = "floatstage 0.1.0",
          .frame_rate = 29.97,
          .rig_sha256 = std::string(64, 'a'),
          .complete = true,
          .cameras = {{"left", "left.mkv", "ffv1", PixelFormat::Nv12, 640, 480},
                      {"right", "right.mkv", "raw", PixelFormat::BayerRggb8, 0, 0}},
          .files = {{"left.mkv", 81'204'113, std::string(64, 'b')},
                    {"left.frames.csv", 0, std::string(64, 'c')}}};
}

TEST(TakeManifest, ComesBackAsItWas) {
  const Result<TakeManifest> back = parse_manifest(to_json(manifest()), "take.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(*back, manifest());
}

TEST(TakeManifest, KeepsALabelThatIsNotUtf8Readable) {
  TakeManifest m = manifest();
  m.label = "caf\xe9";
  EXPECT_THAT(parse_manifest(to_json(m), "take.json"),
              IsOkAnd(testing::Field(&TakeManifest::label, "caf\xEF\xBF\xBD")));
}

TEST(TakeManifest, CutOffAnywhereIsRefused) {
  const std::string whole = to_json(manifest());
  for (std::size_t length = 0; length + 2 < whole.size(); ++length)
    EXPECT_THAT(parse_manifest(std::string_view(whole).substr(0, length), "take.json"),
                FailsWith(ErrorCode::BadData, "take.json"))
        << length;
}

struct Damage {
  const char* from;
  const char* to;
  const char* complaint;
};

class DamagedManifest : public testing::TestWithParam<Damage> {};

TEST_P(DamagedManifest, IsRefusedWithASentence) {
  std::string json = to_json(manifest());
  const std::size_t at = json.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  json.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const auto parsed = parse_manifest(json, "take.json");
  EXPECT_THAT(parsed, FailsWith(ErrorCode::BadData, "take.json"));
  EXPECT_THAT(parsed, FailsWith(ErrorCode::BadData, GetParam().complaint));
}

INSTANTIATE_TEST_SUITE_P(
    Damages, DamagedManifest,
    testing::Values(Damage{"\"left.mkv\"", "\"../left.mkv\"", "not the name of a file inside the take"},
                    Damage{"\"left.mkv\"", "\"..\"", "not the name of a file inside the take"},
                    Damage{"\"right.mkv\"", "\"left.mkv\"", "listed twice"},
                    Damage{"\"right\"", "\"left\"", "listed twice"},
                    Damage{"\"left\"", "\"le/ft\"", "cannot be a camera serial"},
                    Damage{"\"nv12\"", "\"nv99\"", "unknown pixel format 'nv99'"},
                    Damage{"29.97", "-1", "'frame_rate' is negative"},
                    Damage{"aaaa", "AAAA", "'rig_sha256' is not 64"},
                    Damage{"aaaa", "", "'rig_sha256' is not 64"},
                    Damage{"true", "1", "'complete' is neither true nor false"},
                    Damage{"\"label\"", "\"lable\"", "'label' is missing"},
                    Damage{"640", "-640", "is negative"}));

TEST(TakeManifest, OfALaterFormatIsUnsupported) {
  TakeManifest m = manifest();
  m.version = 2;
  EXPECT_THAT(parse_manifest(to_json(m), "take.json"), FailsWith(ErrorCode::Unsupported, "take format 2"));
}

TEST(TakeManifest, WithoutCamerasIsRefused) {
  TakeManifest m = manifest();
  m.cameras.clear();
  EXPECT_THAT(parse_manifest(to_json(m), "take.json"), FailsWith(ErrorCode::BadData, "no camera"));
}

FrameRow full_row() {
  return {.info = {.camera = 3,
                   .sequence = 18446744073709551615u,
                   .exposure_start = {-5},
                   .exposure = Nanoseconds{8'000'000},
                   .device_time = Nanoseconds{9'000'000'000'000'000'001},
                   .status = FrameStatus::Corrupt},
          .media_index = 0};
}

FrameRow gap_row() {
  FrameRow row;
  row.info = {.camera = 3,
              .sequence = 1,
              .exposure_start = {40'000'000},
              .exposure = {},
              .device_time = {},
              .status = FrameStatus::Lost};
  return row;
}

TEST(FramesCsv, BringsRowsBackWithAbsentValuesAbsent) {
  const std::string csv = frames_csv_header() + to_csv(full_row()) + to_csv(gap_row());
  EXPECT_THAT(parse_frames_csv(csv, 3, "left.frames.csv"), IsOkAnd(ElementsAre(full_row(), gap_row())));
}

TEST(FramesCsv, WritesAbsentValuesAsEmptyFields) { EXPECT_EQ(to_csv(gap_row()), "1,,40000000,,lost,\n"); }

TEST(FramesCsv, IgnoresALastLineThatWasCutOff) {
  const std::string one = frames_csv_header() + to_csv(full_row()), two = one + to_csv(gap_row());
  for (std::size_t length = one.size(); length < two.size(); ++length)
    EXPECT_THAT(parse_frames_csv(std::string_view(two).substr(0, length), 3, "x"),
                IsOkAnd(ElementsAre(full_row())))
        << length;
}

TEST(FramesCsv, CutOffInTheHeaderHasNoRows) {
  const std::string header = frames_csv_header();
  for (std::size_t length = 0; length <= header.size(); ++length)
    EXPECT_THAT(parse_frames_csv(std::string_view(header).substr(0, length), 0, "x"),
                IsOkAnd(testing::IsEmpty()))
        << length;
}

class DamagedFramesCsv : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(DamagedFramesCsv, NamesTheLine) {
  const std::string csv = frames_csv_header() + to_csv(gap_row()) + GetParam().first + "\n";
  const auto rows = parse_frames_csv(csv, 0, "left.frames.csv");
  EXPECT_THAT(rows, FailsWith(ErrorCode::BadData, "left.frames.csv: line 3"));
  EXPECT_THAT(rows, FailsWith(ErrorCode::BadData, GetParam().second));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, DamagedFramesCsv,
    testing::Values(std::pair{"", "not 6 fields"}, std::pair{"1,,2,,ok,0,", "not 6 fields"},
                    std::pair{"-1,,2,,ok,0", "the sequence"}, std::pair{"1,,,,ok,0", "the studio time"},
                    std::pair{"1,x,2,,ok,0", "the device time"}, std::pair{"1,,2,0.5,ok,0", "the exposure"},
                    std::pair{"1,,2,,fine,0", "unknown status 'fine'"},
                    std::pair{"1,,2,,ok,-1", "the media index"},
                    std::pair{"1,,99999999999999999999,,ok,0", "the studio time"},
                    std::pair{"1,,2,,lost,0", "a lost frame has a picture"}));

TEST(FramesCsv, OfAnotherKindIsRefusedAtItsFirstLine) {
  EXPECT_THAT(parse_frames_csv("time,frame\n1,2\n", 0, "x.csv"),
              FailsWith(ErrorCode::BadData, "x.csv: line 1"));
}

}  // namespace
}  // namespace floatstage
