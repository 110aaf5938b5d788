#include "pipeline/matte/heal_mattes.h"

#include <algorithm>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/frame_pixels.h"
#include "core/png.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/broken_mattes.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kHealed = 0.95;   // IoU with truth
constexpr double kFilmLoss = 0.5;  // dB

/// What a key that fails does to a matte, seen its photograph.
struct BrokenKey {
  const char* name;
  std::function<void(const Image& photograph, Image& matte)> fail;
};

bool reddish(const std::uint8_t* rgb) { return rgb[0] > rgb[1] + 15; }

void keyed_red(const Image& photograph, Image& matte) {
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) *matte.at(x, y) = reddish(photograph.at(x, y)) ? 0 : 255;
}

// Skin, hair and most of the trousers are taken for backing, in small holes.
void red_lost(const Image& photograph, Image& matte) {
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if (reddish(photograph.at(x, y))) *matte.at(x, y) = 0;
}

void lamp_kept(const Image&, Image& matte) {
  const int cx = matte.width * 7 / 10, cy = matte.height / 4, r = matte.height / 8;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r) *matte.at(x, y) = 255;
}

void half_cut(const Image&, Image& matte) { test::cut_upper_half(matte); }

std::string name_of(const testing::TestParamInfo<BrokenKey>& key) { return key.param.name; }

/// Eight cameras around the green stage, one instant, processed.
class HealedTake : public testing::TestWithParam<BrokenKey> {
 protected:
  void SetUp() override {
    SynthesizeOptions options;
    options.out = take_;
    options.rig.width = 320;
    options.rig.height = 240;
    options.studio.samples = 4;
    options.studio.defects.noise = 1;
    options.frames = 1;
    ASSERT_THAT(synthesize_take(options), IsOk());
    ASSERT_THAT(process_take({.take = take_, .matte = "chroma"}), IsOk());
  }
  TakeLayout layout() const { return TakeLayout(take_); }
  double iou_of(const std::string& serial) const {
    return iou(make_matte({}, *load_png(layout().matte(serial, 0))),
               make_matte({}, *load_png(layout().truth().matte(serial, 0))));
  }
  // As if the camera's key had given it.
  void break_key(const std::vector<std::string>& serials, const BrokenKey& key) {
    const auto take = *capture::TakeReader::open(take_);
    const auto store = *MatteStore::open(layout());
    for (const std::string& serial : serials) {
      Image matte = *load_png(layout().matte(serial, 0));
      key.fail(*to_rgb(*take->frame(camera_index(take->rig(), serial), 0)), matte);
      ASSERT_THAT(store->put(serial, 0, matte), IsOk());
    }
    ASSERT_THAT(store->save(serials), IsOk());
  }
  // PSNR of Floating Textures, each of these cameras left out in turn.
  double film() const {
    const auto take = *capture::TakeReader::open(take_);
    double sum = 0;
    int views = 0;
    EvaluateOptions options;
    options.hold_out = {"cam00", "cam03", "cam06"};
    options.methods = {"floating"};
    options.renderer.back_end = render::BackEnd::Cpu;
    options.proxy.kind = Proxy::Kind::Hull;
    options.proxy.hull.voting = recon::HullVoting::Auto;
    EXPECT_THAT(evaluate_take(*take, options,
                              [&](const HeldOutView& view) -> Result<void> {
                                sum += view.scores.at("floating").psnr_full, ++views;
                                return {};
                              }),
                IsOk());
    return sum / views;
  }
  void take_true_mattes() {
    fs::remove_all(layout().mattes());
    fs::remove_all(layout().meshes());
    fs::copy(layout().truth().mattes(), layout().mattes(), fs::copy_options::recursive);
    ASSERT_THAT(process_take({.take = take_}), IsOk());
  }

  TempFolder folder_;
  const fs::path take_ = folder_ / "take";
};

TEST_P(HealedTake, NamesTwoOfEightKeysThatFailedAndCutsTheirMattesAnew) {
  const std::vector<std::string> broken = {"cam02", "cam05"};
  break_key(broken, GetParam());
  for (const std::string& serial : broken) ASSERT_LT(iou_of(serial), 0.9) << "not broken";
  const Result<ProcessReport> report = process_take({.take = take_});
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->healed.size(), 2u);
  for (const HealedCamera& camera : report->healed) {
    EXPECT_THAT(broken, Contains(camera.serial));
    EXPECT_GT(std::max(camera.lost, camera.gained), 0.1) << camera.serial;
    EXPECT_GE(iou_of(camera.serial), kHealed) << camera.serial;
    const CameraRecord record = (*load_matte_record(layout())).at(camera.serial);
    ASSERT_TRUE(record.healed.contains(0));
    EXPECT_GE(record.healed.at(0).by.size(), 4u);
    EXPECT_THAT(record.healed.at(0).by, Not(Contains(testing::AnyOfArray(broken))));
  }
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(report->contradictory_frames, 0);
  EXPECT_EQ(report->poor_frames, 0);
  EXPECT_EQ(process_take({.take = take_})->mattes.made, 0) << "what was healed is kept";
  const double healed = film();
  take_true_mattes();
  EXPECT_GE(healed, film() - kFilmLoss);
}

INSTANTIATE_TEST_SUITE_P(OfEachKind, HealedTake,
                         testing::Values(BrokenKey{"wrong_colour", keyed_red},
                                         BrokenKey{"its_colour_in_the_subject", red_lost},
                                         BrokenKey{"lamp", lamp_kept}, BrokenKey{"half_cut", half_cut}),
                         name_of);

class HealMattes : public HealedTake {};

TEST_P(HealMattes, NeverTouchesWhatAPersonPutThere) {
  Image matte = *load_png(layout().matte("cam02", 0));
  half_cut({}, matte);
  ASSERT_THAT(save_png(matte, layout().matte("cam02", 0)), IsOk());
  const std::string bytes = *read_file(layout().matte("cam02", 0));
  const Result<ProcessReport> report = process_take({.take = take_});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->healed, IsEmpty());
  ASSERT_EQ(report->faults.size(), 1u);
  EXPECT_EQ(report->faults[0].serial, "cam02");
  EXPECT_EQ(*read_file(layout().matte("cam02", 0)), bytes);
}

TEST_P(HealMattes, SaysThatTheHullLeavesSilhouettesOpenWhereItMayNotHeal) {
  const auto take = *capture::TakeReader::open(take_);
  for (const char* serial : {"cam02", "cam05"}) {  // a person's mattes, full of small holes
    Image matte = *load_png(layout().matte(serial, 0));
    red_lost(*to_rgb(*take->frame(camera_index(take->rig(), serial), 0)), matte);
    ASSERT_THAT(save_png(matte, layout().matte(serial, 0)), IsOk());
  }
  for (int run = 0; run < 2; ++run) {
    const Result<ProcessReport> report = process_take({.take = take_});
    ASSERT_THAT(report, IsOk());
    EXPECT_THAT(report->healed, IsEmpty());
    EXPECT_EQ(report->poor_frames, 1);
  }
}

TEST_P(HealMattes, ForgetsTheHealingWhenTheMatteIsMadeAgain) {
  break_key({"cam02"}, GetParam());
  ASSERT_EQ(process_take({.take = take_})->healed.size(), 1u);
  EXPECT_THAT(
      sentence(HealedCamera{.serial = "x", .frames = 1, .worst = 3, .lost = 0.62, .gained = 0, .filled = {}}),
      HasSubstr("camera 'x': 1 matte was cut anew by what the others see; that of frame 3 lacked 62 %"));
  ASSERT_THAT(process_take({.take = take_, .redo = true}), IsOk());
  EXPECT_TRUE((*load_matte_record(layout())).at("cam02").healed.empty());
}

INSTANTIATE_TEST_SUITE_P(OfOneKind, HealMattes, testing::Values(BrokenKey{"half_cut", half_cut}), name_of);

}  // namespace
}  // namespace floatstage::pipeline
