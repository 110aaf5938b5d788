#include <cstdlib>

#include <gtest/gtest.h>

#include "core/png.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/import/import.h"
#include "pipeline/process/process.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

// The commands of the README on real photographs, with the bars that they are held to.
class RealTake : public testing::Test {
 protected:
  void make_take(const std::string& format, const std::string& key) {
    pipeline::ImportOptions import;
    import.calibration.format = format;
    import.calibration.path = data_;
    import.out = take();
    ASSERT_THAT(pipeline::import_take(import), IsOk());
    ASSERT_THAT(pipeline::process_take({.take = take(), .matte = key, .hull = recon::HullOptions{}}), IsOk());
  }

  fs::path take() const { return folder_ / "take"; }

  /// Mean scores per method over the views, each held out in turn.
  std::map<std::string, pipeline::Scores> leave_out(const std::vector<std::string>& views) {
    auto reader = capture::TakeReader::open(take());
    EXPECT_THAT(reader, IsOk());
    std::map<std::string, pipeline::Scores> mean;
    for (const char* method : {"nearest", "linear", "floating"}) mean[method].ghosting = 0;
    const double n = static_cast<double>(views.size());
    pipeline::EvaluateOptions options{.hold_out = views, .renderer = {}, .proxy = {}};
    options.proxy.kind = pipeline::Proxy::Kind::Hull;
    options.proxy.hull.method = recon::HullMethod::Octree;
    EXPECT_THAT(pipeline::evaluate_take(**reader, options,
                                        [&](pipeline::HeldOutView view) {
                                          for (const auto& [method, s] : view.scores)
                                            for (double pipeline::Scores::*m :
                                                 {&pipeline::Scores::psnr, &pipeline::Scores::ssim,
                                                  &pipeline::Scores::cw_ssim, &pipeline::Scores::psnr_shift,
                                                  &pipeline::Scores::sharpness,
                                                  &pipeline::Scores::ghosting})
                                              mean[method].*m += s.*m / n;
                                          return Result<void>();
                                        }),
                IsOk());
    return mean;
  }

  TempFolder folder_;
  fs::path data_;
};

TEST_F(RealTake, TempleRingIsSharperFloatingThanBlended) {
  data_ = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(data_);
  make_take("middlebury", "luminance:12");
  const auto mean = leave_out({"templeR0014.png", "templeR0016.png", "templeR0018.png", "templeR0020.png",
                               "templeR0022.png", "templeR0024.png", "templeR0026.png", "templeR0028.png",
                               "templeR0030.png"});
  EXPECT_GE(mean.at("floating").psnr, 22.0);
  EXPECT_GE(mean.at("floating").psnr, mean.at("linear").psnr + 2.8);
  EXPECT_GE(mean.at("floating").ssim, mean.at("linear").ssim + 0.08);
  EXPECT_LE(mean.at("floating").ghosting, 0.5 * mean.at("linear").ghosting);
}

TEST_F(RealTake, TempleSparseRingIsBetterFloatingInEveryMetric) {
  data_ = real_data("middlebury-temple-sparse-ring");
  FLOATSTAGE_NEEDS_DATA(data_);
  make_take("middlebury", "luminance:12");
  const auto mean = leave_out({"templeSR0002.png", "templeSR0003.png", "templeSR0004.png", "templeSR0005.png",
                               "templeSR0006.png", "templeSR0007.png", "templeSR0008.png", "templeSR0009.png",
                               "templeSR0010.png", "templeSR0011.png", "templeSR0012.png", "templeSR0013.png",
                               "templeSR0014.png", "templeSR0015.png"});
  const pipeline::Scores &linear = mean.at("linear"), &floating = mean.at("floating");
  EXPECT_GT(floating.psnr, linear.psnr);
  EXPECT_GT(floating.ssim, linear.ssim);
  EXPECT_GT(floating.cw_ssim, linear.cw_ssim);
  EXPECT_GT(floating.psnr_shift, linear.psnr_shift);
  EXPECT_GT(floating.sharpness, linear.sharpness);
}

TEST_F(RealTake, PersonInTheGreenDomeIsKeyedAndFloats) {
  data_ = real_data("green-dome");
  FLOATSTAGE_NEEDS_DATA(data_);
  make_take("dome", "chroma");
  double sum = 0;
  for (int i = 0; i < 20; ++i) {
    const std::string serial = (i < 10 ? "0" : "") + std::to_string(i);
    const Matte made = make_matte({}, *load_png(TakeLayout(take()).matte(serial, 0)));
    sum += iou(made, make_matte({}, *load_png(data_ / "mattes" / (serial + ".png"))));
  }
  EXPECT_GE(sum / 20, 0.97) << "mean IoU of the key with the mattes made by others";
  const auto mean = leave_out({"01", "03", "05", "07", "09", "11", "13", "15", "17", "19"});
  EXPECT_GT(mean.at("floating").psnr, mean.at("linear").psnr + 0.5);
  EXPECT_GT(mean.at("floating").ssim, mean.at("linear").ssim + 0.025);
}

}  // namespace
}  // namespace floatstage
