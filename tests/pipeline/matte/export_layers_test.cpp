#include "pipeline/matte/export_layers.h"

#include <chrono>
#include <map>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/label_record.h"
#include "tests/support/crossing_take.h"
#include "tests/support/places.h"
#include "tests/support/run_command.h"

// What compositing programs get of a take with two performers.
namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

constexpr int kFrames = 2, kWidth = 200, kHeight = 150;
const std::vector<std::string> kLabels = {"first", "the-second"};

// A take whose mattes are divided between its performers, the truth's way.
class LayersOfTwo : public testing::Test {
 protected:
  LayersOfTwo() : take_(crossing_take(folder_, kFrames)), layout_(take_) {
    fs::copy(layout_.truth().mattes(), layout_.mattes(), fs::copy_options::recursive);
    for (const char* serial : {"cam00", "cam01"}) {
      fs::rename(layout_.mattes() / serial / "second", layout_.mattes() / serial / kLabels[1]);
      for (int f = 0; f < kFrames; ++f) {  // to the last digit
        const Image a = *load_png(layout_.label_matte(serial, kLabels[0], f)),
                    b = *load_png(layout_.label_matte(serial, kLabels[1], f));
        Image sum = a;
        for (std::size_t p = 0; p < sum.pixels.size(); ++p)
          sum.pixels[p] = static_cast<std::uint8_t>(std::min(255, a.pixels[p] + b.pixels[p]));
        EXPECT_THAT(save_png(sum, layout_.matte(serial, f)), IsOk());
      }
    }
    LabelRecord record;
    record.labels = kLabels;
    EXPECT_THAT(save_label_record(record, layout_), IsOk());
  }
  fs::path out(const std::string& format) const { return folder_ / format; }
  Result<int> export_as(const std::string& format) const {
    return export_layers({.take = take_, .out = out(format), .format = format, .threads = 2});
  }
  Image matte(const std::string& label, int frame) const {
    return *load_png(label.empty() ? layout_.matte("cam00", frame)
                                   : layout_.label_matte("cam00", label, frame));
  }

  const TempFolder folder_;
  const fs::path take_;
  const TakeLayout layout_;
};

// By name, all channels of an EXR.
std::map<std::string, std::vector<float>> channels_of(const fs::path& file) {
  Imf::InputFile exr(file.c_str());
  std::map<std::string, std::vector<float>> channels;
  Imf::FrameBuffer buffer;
  for (auto c = exr.header().channels().begin(); c != exr.header().channels().end(); ++c) {
    std::vector<float>& values = channels[c.name()];
    values.resize(std::size_t{kWidth} * kHeight);
    buffer.insert(c.name(), Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                                       sizeof(float) * kWidth));
  }
  exr.setFrameBuffer(buffer);
  exr.readPixels(0, kHeight - 1);
  return channels;
}

TEST_F(LayersOfTwo, AreOneExrAPictureWithAnAlphaEach) {
  EXPECT_THAT(export_as("exr"), IsOkAnd(2 * kFrames));
  const auto channels = channels_of(out("exr") / "cam00/000001.exr");
  std::vector<std::string> names;
  for (const auto& [name, values] : channels) names.push_back(name);
  EXPECT_THAT(names, ElementsAre("A", "B", "G", "R", "first.A", "the-second.A"));
  long covered[2] = {};
  const Image sum = matte("", 1), parts[2] = {matte(kLabels[0], 1), matte(kLabels[1], 1)};
  for (std::size_t p = 0; p < sum.pixels.size(); ++p) {
    EXPECT_NEAR(channels.at("A")[p], sum.pixels[p] / 255.0, 1e-3);
    for (std::size_t l = 0; l < 2; ++l) {
      EXPECT_NEAR(channels.at(kLabels[l] + ".A")[p], parts[l].pixels[p] / 255.0, 1e-3);
      covered[l] += parts[l].pixels[p] > 250;
    }
    EXPECT_NEAR(channels.at("first.A")[p] + channels.at("the-second.A")[p], channels.at("A")[p], 2e-3)
        << "whoever leaves one of them out has the other";
  }
  EXPECT_GT(covered[0], 500);
  EXPECT_GT(covered[1], 500);
}

// As another reader has it: the picture, with the opacity of all, as if there were no layers.
TEST_F(LayersOfTwo, AreReadByFfmpegAsOnePicture) {
  ASSERT_THAT(export_as("exr"), IsOk());
  const std::string exr = (out("exr") / "cam00/000000.exr").string();
  const Ended probed =
      run_command("ffprobe -v error -show_entries stream=codec_name,width,height '" + exr + "'");
  EXPECT_THAT(probed.output, testing::AllOf(HasSubstr("codec_name=exr"), HasSubstr("width=200")));
  const Ended read =
      run_command("ffmpeg -v error -i '" + exr + "' -vf alphaextract -f rawvideo -pix_fmt gray -");
  ASSERT_EQ(read.code, 0) << read.output;
  const Image sum = matte("", 0);
  ASSERT_EQ(read.output.size(), sum.pixels.size()) << read.output;
  for (std::size_t p = 0; p < sum.pixels.size(); ++p)
    ASSERT_NEAR(static_cast<std::uint8_t>(read.output[p]), sum.pixels[p], 2) << p;
}

TEST_F(LayersOfTwo, AreReadByBlenderAsLayers) {
  ASSERT_THAT(export_as("exr"), IsOk());
  const fs::path script = source_folder() / "tests/pipeline/matte/exr_in_blender.py",
                 out_file = folder_ / "b.json";
  const Ended ended = run_command(
      text("blender --background --factory-startup --python-exit-code 1 --python '", script.string(),
           "' -- '", (out("exr") / "cam00/000001.exr").string(), "' '", out_file.string(), "'"));
  ASSERT_EQ(ended.code, 0) << ended.output;
  const nlohmann::json report = nlohmann::json::parse(*read_file(out_file));
  EXPECT_EQ(report["type"], "MULTILAYER");
  for (const std::string& label : kLabels) {
    ASSERT_TRUE(report["layers"].contains(label)) << report["layers"].dump().substr(0, 300);
    const std::vector<float> values = report["layers"][label];
    const Image want = matte(label, 1);
    ASSERT_EQ(values.size(), want.pixels.size());
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        ASSERT_NEAR(values[static_cast<std::size_t>((kHeight - 1 - y) * kWidth + x)], *want.at(x, y) / 255.0,
                    2e-3)
            << x << "," << y;
  }
}

TEST_F(LayersOfTwo, AreAFolderOfPngsEachWithColoursOfTheirOwn) {
  for (const char* format : {"png8", "png16"}) {
    EXPECT_THAT(export_as(format), IsOkAnd(2 * kFrames * 3));
    for (const std::string& label : kLabels) {
      const Image layer = *load_png(out(format) / "cam00" / label / "000001.png"), want = matte(label, 1);
      ASSERT_EQ(layer.channels, 4);
      for (std::size_t p = 0; p < want.pixels.size(); ++p)
        ASSERT_EQ(layer.pixels[4 * p + 3], want.pixels[p]) << label;
    }
    EXPECT_TRUE(fs::exists(out(format) / "cam01/000000.png")) << "all together, as before";
  }
}

TEST_F(LayersOfTwo, AreMadeAgainOnlyWhereAMatteIsNewerOrAChannelIsMissing) {
  ASSERT_THAT(export_as("exr"), IsOk());
  const fs::path exr = out("exr") / "cam00/000000.exr", other = out("exr") / "cam00/000001.exr";
  const auto before = fs::last_write_time(exr) - std::chrono::hours(1);
  for (const fs::path& file : {exr, other}) fs::last_write_time(file, before);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(layout_.mattes()))
    if (entry.is_regular_file()) fs::last_write_time(entry.path(), before - std::chrono::hours(1));
  Image changed = matte("first", 0);
  std::fill(changed.pixels.begin(), changed.pixels.end(), std::uint8_t{0});
  ASSERT_THAT(save_png(changed, layout_.label_matte("cam00", "first", 0)), IsOk());
  ASSERT_THAT(export_as("exr"), IsOk());
  EXPECT_EQ(fs::last_write_time(other), before) << "nothing is newer than this one";
  const std::vector<float> again = channels_of(exr).at("first.A");
  EXPECT_EQ(again, std::vector<float>(again.size(), 0));
  LabelRecord nobody;  // labels were given up
  ASSERT_THAT(save_label_record(nobody, layout_), IsOk());
  EXPECT_THAT(export_as("exr"), IsOkAnd(2 * kFrames));
  EXPECT_EQ(channels_of(other).size(), 4U);
}

TEST_F(LayersOfTwo, AreNamedWhereAMatteIsMissing) {
  fs::remove(layout_.label_matte("cam01", "first", 1));
  for (const char* format : {"exr", "png8"})
    EXPECT_THAT(export_as(format), FailsWith(ErrorCode::NotFound, "first/000001.png"));
}

}  // namespace
}  // namespace floatstage::pipeline
