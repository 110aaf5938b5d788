// Stages of another renderer, from pictures and a COLMAP model to mattes, without a word about how.
#include <gmock/gmock.h>

#include "core/png.h"
#include "core/text.h"
#include "pipeline/import/import.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/metrics/matte_metrics.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::generality {
namespace {

namespace fs = std::filesystem;

struct Rendered {
  std::string method;  ///< of all cameras, or "several", or why there are no mattes
  double iou = 0;      ///< mean over cameras
  bool trusted = false;
};

// What `matte` makes of a stage that Blender rendered.
Rendered matted(const std::string& stage, bool plates) {
  const TempFolder folder;
  const fs::path script = source_folder() / "tests/generality/rendered_stage.py", scene = folder / "scene";
  const Ended rendered =
      run_command(text("blender --background --factory-startup --python-exit-code 1 --python '",
                       script.string(), "' -- ", stage, " '", scene.string(), "' 320 12"));
  EXPECT_EQ(rendered.code, 0) << rendered.output;
  pipeline::ImportOptions import;
  import.calibration = {"colmap", scene / "sparse"};
  import.pictures = scene / "pictures";
  if (plates) import.plates = scene / "plates";
  import.out = folder / "take";
  EXPECT_THAT(pipeline::import_take(import), IsOk());
  const auto report = pipeline::matte_take({.take = import.out, .heal = true});
  if (!report) return {.method = report.error().message};
  Rendered out{.method = report->cameras.front().method, .trusted = report->doubts.empty()};
  for (const pipeline::CameraMattes& camera : report->cameras) {
    if (camera.method != out.method) out.method = "several";
    const Image with_alpha = *load_png(scene / "truth" / camera.serial / "000000.png");
    Image truth(with_alpha.width, with_alpha.height, 1);
    for (std::size_t p = 0; p < truth.pixels.size(); ++p) truth.pixels[p] = with_alpha.pixels[4 * p + 3];
    out.iou += pipeline::matte_iou(*load_png(TakeLayout(import.out).matte(camera.serial, 0)), truth) /
               static_cast<double>(report->cameras.size());
  }
  return out;
}

TEST(RenderedStage, WithClothOnThreeOfFourWallsIsMattedByAllCamerasTogether) {
  const Rendered found = matted("tarpaulin", false);
  EXPECT_EQ(found.method, "consistent");
  EXPECT_GE(found.iou, 0.95);
  EXPECT_TRUE(found.trusted);
}

// Skin is nearly as bright as what is behind it, and of a colour that is near to it.
TEST(RenderedStage, AllInWhiteIsMattedWithFacesAndHands) {
  const Rendered found = matted("cyclorama", false);
  EXPECT_EQ(found.method, "consistent");
  EXPECT_GE(found.iou, 0.93);
  EXPECT_TRUE(found.trusted);
}

// A shadow that is half as bright as the floor, and bluer: by plates alone it belongs to him.
TEST(RenderedStage, InTheSunIsMattedWithoutShadows) {
  const Rendered found = matted("yard", true);
  EXPECT_EQ(found.method, "consistent");
  EXPECT_GE(found.iou, 0.95);
  EXPECT_TRUE(found.trusted);
}

// By each camera alone a shirt of the cloth's colour is cloth that is lit otherwise.
TEST(RenderedStage, WithAShirtOfTheClothsColourIsMattedWhole) {
  const Rendered found = matted("greens", true);
  EXPECT_EQ(found.method, "consistent");
  EXPECT_GE(found.iou, 0.92);  // noise hides where it is as bright as the cloth behind it
}

TEST(RenderedStage, WithPlatesIsMattedAndTrusted) {
  FLOATSTAGE_LONG_FORM(true);
  for (const auto& [stage, least] : {std::pair{"tarpaulin", 0.93},
                                     {"workshop", 0.9},
                                     {"lounge", 0.95},
                                     {"cyclorama", 0.9},
                                     {"corner", 0.93},
                                     {"theatre", 0.87},
                                     {"gym", 0.93},
                                     {"garden", 0.93},
                                     {"court", 0.95},
                                     {"beach", 0.95},
                                     {"spot", 0.95},
                                     {"asphalt", 0.92}}) {
    const Rendered found = matted(stage, true);
    EXPECT_GE(found.iou, least) << stage;
    EXPECT_TRUE(found.trusted) << stage;
  }
}

TEST(RenderedStage, WithoutClothOrPlateIsNotSaidToBeTrusted) {
  FLOATSTAGE_LONG_FORM(true);
  for (const char* stage : {"workshop", "lounge", "corner", "theatre", "garden"}) {
    const Rendered found = matted(stage, false);
    EXPECT_TRUE(found.iou >= 0.9 || !found.trusted) << stage << ": " << found.iou;
  }
}

}  // namespace
}  // namespace floatstage::generality
