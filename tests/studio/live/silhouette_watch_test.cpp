#include "studio/live/silhouette_watch.h"

#include <algorithm>
#include <chrono>

#include <gmock/gmock.h>

#include "recon/outline.h"
#include "tests/studio/synthetic_shots.h"

namespace floatstage::studio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class SilhouettesOfAStudio : public testing::Test {
 protected:
  SilhouettesOfAStudio() {
    for (int c = 0; c < kCameras; ++c) {
      SyntheticShot shot = shots_.studio.shoot(c, 0);
      mattes_.push_back(to_image(shot.matte));
      photographs_.push_back(shot.frame);
    }
  }

  std::vector<Silhouette> outlines() const {
    std::vector<Silhouette> all;
    for (int c = 0; c < kCameras; ++c) {
      const auto i = static_cast<std::size_t>(c);
      all.push_back(recon::outline_of(make_matte({}, mattes_[i]), shots_.rig.cameras[i].model));
    }
    return all;
  }

  // Nothing is subject in these rows of a camera's picture, by shares of its height.
  void lose(int camera, double from, double to) {
    Image& m = mattes_[static_cast<std::size_t>(camera)];
    for (int y = static_cast<int>(from * m.height); y < static_cast<int>(to * m.height); ++y)
      std::fill_n(m.at(0, y), m.width, std::uint8_t{0});
  }

  std::vector<SilhouetteFinding> found() { return SilhouetteFindings(shots_.rig, "chroma").of(outlines()); }

  static constexpr int kCameras = 8;
  SyntheticShots shots_{kCameras};
  std::vector<Image> mattes_;
  std::vector<Frame> photographs_;
};

TEST_F(SilhouettesOfAStudio, ThatAreRightFitTogether) { EXPECT_THAT(found(), IsEmpty()); }

TEST_F(SilhouettesOfAStudio, NameTheCameraThatLacksAPart) {
  lose(2, 0.5, 1);
  const std::vector<SilhouetteFinding> all = found();
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_THAT(all[0].cameras, ElementsAre(2));
  EXPECT_THAT(all[0].sentence, HasSubstr("camera 'cam02' lacks"));
}

TEST_F(SilhouettesOfAStudio, NameTheCameraThatShowsTooMuch) {
  for (int y = 20; y < 90; ++y) std::fill_n(mattes_[5].at(10, y), 50, std::uint8_t{255});
  const std::vector<SilhouetteFinding> all = found();
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_THAT(all[0].cameras, ElementsAre(5));
  EXPECT_THAT(all[0].sentence, HasSubstr("camera 'cam05' shows"));
}

// As where the performer wears the cloth's colour: who is at fault cannot be told.
TEST_F(SilhouettesOfAStudio, ContradictOneAnotherWhereEachLacksAnotherPart) {
  for (int c = 0; c < kCameras; ++c) lose(c, 0.3 + 0.05 * c, 0.34 + 0.05 * c);
  const std::vector<SilhouetteFinding> all = found();
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_GE(all[0].cameras.size(), 4U);
  EXPECT_THAT(all[0].sentence, HasSubstr("does the performer wear the cloth's colour?"));
}

TEST_F(SilhouettesOfAStudio, ShowTheCamerasThatAreNamed) {
  lose(2, 0.5, 1);
  SilhouetteFindings findings(shots_.rig, "");
  ASSERT_THAT(findings.of(outlines()), SizeIs(1));
  std::vector<Image> rgb(kCameras);
  EXPECT_TRUE(findings.picture({2}, rgb).empty()) << "without photographs";
  rgb[2] = *to_rgb(photographs_[2]);
  const Image picture = findings.picture({2}, rgb);
  EXPECT_EQ(picture.width, 320);
  EXPECT_EQ(picture.height, 240);
}

/// A watch that is shown instants one by one.
class ASilhouetteWatch : public SilhouettesOfAStudio {
 protected:
  void show(int instants) {
    for (int k = 0; k < instants; ++k) {
      const std::uint64_t before = watch_.judged();
      while (!watch_.offer(outlines(), photographs_)) std::this_thread::yield();
      while (watch_.judged() == before) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  SilhouetteWatch watch_{shots_.rig, "", milliseconds(0)};
};

TEST_F(ASilhouetteWatch, SaysWhatItSawTwiceAndNoLongerWhatItMissedTwice) {
  show(2);
  EXPECT_EQ(watch_.news()->remark(), "");
  const std::vector<Image> right = mattes_;
  lose(2, 0.5, 1);
  show(1);
  EXPECT_EQ(watch_.news()->remark(), "");
  show(1);
  ASSERT_THAT(watch_.news()->doubts, SizeIs(1));
  EXPECT_THAT(watch_.news()->cameras, ElementsAre("cam02"));
  EXPECT_THAT(watch_.news()->remark(), HasSubstr("camera 'cam02' lacks"));
  show(1);
  EXPECT_FALSE(watch_.news()->picture.empty()) << "of an instant after it was said";
  mattes_ = right;
  show(1);
  EXPECT_THAT(watch_.news()->doubts, SizeIs(1));
  show(1);
  EXPECT_EQ(watch_.news()->remark(), "");
}

TEST_F(ASilhouetteWatch, SaysNothingOfWhatPasses) {
  const std::vector<Image> right = mattes_;
  for (int k = 0; k < 3; ++k) {
    lose(2, 0.5, 1);
    show(1);
    mattes_ = right;
    show(1);
    EXPECT_EQ(watch_.news()->remark(), "");
  }
}

}  // namespace
}  // namespace floatstage::studio
