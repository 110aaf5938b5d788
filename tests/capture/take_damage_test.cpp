// Takes that were damaged, renamed or edited after they were recorded.

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sha256.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/log.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class DamagedTake : public testing::Test {
 protected:
  void SetUp() override { log::set_level(log::Level::Error); }  // thousands of deserved warnings
  void TearDown() override { log::set_level(log::Level::Info); }

  void record(TakeCodec codec = TakeCodec::Ffv1) { record_small_take(take_, 2, 8, codec); }

  fs::path file(const char* name) const { return take_ / name; }
  std::string bytes(const char* name) const { return read_file(file(name)).value(); }
  void put(const char* name, std::string_view content) const {
    ASSERT_THAT(write_file(file(name), content), IsOk());
  }
  void replace(const char* name, const std::string& old_text, const std::string& new_text) const {
    std::string content = bytes(name);
    const std::size_t at = content.find(old_text);
    ASSERT_NE(at, std::string::npos) << old_text << " in " << name;
    put(name, content.replace(at, old_text.size(), new_text));
  }

  /// Rewrites the rig and the manifest so that their checksum agrees: only what the change says is wrong.
  void rewrite(const std::function<void(TakeManifest&, Rig&)>& change) const {
    Rig rig = load_rig(file("rig.json")).value();
    TakeManifest manifest = parse_manifest(bytes("take.json"), "take.json").value();
    change(manifest, rig);
    put("rig.json", to_json(rig));
    manifest.rig_sha256 = sha256(bytes("rig.json"));
    put("take.json", to_json(manifest));
  }

  Result<std::unique_ptr<TakeReader>> open() const { return TakeReader::open(take_); }

  TempFolder folder_;
  const fs::path take_ = folder_ / "take";
};

TEST_F(DamagedTake, IsNoneWithoutAManifest) {
  EXPECT_THAT(open(), FailsWith(ErrorCode::NotFound, "is no take"));
  record();
  fs::remove(file("take.json"));
  EXPECT_THAT(open(), FailsWith(ErrorCode::NotFound, "is no take"));
}

TEST_F(DamagedTake, NamesAManifestThatMakesNoSense) {
  record();
  put("take.json", "{ not json");
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "take.json"));
}

TEST_F(DamagedTake, NamesAMissingMediaFile) {
  record();
  fs::rename(file("cam1.mkv"), file("renamed.mkv"));
  EXPECT_THAT(open(), FailsWith(ErrorCode::NotFound, "cam1.mkv is missing"));
}

TEST_F(DamagedTake, SeesThatMediaFilesWereExchanged) {
  record();
  fs::rename(file("cam0.mkv"), file("other"));
  fs::rename(file("cam1.mkv"), file("cam0.mkv"));
  fs::rename(file("other"), file("cam1.mkv"));
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "cam0.mkv: this file was recorded by camera 'cam1'"));
}

TEST_F(DamagedTake, NamesAMediaFileThatIsNone) {
  record();
  put("cam1.mkv", "this is no video at all");
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "cam1.mkv: the header"));
}

TEST_F(DamagedTake, NamesAMissingRig) {
  record();
  fs::remove(file("rig.json"));
  EXPECT_THAT(open(), FailsWith(ErrorCode::NotFound, "rig.json"));
}

TEST_F(DamagedTake, SeesThatTheRigWasChanged) {
  record();
  Rig rig = load_rig(file("rig.json")).value();
  rig.cameras[0].model.fx += 1e-9;
  put("rig.json", to_json(rig));
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "rig.json: not the file that was recorded"));
}

TEST_F(DamagedTake, RefusesACalibrationThatIsNotANumber) {
  record();
  replace("rig.json", "\"fx\":", "\"fx\": NaN, \"old\":");
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "rig.json"));
}

TEST_F(DamagedTake, NamesACameraThatTheRigDoesNotHave) {
  record();
  rewrite([](TakeManifest&, Rig& rig) { rig.cameras.pop_back(); });
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "camera 'cam1' of take.json is missing in this rig"));
}

TEST_F(DamagedTake, NamesACameraThatOnlyTheRigHas) {
  record();
  rewrite([](TakeManifest& manifest, Rig&) { manifest.cameras.pop_back(); });
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "camera 'cam1' is not number 1 of take.json"));
}

TEST_F(DamagedTake, RefusesSizesThatDisagree) {
  record();
  rewrite([](TakeManifest&, Rig& rig) { rig.cameras[1].model.width = 64; });
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "rig.json: camera 'cam1' is 64x24 here but 32x24"));
  rewrite([](TakeManifest& manifest, Rig&) { manifest.cameras[1].width = 64; });
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "cam1.mkv: pictures of 32x24, but take.json says 64x24"));
}

TEST_F(DamagedTake, RefusesACodecThatIsNotTheMediaFiles) {
  record();
  rewrite([](TakeManifest& manifest, Rig&) { manifest.cameras[0].codec = "h264"; });
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "cam0.mkv: coded as ffv1, but take.json says h264"));
  rewrite([](TakeManifest& manifest, Rig&) { manifest.cameras[0].codec = "mystery"; });
  EXPECT_THAT(open(), FailsWith(ErrorCode::Unsupported, "mystery"));
}

TEST_F(DamagedTake, DoesNotMistakeOneFormatForAnother) {
  record();
  rewrite([](TakeManifest& manifest, Rig&) { manifest.cameras[0].format = PixelFormat::Gray8; });
  auto reader = open();
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->frame(0, 0)->info.status, FrameStatus::Corrupt);
}

TEST_F(DamagedTake, NamesAMissingSideFile) {
  record();
  fs::remove(file("cam0.frames.csv"));
  EXPECT_THAT(open(), FailsWith(ErrorCode::NotFound, "cam0.frames.csv"));
}

TEST_F(DamagedTake, NamesTheLineOfASideFileThatMakesNoSense) {
  record();
  replace("cam0.frames.csv", "\n3,", "\nthree,");
  EXPECT_THAT(open(), FailsWith(ErrorCode::BadData, "cam0.frames.csv: line 5"));
}

TEST_F(DamagedTake, RefusesPicturesOutOfOrder) {
  record();
  replace("cam0.frames.csv", "ok,5\n", "ok,2\n");
  EXPECT_THAT(open(),
              FailsWith(ErrorCode::BadData, "cam0.frames.csv: row 5: media index 2 does not follow 4"));
}

TEST_F(DamagedTake, PlaysFewerRowsThanPicturesByTheSideFile) {
  record();
  std::string csv = bytes("cam0.frames.csv");
  csv.resize(csv.find("\n6,") + 1);
  put("cam0.frames.csv", csv);
  auto reader = open();
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->rows(0).size(), 6u);
  EXPECT_THAT((*reader)->warnings(), Contains(HasSubstr("has 2 pictures more than")));
  EXPECT_EQ((*reader)->frame(0, 7)->info.status, FrameStatus::Lost);
  EXPECT_TRUE(same_pixels((*reader)->frame(0, 5).value(), patterned_frame(PixelFormat::Rgb8, 32, 24, 0, 5)));
}

TEST_F(DamagedTake, PlaysFewerPicturesThanRowsUpToTheCut) {
  record();
  fs::resize_file(file("cam0.mkv"), fs::file_size(file("cam0.mkv")) / 2);
  auto reader = open();
  ASSERT_THAT(reader, IsOk());
  const std::size_t rows = (*reader)->rows(0).size();
  EXPECT_GT(rows, 1u);
  EXPECT_LT(rows, 8u);
  EXPECT_THAT((*reader)->warnings(), Contains(HasSubstr("cam0.mkv ends after")));
  for (int k = 0; k < static_cast<int>(rows); ++k)
    EXPECT_TRUE(same_pixels((*reader)->frame(0, k).value(),
                            patterned_frame(PixelFormat::Rgb8, 32, 24, 0, static_cast<std::uint64_t>(k))));
  EXPECT_EQ((*reader)->frame_count(), 8) << "camera 1 is whole";
  EXPECT_EQ((*reader)->frame(0, 7)->info.status, FrameStatus::Lost);
}

TEST_F(DamagedTake, OpensOrSaysWhyAtEveryLengthOfEveryFile) {
  for (const TakeCodec codec : {TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264}) {
    record(codec);
    for (const char* name : {"take.json", "rig.json", "cam0.frames.csv", "cam0.mkv"}) {
      const std::string whole = bytes(name);
      const std::size_t step = std::max<std::size_t>(1, whole.size() / 60);
      for (std::size_t length = 0; length < whole.size(); length += step) {
        put(name, std::string_view(whole).substr(0, length));
        auto reader = open();
        if (!reader) {
          EXPECT_THAT(reader.error().message, HasSubstr(name));
          continue;
        }
        for (int k = 0; k < (*reader)->frame_count(); ++k) {
          const Result<Frame> frame = (*reader)->frame(0, k);
          ASSERT_THAT(frame, IsOk()) << name << " of " << length << " bytes";
          if (!frame->empty() && codec != TakeCodec::H264) {
            EXPECT_TRUE(same_pixels(
                *frame, patterned_frame(PixelFormat::Rgb8, 32, 24, 0, static_cast<std::uint64_t>(k))));
          }
        }
      }
      put(name, whole);
    }
    fs::remove_all(take_);
  }
}

TEST_F(DamagedTake, NeverPassesDamagedPixelsOffAsGood) {
  record();
  const std::string whole = bytes("cam0.mkv");
  int corrupt = 0;
  for (std::size_t at = whole.size() / 4; at < 3 * whole.size() / 4; at += 101) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    put("cam0.mkv", damaged);
    auto reader = open();
    if (!reader) continue;
    for (int k = 0; k < static_cast<int>((*reader)->rows(0).size()); ++k) {
      const Result<Frame> frame = (*reader)->frame(0, k);
      ASSERT_THAT(frame, IsOk());
      if (frame->info.status == FrameStatus::Corrupt) {
        EXPECT_TRUE(frame->empty());
        ++corrupt;
      } else {
        EXPECT_TRUE(
            same_pixels(*frame, patterned_frame(PixelFormat::Rgb8, 32, 24, 0, static_cast<std::uint64_t>(k))))
            << at;
      }
    }
  }
  EXPECT_GT(corrupt, 10);
}

TEST_F(DamagedTake, ReadsTheSamePastADamagedPictureInAnyOrder) {
  record(TakeCodec::H264);
  std::string media = bytes("cam0.mkv");
  media[media.size() / 2] = static_cast<char>(media[media.size() / 2] ^ 0x55);
  put("cam0.mkv", media);
  auto forwards = open(), backwards = open();
  ASSERT_THAT(forwards, IsOk());
  ASSERT_THAT(backwards, IsOk());
  const int count = static_cast<int>((*forwards)->rows(0).size());
  std::vector<Frame> first;
  for (int k = 0; k < count; ++k) first.push_back((*forwards)->frame(0, k).value());
  for (int k = count - 1; k >= 0; --k)
    EXPECT_TRUE(same_pixels((*backwards)->frame(0, k).value(), first[static_cast<std::size_t>(k)])) << k;
}

TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace floatstage::capture
