#include "pipeline/calibrate/session_patterns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::Eq;
using testing::HasSubstr;

class Patterns : public testing::Test {
 protected:
  void have(std::initializer_list<const char*> names) {
    for (const char* name : names) {
      ASSERT_THAT(make_folder((folder_ / name).parent_path()), IsOk());
      folder_.write(name, "picture");
    }
  }
  Result<Session> load(const std::string& cameras) {
    return load_session(
        folder_.write("s.toml", "target = \"chessboard columns=8 rows=5 square=30mm\"\n" + cameras));
  }
  static std::vector<std::string> serials(const Session& s) {
    std::vector<std::string> out;
    for (const SessionCamera& c : s.cameras) out.push_back(c.serial);
    return out;
  }
  std::vector<std::string> names(const std::vector<std::filesystem::path>& paths) const {
    std::vector<std::string> out;
    for (const auto& p : paths) out.push_back(p.lexically_relative(folder_.path()).string());
    return out;
  }
  TempFolder folder_;
};

TEST(Fit, TakesAsFewCharactersForTheSerialAsFit) {
  EXPECT_THAT(fit("{serial}_*.png", "left_01_02.png"), Eq("left"));
  EXPECT_THAT(fit("cam{serial}.mp4", "cam12.mp4"), Eq("12"));
  EXPECT_THAT(fit("{serial}/{serial}_?.png", "a/a_1.png"), Eq("a"));
  EXPECT_THAT(fit("{serial}/{serial}_?.png", "a/b_1.png"), Eq(std::nullopt));
  EXPECT_THAT(fit("a?c*", "abcdef"), Eq(""));
  EXPECT_THAT(fit("a?c", "ac"), Eq(std::nullopt));
  EXPECT_THAT(fit("{serial}.png", "a b.png"), Eq(std::nullopt)) << "no serial has a space";
}

TEST(Fit, OfManyStarsEnds) {
  EXPECT_THAT(fit("*a*a*a*a*a*a*a*a*a*a*b", std::string(200, 'a')), Eq(std::nullopt));
}

TEST_F(Patterns, SeveralCamerasInOneFolderAreToldApartByTheirNames) {
  have({"p/left_2.png", "p/left_10.png", "p/right_2.png", "p/right_10.png", "p/.left_3.png"});
  const Result<Session> s = load("[[cameras]]\nimages = \"p/{serial}_*.png\"\nlens = \"none\"\n");
  ASSERT_THAT(s, IsOk());
  EXPECT_THAT(serials(*s), ElementsAre("left", "right"));
  EXPECT_THAT(names(s->cameras[0].images), ElementsAre("p/left_2.png", "p/left_10.png")) << "natural order";
  EXPECT_EQ(s->cameras[1].lens, calib::LensKind::None);
}

TEST_F(Patterns, VideosAndFoldersOfManyCamerasNeedOneTable) {
  have({"take1/c1.mp4", "take1/c2.mp4", "alone/c1/a.png", "alone/c1/b.png", "alone/c2/a.png"});
  const Result<Session> s = load("[[cameras]]\nvideo = \"take1/{serial}.mp4\"\nalone = \"alone/{serial}\"\n");
  ASSERT_THAT(s, IsOk());
  EXPECT_THAT(serials(*s), ElementsAre("c1", "c2"));
  EXPECT_EQ(s->cameras[1].video, folder_ / "take1/c2.mp4");
  EXPECT_THAT(names(s->cameras[1].alone), ElementsAre("alone/c2"));
}

TEST_F(Patterns, StarsChooseFilesOfOneCamera) {
  have({"a/x1.png", "a/x2.png", "a/y1.png", "b[1]*.png"});
  const Result<Session> s = load("[[cameras]]\nserial = \"x\"\nimages = [\"a/x?.png\", \"b[1]*.png\"]\n");
  ASSERT_THAT(s, IsOk());
  EXPECT_THAT(names(s->cameras[0].images), ElementsAre("a/x1.png", "a/x2.png", "b[1]*.png"))
      << "what is there as it is written is no pattern";
}

TEST_F(Patterns, ThatNothingFitsAreNamed) {
  have({"a/x1.png"});
  EXPECT_THAT(load("[[cameras]]\nimages = \"a/{serial}_*.jpg\"\n"),
              FailsWith(ErrorCode::NotFound, "a/{serial}_*.jpg"));
  EXPECT_THAT(load("[[cameras]]\nserial = \"x\"\nimages = \"a/z*\"\n"),
              FailsWith(ErrorCode::NotFound, "camera 'x': nothing fits the pattern"));
}

TEST_F(Patterns, TwoVideosOfOneCameraAreRefused) {
  have({"a/x1.mp4", "a/x2.mp4"});
  EXPECT_THAT(load("[[cameras]]\nvideo = \"a/{serial}?.mp4\"\n"), FailsWith(ErrorCode::BadData, "both"));
  EXPECT_THAT(load("[[cameras]]\nserial = \"x\"\nvideo = \"a/x*.mp4\"\n"),
              FailsWith(ErrorCode::BadData, "it has one"));
}

TEST_F(Patterns, ACameraHasASerialOrTheWordForIt) {
  EXPECT_THAT(load("[[cameras]]\nimages = \"a/*.png\"\n"), FailsWith(ErrorCode::BadData, "{serial}"));
  EXPECT_THAT(load("[[cameras]]\nserial = \"x\"\nimages = \"a/{serial}.png\"\n"),
              FailsWith(ErrorCode::BadData, "stands for cameras without a 'serial'"));
  have({"x.mp4"});
  EXPECT_THAT(load("[[cameras]]\nserial = \"x\"\nvideo = \"x.mp4\"\n[[cameras]]\nvideo = \"{serial}.mp4\"\n"),
              FailsWith(ErrorCode::BadData, "camera 'x' stands there twice"));
}

}  // namespace
}  // namespace floatstage::pipeline
