#include <cmath>

#include <ImfRgbaFile.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "tests/support/run_command.h"
#include "tests/support/small_take.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The program itself, from the command line to the files.
class MatteVerb : public testing::Test {
 protected:
  MatteVerb() : take_(small_take(folder_, 2)) {}

  int run(const std::string& arguments) {
    Ended ended = run_command(FLOATSTAGE_PROGRAM " " + arguments);
    output_ = std::move(ended.output);
    return ended.code;
  }
  std::string matte(const std::string& arguments) const {
    return text("matte '", take_.string(), "' --cameras cam01 --hull-frames 0 ", arguments);
  }
  static Image picture(const fs::path& file) {
    Result<Image> image = load_png(file);
    EXPECT_THAT(image, IsOk());
    return image ? std::move(*image) : Image();
  }

  TempFolder folder_;
  fs::path take_;
  std::string output_;
};

TEST_F(MatteVerb, FollowsLabelsThroughAFolderOfPicturesThatIsNoTake) {
  const fs::path frames = folder_ / "frames";
  fs::create_directories(frames);
  Image mask(96, 64, 1);
  for (int f = 0; f < 3; ++f) {  // a red box that goes right over a wall of many greys
    Image picture(96, 64, 3);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 96; ++x) {
        const bool in = x >= 20 + 2 * f && x < 50 + 2 * f && y >= 20 && y < 44;
        const auto grey = static_cast<std::uint8_t>(90 + (x * 37 + y * 91) % 80);
        std::uint8_t* rgb = picture.at(x, y);
        rgb[0] = in ? 200 : grey;
        rgb[1] = rgb[2] = in ? static_cast<std::uint8_t>(grey / 4) : grey;
        if (f == 0 && in) *mask.at(x, y) = 255;
      }
    ASSERT_THAT(save_png(picture, frames / text("00", f, ".png")), IsOk());
  }
  ASSERT_THAT(save_png(mask, folder_ / "box2.png"),
              IsOk());  // of the first frame, whatever its name ends with
  const std::string clip =
      text("matte '", frames.string(), "' --label box='", (folder_ / "box2.png").string(), "'");
  EXPECT_NE(run(clip), 0);
  EXPECT_THAT(output_, HasSubstr("--out"));
  ASSERT_EQ(run(clip + " -o '" + (folder_ / "out").string() + "'"), 0) << output_;
  EXPECT_EQ(*picture(folder_ / "out/box/000002.png").at(40, 32), 255);
  EXPECT_EQ(*picture(folder_ / "out/box/000002.png").at(10, 32), 0);
  EXPECT_EQ(run(clip + " -o '" + (folder_ / "out").string() + "'"), 5) << "never written over";
}

TEST_F(MatteVerb, StartsFromOthersMattes) {
  // Others say that the subject is a box at the left; it is nowhere near the dancer, so where a matte has it,
  // it came from them.
  Image box(160, 120, 1);
  for (int y = 40; y < 80; ++y) std::fill_n(box.at(20, y), 30, std::uint8_t{255});
  for (const char* name : {"000000.png", "000001.png"}) {
    fs::create_directories(folder_ / "guide" / "cam01");
    ASSERT_THAT(save_png(box, folder_ / "guide" / "cam01" / name), IsOk());
  }
  ASSERT_EQ(run(matte("--matte closed-form --guide '" + (folder_ / "guide").string() + "'")), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("closed-form by guide; 2 made"));
  const Image made = picture(TakeLayout(take_).matte("cam01", 1));
  EXPECT_EQ(*made.at(35, 60), 255);
  EXPECT_EQ(*made.at(82, 60), 0) << "the dancer is not the others' subject";
  EXPECT_NE(run(matte("--redo --guide '" + (folder_ / "nowhere").string() + "'")), 0);
  EXPECT_THAT(output_, HasSubstr("nowhere"));
}

TEST_F(MatteVerb, AndEveryOtherVerbGoOnWithMattesMadeByHand) {
  const TakeLayout layout(take_);
  fs::copy(layout.truth().mattes(), layout.mattes(), fs::copy_options::recursive);
  const std::string before = *read_file(layout.matte("cam03", 1)), take = " '" + take_.string() + "' ";
  for (const std::string& verb :
       {"process" + take, "matte" + take, "process" + take + "--redo",
        "matte" + take + "--redo --matte chroma", "hull" + take + "--frame 1", "evaluate" + take + "--mattes",
        "evaluate" + take + "--frames 0 --hold-out cam01 --methods linear",
        "render" + take + "--orbit --frames 0:2 --size 64x48 -o '" + (folder_ / "film").string() + "'",
        "matte" + take + "--export '" + (folder_ / "layers").string() + "'"})
    EXPECT_EQ(run(verb), 0) << verb << "\n" << output_;
  EXPECT_EQ(*read_file(layout.matte("cam03", 1)), before);
  EXPECT_FALSE(fs::exists(layout.made_mattes())) << "nothing was made";
}

TEST_F(MatteVerb, EditsChangeTheFilmOnceTheTakeIsProcessed) {
  const auto film = [&](const char* name) {
    return text("render '", take_.string(), "' --orbit --frames 1 --fps 1 --size 64x48 -o '",
                (folder_ / name).string(), "'");
  };
  ASSERT_EQ(run(text("process '", take_.string(), "' --matte chroma")), 0) << output_;
  ASSERT_EQ(run(film("before")), 0) << output_;
  MatteEdits edits;  // who wears nothing above the belt in any camera has no head
  for (const char* serial : {"cam00", "cam01", "cam02", "cam03", "cam04", "cam05"})
    edits.cameras[serial].masks.push_back(
        {MatteLabel::Background, {{0, 0}, {160, 0}, {160, 50}, {0, 50}}, 1, 1});
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take_).edits()), IsOk());
  ASSERT_EQ(run(text("matte '", take_.string(), "' --hull-frames 0")), 0) << output_;
  EXPECT_NE(run(film("between")), 0) << "no picture is older than its silhouettes";
  EXPECT_THAT(output_, HasSubstr("is older than the matte of camera"));
  ASSERT_EQ(run(text("process '", take_.string(), "'")), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("mattes 0 made, 12 kept, 0 gaps; meshes 1 made, 1 kept"));
  ASSERT_EQ(run(film("after")), 0) << output_;
  EXPECT_NE(picture(folder_ / "before" / "000000.png"), picture(folder_ / "after" / "000000.png"));
}

TEST_F(MatteVerb, ExportsTheSameStraightLayersInEveryFormat) {
  for (const char* format : {"png8", "png16", "exr"})
    ASSERT_EQ(run(matte(text("--matte closed-form --export '", (folder_ / format).string(),
                             "' --export-format ", format))),
              0)
        << output_;
  const fs::path png = fs::path("cam01") / "000001.png";
  const Image narrow = picture(folder_ / "png8" / png), wide = picture(folder_ / "png16" / png),
              alpha = picture(TakeLayout(take_).matte("cam01", 1));
  EXPECT_EQ(narrow, wide);
  const Result<std::string> bytes = read_file(folder_ / "png16" / png);
  ASSERT_THAT(bytes, IsOk());
  EXPECT_EQ((*bytes)[24], 16) << "bits a channel";

  Imf::RgbaInputFile exr((folder_ / "exr" / "cam01" / "000001.exr").c_str());
  std::vector<Imf::Rgba> pixels(160 * 120);
  exr.setFrameBuffer(pixels.data(), 1, 160);
  exr.readPixels(0, 119);
  int soft = 0;
  for (int p = 0; p < 160 * 120; ++p) {
    const Imf::Rgba& e = pixels[static_cast<std::size_t>(p)];
    const std::uint8_t* s = narrow.pixels.data() + 4 * p;
    EXPECT_NEAR(e.a, alpha.pixels[static_cast<std::size_t>(p)] / 255.0, 1e-3);
    const double c = s[0] / 255.0, light = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(e.r, light, 1e-3) << "linear light, not multiplied by opacity";
    soft += s[3] > 30 && s[3] < 225;
  }
  EXPECT_GT(soft, 20) << "there are pixels in which straight and premultiplied differ";
}

TEST_F(MatteVerb, LetsEvaluatePrintWhatItCostAPerson) {
  CameraEdits edits;
  edits.keyframes.push_back({0,
                             {{MatteLabel::Foreground, 1, {{80, 60}}},
                              {MatteLabel::Background, 2, {{5, 5}}},
                              {MatteLabel::Background, 2, {{5, 100}, {20, 100}}}}});
  edits.keyframes.push_back({1, {{MatteLabel::Foreground, 1, {{80, 60}}}}});
  edits.masks.push_back({MatteLabel::Background, {{2, 2}}, 0, {}, 2});
  ASSERT_THAT(make_folder(TakeLayout(take_).mattes()), IsOk());
  ASSERT_THAT(save_matte_edits({{{"cam01", edits}}}, TakeLayout(take_).edits()), IsOk());
  ASSERT_EQ(run(matte("--matte chroma")), 0) << output_;
  const fs::path report = folder_ / "scores.json";
  ASSERT_EQ(run(text("evaluate '", take_.string(), "' --mattes --json '", report.string(), "'")), 0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("effort"));
  EXPECT_THAT(output_, HasSubstr(" 2/5 ")) << "keyframes, and clicks, scribbles and masks";
  const Result<std::string> json = read_file(report);
  ASSERT_THAT(json, IsOk());
  EXPECT_THAT(*json, testing::ContainsRegex("\"clicks\": *3"));
  EXPECT_THAT(*json, testing::ContainsRegex("\"keyframes\": *2"));
}

}  // namespace
}  // namespace floatstage::apps
