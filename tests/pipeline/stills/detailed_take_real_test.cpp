// Details on recorded data, with real calibration and real surfaces. Truth: photographs as they were taken;
// the take that gets details has them at a part of their size, and one camera's own crops are the stills.
#include <cstdio>

#include <gtest/gtest.h>

#include "core/png.h"
#include "pipeline/enlarged_box.h"
#include "pipeline/import/import.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/process/process.h"
#include "pipeline/stills/detailed_take.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kWorthScoring = 0.01;  // of the subject: below it a handful of pixels is scored

class DetailOf : public testing::Test {
 protected:
  void import(const std::string& format, const fs::path& data, const std::string& mattes) {
    ImportOptions options;
    options.calibration = {.format = format, .path = data};
    if (!mattes.empty()) options.calibration.metres_per_unit = 0.1, options.mattes = data / mattes;
    options.out = full();
    ASSERT_THAT(import_take(options), IsOk());
  }
  fs::path full() const { return folder_ / "full"; }
  fs::path small() const { return folder_ / "small"; }

  Image shrunk_picture(const Frame& frame, int width, int height) const {
    const Image mean = *shrink(frame, by_);
    Image cut(width, height, mean.channels);
    for (int y = 0; y < height; ++y) std::copy_n(mean.at(0, y), cut.width * cut.channels, cut.at(0, y));
    return cut;
  }

  /// The take at a part of its size, processed anew.
  void shrink_take(const std::string& matte) {
    const auto from = std::move(*capture::TakeReader::open(full()));
    Rig rig = from->rig();
    for (RigCamera& c : rig.cameras) {
      CameraModel& m = c.model;
      m.width /= by_, m.height /= by_;
      m.fx /= by_, m.fy /= by_, m.cx /= by_, m.cy /= by_;
    }
    auto writer = std::move(*capture::TakeWriter::create(small(), rig, {}));
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const CameraModel& m = rig.cameras[c].model;
      const Frame frame = *from->frame(static_cast<int>(c), 0);
      FrameInfo info = frame.info;
      info.camera = static_cast<int>(c);
      ASSERT_THAT(writer->write(make_frame(info, shrunk_picture(frame, m.width, m.height))), IsOk());
      const fs::path given = from->layout().matte(rig.cameras[c].serial, 0);
      if (!fs::exists(given)) continue;
      const fs::path to = TakeLayout(small()).matte(rig.cameras[c].serial, 0);
      fs::create_directories(to.parent_path());
      ASSERT_THAT(save_png(shrunk_picture(make_frame({}, *load_png(given)), m.width, m.height), to), IsOk());
    }
    ASSERT_THAT(writer->finish(), IsOk());
    writer.reset();
    ProcessOptions process;
    process.take = small();
    if (!matte.empty()) process.matte = matte;
    ASSERT_THAT(process_take(process), IsOk());
  }

  /// The upper and the lower half of what the camera's matte holds, as stills.
  fs::path stills_of(int camera) {
    const auto take = std::move(*capture::TakeReader::open(full()));
    const auto little = std::move(*capture::TakeReader::open(small()));
    const Image photo = *to_rgb(*take->frame(camera, 0));
    const Image matte =
        *load_png(little->layout().matte(little->rig().cameras[static_cast<std::size_t>(camera)].serial, 0));
    int left = matte.width, right = 0, top = matte.height, bottom = 0;
    for (int y = 0; y < matte.height; ++y)
      for (int x = 0; x < matte.width; ++x)
        if (*matte.at(x, y) >= 128)
          left = std::min(left, x), right = std::max(right, x + 1), top = std::min(top, y),
          bottom = std::max(bottom, y + 1);
    const fs::path folder = folder_ / "stills";
    fs::create_directories(folder);
    for (int half = 0; half < 2; ++half) {
      const int y0 = by_ * (half == 0 ? top : (top + bottom) / 2),
                y1 = by_ * (half == 0 ? (top + bottom) / 2 : bottom);
      Image still(by_ * (right - left), y1 - y0, 3);
      for (int y = 0; y < still.height; ++y)
        std::copy_n(photo.at(by_ * left, y0 + y), 3 * still.width, still.at(0, y));
      EXPECT_THAT(save_png(still, folder / (half == 0 ? "upper.png" : "lower.png")), IsOk());
    }
    return folder;
  }

  /// What details make of the photographs of the camera and its neighbours, dB over where they lie: more than
  /// `own` and more than `others`, in `least_seen` cameras at least.
  void gains(const std::string& name, int camera, double own, double others, int least_seen) {
    int seen = 0;
    const fs::path out = folder_ / "detailed";
    const auto report = add_detail({.take = small(), .out = out, .stills = stills_of(camera), .zoom = by_});
    ASSERT_THAT(report, IsOk());
    const auto take = std::move(*capture::TakeReader::open(full())),
               made = std::move(*capture::TakeReader::open(out)),
               little = std::move(*capture::TakeReader::open(small()));
    for (const DetailedCamera& c : report->cameras) {
      if (c.zoom == 1) continue;
      const int index = camera_index(take->rig(), c.serial), at = camera_index(made->rig(), c.serial);
      const Image after = *to_rgb(*made->frame(at, 0));
      const Image before = enlarged_picture(*to_rgb(*little->frame(index, 0)), by_, 0);
      const Image whole = *to_rgb(*take->frame(index, 0));
      Image truth(after.width, after.height, 3), mask(after.width, after.height, 1);
      for (int y = 0; y < truth.height; ++y) std::copy_n(whole.at(0, y), 3 * truth.width, truth.at(0, y));
      const Image origin = *load_png(out / "detail" / (c.serial + ".png"));
      for (std::size_t i = 0; i < mask.pixels.size(); ++i)
        mask.pixels[i] = origin.pixels[3 * i] != origin.pixels[3 * i + 1] ||
                                 origin.pixels[3 * i + 1] != origin.pixels[3 * i + 2]
                             ? 255
                             : 0;
      double direct = 0, used = 0;
      for (const StillInPhoto& s : c.stills) direct += s.direct ? 1 : 0, used += s.used;
      std::printf("%s %s%s: used %.3f, psnr %.2f -> %.2f, cw-ssim %.4f -> %.4f, sharpness %.3f -> %.3f\n",
                  name.c_str(), c.serial.c_str(), direct > 0 ? " (direct)" : "", used,
                  psnr(before, truth, mask), psnr(after, truth, mask), cw_ssim(before, truth, mask),
                  cw_ssim(after, truth, mask), sharpness(before, truth, mask), sharpness(after, truth, mask));
      const double gained = psnr(after, truth, mask) - psnr(before, truth, mask);
      if (index == camera) {
        EXPECT_GT(gained, own) << "the camera whose crops the stills are";
      } else if (used >= kWorthScoring) {
        EXPECT_GT(gained, others) << c.serial;
      }
      seen += used >= kWorthScoring ? 1 : 0;
    }
    EXPECT_GE(seen, least_seen) << "cameras whose photographs have details";
  }

  TempFolder folder_;
  int by_ = 3;
};

TEST_F(DetailOf, AGreenDomesPerson) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome"));
  by_ = 2;
  import("dome", real_data("green-dome"), "mattes");
  shrink_take("");
  // The finest octave of its photographs is the cameras' noise: details of others are none.
  gains("dome", 5, 3, -4.5, 5);
}
TEST_F(DetailOf, AnotherPerson) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome-wd"));
  import("dome", real_data("green-dome-wd"), "mattes");
  shrink_take("");
  gains("wd", 5, 8, 1, 4);
}
TEST_F(DetailOf, ATemple) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  import("middlebury", real_data("middlebury-temple-ring"), "");
  shrink_take("luminance");
  gains("temple", 9, 9, 1, 9);
}

}  // namespace
}  // namespace floatstage::pipeline
