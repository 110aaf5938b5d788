#include "pipeline/matte/contradiction.h"

#include <algorithm>
#include <filesystem>

#include "core/png.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

MatteTakeOptions given(const fs::path& take) {
  MatteTakeOptions options;
  options.take = take;
  options.how = "given";
  return options;
}

// The true mattes, but those of some cameras pushed into a corner.
fs::path take_with_given(const TempFolder& folder, int pushed) {
  const fs::path take = small_take(folder, 1);
  const Rig rig = *load_rig(take / "rig.json");
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const std::string& serial = rig.cameras[i].serial;
    Image matte = *load_png(TakeLayout(take / "truth").matte(serial, 0));
    if (static_cast<int>(i) < pushed) {
      std::fill(matte.pixels.begin(), matte.pixels.end(), std::uint8_t{0});
      for (int y = 0; y < matte.height / 6; ++y)
        std::fill_n(matte.at(0, y), matte.width / 6, std::uint8_t{255});
    }
    fs::create_directories(TakeLayout(take).matte(serial, 0).parent_path());
    EXPECT_THAT(save_png(matte, TakeLayout(take).matte(serial, 0)), IsOk());
  }
  return take;
}

TEST(Contradiction, TrueMattesDoNotContradictOneAnother) {
  TempFolder folder;
  const Result<MatteReport> report = matte_take(given(take_with_given(folder, 0)));
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, testing::IsEmpty());
}

TEST(Contradiction, IsSaidWithAPictureOfTheCamerasThatAreDenied) {
  TempFolder folder;
  const fs::path take = take_with_given(folder, 3);
  const Result<MatteReport> report = matte_take(given(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->doubts.size(), 1u);
  const MatteDoubt& doubt = report->doubts.front();
  EXPECT_GE(doubt.cameras.size(), 3u);
  EXPECT_THAT(sentence(doubt), testing::HasSubstr("denies more than half of the subject"));
  EXPECT_EQ(doubt.picture.parent_path(), doubts_folder(TakeLayout(take)));
  EXPECT_THAT(load_png(doubt.picture), IsOk());
}

}  // namespace
}  // namespace floatstage::pipeline
