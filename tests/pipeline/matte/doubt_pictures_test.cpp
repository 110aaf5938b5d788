#include "pipeline/matte/doubt_pictures.h"

#include <algorithm>
#include <set>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

const auto kNone = [](const std::string&, const DoubtPicture&) { return false; };

Image grey(std::uint8_t level) {
  Image picture(8, 6, 1);
  std::fill(picture.pixels.begin(), picture.pixels.end(), level);
  return picture;
}

class PicturesOfDoubts : public testing::Test {
 protected:
  DoubtPictures pictures() const { return DoubtPictures(folder()); }
  fs::path folder() const { return doubts_folder(TakeLayout(folder_.path())); }
  void put(const std::string& name, const std::string& of, int frame) const {
    ASSERT_THAT(pictures().put(name, {.of = of, .why = "why", .cameras = {"a"}, .frame = frame}, grey(90)),
                IsOk());
  }
  std::set<std::string> there() const {
    std::set<std::string> names;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder(), none))
      if (entry.path().extension() == ".png") names.insert(entry.path().filename());
    return names;
  }

  TempFolder folder_;
};

TEST_F(PicturesOfDoubts, GoWhenTheirDoubtNoLongerHolds) {
  put("a-1.png", "mattes", 1);
  put("a-2.png", "mattes", 2);
  put("denied-1.png", "hull", 1);
  ASSERT_THAT(
      pictures().keep("mattes", [](const std::string&, const DoubtPicture& p) { return p.frame == 2; }),
      IsOk());
  EXPECT_THAT(there(), ElementsAre("a-2.png", "denied-1.png"));
  ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  ASSERT_THAT(pictures().keep("hull", kNone), IsOk());
  EXPECT_FALSE(fs::exists(folder())) << "an empty folder says that there are doubts";
}

TEST_F(PicturesOfDoubts, ThatSomebodyPutThereStay) {
  put("a-1.png", "mattes", 1);
  put("a-2.png", "mattes", 2);
  ASSERT_THAT(save_png(grey(30), folder() / "a-1.png"), IsOk());  // painted over
  ASSERT_THAT(save_png(grey(90), folder() / "mine.png"), IsOk());
  ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  EXPECT_THAT(there(), ElementsAre("a-1.png", "mine.png"));
}

TEST_F(PicturesOfDoubts, AreNotLookedForBehindLinks) {
  put("a-1.png", "mattes", 1);
  fs::rename(folder() / "a-1.png", folder_ / "elsewhere.png");
  fs::create_symlink(folder_ / "elsewhere.png", folder() / "a-1.png");
  ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  EXPECT_TRUE(fs::exists(folder_ / "elsewhere.png"));
  EXPECT_THAT(there(), ElementsAre("a-1.png"));

  fs::remove(folder() / "a-1.png");
  put("a-2.png", "mattes", 2);
  fs::rename(folder(), folder_ / "moved");
  fs::create_directory_symlink(folder_ / "moved", folder());
  ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  EXPECT_TRUE(fs::exists(folder_ / "moved" / "a-2.png"));
}

TEST_F(PicturesOfDoubts, OfARecordThatLeadsElsewhereOrIsCutOffStay) {
  put("a-1.png", "mattes", 1);
  const std::string record = *read_file(folder() / "made.json");
  ASSERT_THAT(save_png(grey(90), folder_ / "mattes" / "up.png"), IsOk());
  std::string other = record;
  other.replace(other.find("a-1.png"), 7, "../up.png");
  ASSERT_THAT(write_file(folder() / "made.json", other), IsOk());
  ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  EXPECT_TRUE(fs::exists(folder_ / "mattes" / "up.png"));
  for (std::size_t length = 0; length + 2 < record.size(); length += 7) {
    ASSERT_THAT(write_file(folder() / "made.json", record.substr(0, length)), IsOk());
    ASSERT_THAT(pictures().keep("mattes", kNone), IsOk());
  }
  EXPECT_THAT(there(), ElementsAre("a-1.png"));
}

MatteTakeOptions given(const fs::path& take) { return {.take = take, .how = "given"}; }

std::vector<std::string> listed(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
    if (entry.path().extension() == ".png") names.push_back(entry.path().filename());
  return names;
}

// Mattes in a corner deny one another; then somebody gives better ones.
TEST(PicturesOfDeniedMattes, GoWithTheContradiction) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  const fs::path pictures = doubts_folder(TakeLayout(take));
  const auto give = [&](bool pushed) {
    const auto reader = *capture::TakeReader::open(take);
    for (std::size_t i = 0; i < reader->rig().cameras.size(); ++i) {
      const std::string& serial = reader->rig().cameras[i].serial;
      Image matte = *load_png(TakeLayout(take / "truth").matte(serial, 0));
      if (pushed && i < 3) {
        std::fill(matte.pixels.begin(), matte.pixels.end(), std::uint8_t{0});
        for (int y = 0; y < matte.height / 6; ++y)
          std::fill_n(matte.at(0, y), matte.width / 6, std::uint8_t{255});
      }
      fs::create_directories(TakeLayout(take).matte(serial, 0).parent_path());
      ASSERT_THAT(save_png(matte, TakeLayout(take).matte(serial, 0)), IsOk());
    }
  };
  give(true);
  const Result<MatteReport> wrong = matte_take(given(take));
  ASSERT_THAT(wrong, IsOk());
  ASSERT_EQ(wrong->doubts.size(), 1u);
  EXPECT_THAT(listed(pictures), ElementsAre("denied-0.png"));
  give(false);
  const Result<MatteReport> right = matte_take(given(take));
  ASSERT_THAT(right, IsOk());
  EXPECT_THAT(right->doubts, IsEmpty());
  EXPECT_THAT(listed(pictures), IsEmpty());
}

}  // namespace
}  // namespace floatstage::pipeline
