// `floatstage calibrate export`: what is written is what `import` reads.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/calibrate/calibrate_verbs.h"
#include "calib/formats/format_files.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::ElementsAre;

class CalibrateExport : public testing::Test {
 protected:
  Result<void> run(const std::filesystem::path& rig, const std::string& format, const std::string& out) {
    CLI::App app;
    Chosen chosen;
    add_calibrate_export(app, chosen);
    std::vector<std::string> words = {"export", rig.string(), "--format",
                                      format,   "--out",      (folder_ / out).string()};
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app.parse(words);
    return chosen.run();
  }

  std::filesystem::path saved(const Rig& rig, const std::string& name = "rig.json") {
    EXPECT_THAT(save_rig(rig, folder_ / name), IsOk());
    return folder_ / name;
  }

  TempFolder folder_;
};

TEST_F(CalibrateExport, WritesWhatImportReads) {
  const Rig rig = calib::sample_rig(BrownConrady{.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -2e-3});
  const std::filesystem::path file = saved(rig);
  ASSERT_THAT(run(file, "colmap", "colmap"), IsOk());
  ASSERT_THAT(run(file, "opencv", "opencv"), IsOk());
  ASSERT_THAT(run(file, "qualisys", "rig.qca.txt"), IsOk());
  for (const Result<calib::ForeignRig>& back :
       {calib::read_colmap(folder_ / "colmap"), calib::read_easymocap(folder_ / "opencv"),
        calib::read_qualisys(folder_ / "rig.qca.txt")}) {
    ASSERT_THAT(back, IsOk());
    Rig read = back->rig;
    for (std::size_t i = 0; i < read.cameras.size(); ++i)
      if (read.cameras[i].serial == rig.cameras[i].serial + ".png")  // COLMAP names cameras after pictures
        read.cameras[i].serial = rig.cameras[i].serial;
    calib::expect_same(rig, read, 1e-9);
  }
}

TEST_F(CalibrateExport, NamesThePicturesAfterTheirCameras) {
  const std::filesystem::path file = saved(calib::sample_rig(std::monostate{}));
  ASSERT_THAT(run(file, "middlebury", "rig_par.txt"), IsOk());
  const Result<calib::ForeignRig> back = calib::read_middlebury(folder_ / "rig_par.txt");
  ASSERT_THAT(back, IsOk());
  const std::vector<RigCamera>& cameras = calib::sample_rig(std::monostate{}).cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(back->image_names[i], cameras[i].serial + ".png");
}

TEST_F(CalibrateExport, TakesATakesRig) {
  std::filesystem::create_directory(folder_ / "take");
  saved(calib::sample_rig(std::monostate{}), "take/rig.json");
  ASSERT_THAT(run(folder_ / "take", "kalibr", "chain.yaml"), IsOk());
  EXPECT_THAT(calib::read_kalibr(folder_ / "chain.yaml"), IsOk());
}

TEST_F(CalibrateExport, LeavesNothingBehindWhereAFormatCannotHoldTheRig) {
  const std::filesystem::path file = saved(calib::sample_rig(KannalaBrandt{0.01, 0, 0, 0}));
  for (const char* format : {"opencv", "qualisys", "middlebury"})
    EXPECT_THAT(run(file, format, "out"), FailsWith(ErrorCode::Unsupported, "camera '")) << format;
  EXPECT_THAT(folder_.names(), ElementsAre("rig.json"));
}

TEST_F(CalibrateExport, OverwritesNothing) {
  const std::filesystem::path file = saved(calib::sample_rig(std::monostate{}));
  folder_.write("chain.yaml", "yesterday's");
  EXPECT_THAT(run(file, "kalibr", "chain.yaml"), FailsWith(ErrorCode::AlreadyExists, "chain.yaml"));
  EXPECT_EQ(read_file(folder_ / "chain.yaml").value(), "yesterday's");
}

TEST_F(CalibrateExport, SaysWhichFormatsThereAre) {
  EXPECT_THAT(
      run(saved(calib::sample_rig(std::monostate{})), "blender", "x"),
      FailsWith(ErrorCode::InvalidArgument, "'blender' is no format that is written; there are middlebury"));
  EXPECT_THAT(run(folder_ / "nobody.json", "colmap", "x"), FailsWith(ErrorCode::NotFound, "nobody.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x"));
}

}  // namespace
}  // namespace floatstage::apps
