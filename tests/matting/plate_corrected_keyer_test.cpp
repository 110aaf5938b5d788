#include "matting/keyers/plate_corrected_keyer.h"

#include <algorithm>
#include <iostream>

#include "core/synthetic/synthetic_studio.h"
#include "matting/keyers/live_key.h"
#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

// A stage as `stage` names it, with its plates and the keys by them.
class Stage {
 public:
  explicit Stage(SyntheticStage stage)
      : studio_(
            *SyntheticStudio::create(synthetic_rig({.cameras = 4}),
                                     {.seed = 3, .samples = 4, .stage = stage, .defects = {.noise = 1}})) {}

  const SyntheticStudio& studio() const { return studio_; }
  std::unique_ptr<Keyer> plain(int camera) const {
    return std::move(*make_keyer("chroma", {studio_.plate(camera)}));
  }
  std::unique_ptr<Keyer> corrected(int camera) const {
    return std::move(*corrected_by_plate(plain(camera), {studio_.plate(camera)}));
  }
  // Mean IoU with the truth over the cameras and two instants, keyed as `live` does.
  double agreement(bool with_plates) const {
    double sum = 0;
    for (int camera = 0; camera < 4; ++camera) {
      const auto keyer = with_plates ? corrected(camera) : plain(camera);
      LiveKey live(*keyer);
      for (const int frame : {0, 17}) {
        const SyntheticShot shot = studio_.shoot(camera, frame);
        sum += iou(*live.key(shot.frame), shot.matte) / 8;
      }
    }
    return sum;
  }

 private:
  SyntheticStudio studio_;
};

double share_apart(const Matte& a, const Matte& b) {
  long apart = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) apart += std::abs(a.row(y)[x] - b.row(y)[x]) > 2;
  return static_cast<double>(apart) / (a.width * a.height);
}

class OnAStage : public testing::TestWithParam<SyntheticStage> {};
INSTANTIATE_TEST_SUITE_P(PlateCorrectedKeyer, OnAStage,
                         testing::Values(SyntheticStage::Green, SyntheticStage::BlueCyclorama,
                                         SyntheticStage::Cables, SyntheticStage::Markers,
                                         SyntheticStage::GreenClothes),
                         [](const auto& stage) {
                           std::string name;
                           for (const SyntheticStageName& known : synthetic_stages())
                             if (known.stage == stage.param) name = known.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(OnAStage, ItsLiveKeyIsItsKey) {
  const Stage stage(GetParam());
  for (int camera = 0; camera < 4; ++camera) {
    const auto keyer = stage.corrected(camera);
    LiveKey live(*keyer);
    ASSERT_TRUE(live.fast());
    for (const int frame : {0, 17}) {
      const Frame photograph = stage.studio().shoot(camera, frame).frame;
      EXPECT_LE(share_apart(*live.key(photograph), *keyer->key(photograph)), 1e-4) << camera << ", " << frame;
    }
  }
}

TEST_P(OnAStage, ItIsNearerToTheTruth) {
  const Stage stage(GetParam());
  const double before = stage.agreement(false), after = stage.agreement(true);
  std::cout << "IoU " << before << " -> " << after << "\n";
  EXPECT_GE(after, before - 0.001);
}

TEST(PlateCorrectedKeyer, TakesOutCablesAndFindsWhomUnevenLightTakes) {
  for (const auto& [which, gain] :
       {std::pair(SyntheticStage::Cables, 0.015), std::pair(SyntheticStage::BlueCyclorama, 0.07)}) {
    const Stage stage(which);
    EXPECT_GE(stage.agreement(true), stage.agreement(false) + gain);
  }
}

TEST(PlateCorrectedKeyer, HearsNoPlateThatShowsAnotherPlace) {
  const Stage stage(SyntheticStage::Green);
  Image turned = stage.studio().plate(0);  // the camera has been turned upside down since
  for (std::size_t i = 0, j = turned.pixels.size(); i + 3 < j; i += 3, j -= 3)
    std::swap_ranges(turned.pixels.begin() + static_cast<std::ptrdiff_t>(i),
                     turned.pixels.begin() + static_cast<std::ptrdiff_t>(i + 3),
                     turned.pixels.begin() + static_cast<std::ptrdiff_t>(j - 3));
  for (std::uint8_t& v : turned.pixels) v = static_cast<std::uint8_t>(v / 5);  // and the light is out
  const SyntheticShot shot = stage.studio().shoot(0, 0);
  const auto keyer = std::move(*corrected_by_plate(stage.plain(0), {turned}));
  EXPECT_GE(iou(*LiveKey(*keyer).key(shot.frame), shot.matte),
            iou(*stage.plain(0)->key(shot.frame), shot.matte) - 0.002);
}

TEST(PlateCorrectedKeyer, IsTheKeyerItselfWhereNothingCorrects) {
  const Scene scene;
  const auto of = [&](const char* spec, const std::vector<Image>& plates) {
    auto keyer = std::move(*make_keyer(spec, {empty_stage(scene)}));
    const Keyer* before = keyer.get();
    return std::move(*corrected_by_plate(std::move(keyer), plates)).get() == before;
  };
  EXPECT_TRUE(of("plate", {empty_stage(scene)})) << "which compares with it anyway";
  EXPECT_TRUE(of("chroma", {})) << "no plate";
  EXPECT_TRUE(of("chroma", {Image(160, 120, 1)})) << "a grey plate";
  EXPECT_TRUE(of("chroma", {Image(160, 120, 3), Image(80, 60, 3)})) << "plates of two sizes";
  EXPECT_FALSE(of("chroma", {empty_stage(scene)}));
}

TEST(PlateCorrectedKeyer, KeysAPictureOfAnotherSizeWithoutThePlate) {
  Scene scene, wide;
  wide.width = 200;
  const auto plain = std::move(*make_keyer("chroma:#28783c", {}));
  const auto keyer =
      std::move(*corrected_by_plate(std::move(*make_keyer("chroma:#28783c", {})), {empty_stage(scene)}));
  const Frame frame = make_frame({}, photograph(wide));
  EXPECT_EQ(to_image(*keyer->key(frame)), to_image(*plain->key(frame)));
  EXPECT_EQ(to_image(*LiveKey(*keyer).key(frame)), to_image(*LiveKey(*plain).key(frame)));
}

}  // namespace
}  // namespace floatstage::matting
