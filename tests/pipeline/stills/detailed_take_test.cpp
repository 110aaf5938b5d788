// Parts II and IV of the thesis joined: close stills of the performer, found in the studio's photographs,
// make views from close by sharper. Truth is the synthetic studio seen by the view's own camera, which no
// still has.
#include "pipeline/stills/detailed_take.h"

#include <fstream>

#include <gtest/gtest.h>

#include "capture/derivation.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "pipeline/export/instant.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "render/method_renderers.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kCameras = 12;

SynthesizeOptions studio_take(const fs::path& out, std::uint64_t seed = 1) {
  SynthesizeOptions options;
  options.out = out;
  options.rig.cameras = kCameras;
  options.rig.width = 1024;
  options.rig.height = 768;
  options.studio.seed = seed;
  options.studio.defects.noise = 1;
  options.frames = 1;
  return options;
}

/// What a long lens at `eye` sees of a sphere about `target`.
View close_view(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double radius, int width,
                int height) {
  View view;
  const double distance = (eye - target).norm();
  view.model.width = width, view.model.height = height;
  view.model.fx = view.model.fy = 0.5 * height * distance / radius;
  view.model.cx = 0.5 * width, view.model.cy = 0.5 * height;
  view.view_from_world = look_at(eye, target, Eigen::Vector3d::UnitZ());
  return view;
}

/// A point of the ring of cameras, `turn` cameras on from camera 0.
Eigen::Vector3d on_ring(const Rig& rig, double turn, double up = 0) {
  const auto at = [&](int c) {
    return rig.cameras[static_cast<std::size_t>(c % kCameras)].cam_from_world.center();
  };
  const int before = static_cast<int>(std::floor(turn)) + kCameras;
  const double t = turn - std::floor(turn);
  return (1 - t) * at(before) + t * at(before + 1) + Eigen::Vector3d(0, 0, up);
}

class DetailedTake : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    const SynthesizeOptions options = studio_take(take());
    ASSERT_THAT(synthesize_take(options), IsOk());
    ASSERT_THAT(process_take({.take = take(), .matte = "chroma", .hull = recon::HullOptions{}}), IsOk());
    studio_ = new SyntheticStudio(std::move(*SyntheticStudio::create(true_rig(options), options.studio)));
    const Mesh performer = studio_->performer(0);
    double top = -1;
    for (const Eigen::Vector3f& p : performer.positions) top = std::max(top, static_cast<double>(p.z()));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const Eigen::Vector3f& p : performer.positions)
      if (static_cast<double>(p.z()) > top - 0.1) sum += p.cast<double>(), ++count;
    face_ = sum / count - Eigen::Vector3d(0, 0, 0.1);
    chest_ = face_ - Eigen::Vector3d(0, 0, 0.4);
  }
  static void TearDownTestSuite() {
    delete studio_, studio_ = nullptr;
    delete shared_, shared_ = nullptr;
  }
  static fs::path take() { return *shared_ / "take"; }

  static Image photographed(const SyntheticStudio& studio, const View& view) {
    return *to_rgb(studio.shoot_view(view, 0).frame);
  }
  /// Stills of the face and the print, from beside two cameras and above them, four times as fine.
  static fs::path stills(const SyntheticStudio& studio, const fs::path& folder) {
    fs::create_directories(folder);
    const Rig& rig = studio.true_rig();
    const auto shoot = [&](const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double radius,
                           const char* name) {
      EXPECT_THAT(save_png(photographed(studio, close_view(eye, target, radius, 480, 480)), folder / name),
                  IsOk());
    };
    shoot(on_ring(rig, 0.12, 0.05), face_, 0.14, "face.png");
    shoot(on_ring(rig, -0.1, 0.05), chest_, 0.25, "print.png");
    return folder;
  }
  /// `floating` from here, with what the take's photographs show.
  static Image drawn(const fs::path& folder, const View& view, const std::string& method = "floating") {
    auto reader = std::move(*capture::TakeReader::open(folder));
    SceneLoader loader(*reader, true);
    Result<SceneFrame> frame = loader.load(0);
    EXPECT_THAT(frame, IsOk());
    render::Scene scene;
    EXPECT_THAT(scene.set(reader->rig(), *frame), IsOk());
    render::MethodRenderers renderers;
    render::RendererOptions options;
    options.back_end = render::BackEnd::Cpu;
    const auto picture = renderers.render(method, scene, view, options);
    EXPECT_THAT(picture, IsOk());
    return render::download(*picture);
  }
  static Image rgb_of(const Image& rgba) {
    Image rgb(rgba.width, rgba.height, 3);
    for (std::size_t i = 0; i < rgb.pixels.size() / 3; ++i)
      std::copy_n(&rgba.pixels[4 * i], 3, &rgb.pixels[3 * i]);
    return rgb;
  }
  /// Where truth and picture both show the performer.
  static Image mask_of(const Matte& truth, const Image& rgba) {
    Image mask = to_image(truth);
    for (std::size_t i = 0; i < mask.pixels.size(); ++i)
      mask.pixels[i] = mask.pixels[i] >= 250 && rgba.pixels[4 * i + 3] >= 250 ? 255 : 0;
    return mask;
  }

  static TempFolder* shared_;
  static SyntheticStudio* studio_;
  static Eigen::Vector3d face_, chest_;
};

TempFolder* DetailedTake::shared_ = nullptr;
SyntheticStudio* DetailedTake::studio_ = nullptr;
Eigen::Vector3d DetailedTake::face_, DetailedTake::chest_;

TEST_F(DetailedTake, ShowsFaceAndPrintFromCloseByMoreLikeTheTruth) {
  const fs::path out = *shared_ / "close";
  const auto report =
      add_detail({.take = take(), .out = out, .stills = stills(*studio_, *shared_ / "stills")});
  ASSERT_THAT(report, IsOk());
  struct Place {
    const char* name;
    Eigen::Vector3d target;
    double turn, radius, decibels;
  };
  for (const Place& place : {Place{"face", face_, 0.5, 0.17, 0.3}, Place{"print", chest_, 0.4, 0.25, 0}}) {
    const View view =
        close_view(on_ring(studio_->true_rig(), place.turn), place.target, place.radius, 400, 400);
    const SyntheticShot truth = studio_->shoot_view(view, 0);
    const Image before = drawn(take(), view), after = drawn(out, view), truth_rgb = *to_rgb(truth.frame);
    const Image mask = mask_of(truth.matte, after);
    const Image a = rgb_of(before), b = rgb_of(after);
    std::printf("%s: psnr %.2f -> %.2f, cw-ssim %.4f -> %.4f, ssim %.4f -> %.4f, sharpness %.3f -> %.3f\n",
                place.name, psnr(a, truth_rgb, mask), psnr(b, truth_rgb, mask), cw_ssim(a, truth_rgb, mask),
                cw_ssim(b, truth_rgb, mask), ssim(a, truth_rgb, mask), ssim(b, truth_rgb, mask),
                sharpness(a, truth_rgb, mask), sharpness(b, truth_rgb, mask));
    EXPECT_GT(psnr(b, truth_rgb, mask), psnr(a, truth_rgb, mask) + place.decibels) << place.name;
    EXPECT_GT(cw_ssim(b, truth_rgb, mask), cw_ssim(a, truth_rgb, mask) + 0.02) << place.name;
  }
}

TEST_F(DetailedTake, IsTheSameInstantWithLargerPhotographsWhereStillsGaveSomething) {
  const fs::path out = *shared_ / "larger";
  const auto report =
      add_detail({.take = take(), .out = out, .stills = stills(*studio_, *shared_ / "some"), .zoom = 2});
  ASSERT_THAT(report, IsOk());
  const auto before = std::move(*capture::TakeReader::open(take())),
             after = std::move(*capture::TakeReader::open(out));
  ASSERT_EQ(after->frame_count(), 1);
  SceneLoader loader(*before, true);
  const Result<StraightInstant> instant = load_straight_instant(*before, loader, 0);
  ASSERT_THAT(instant, IsOk());
  int larger = 0;
  for (std::size_t c = 0; c < report->cameras.size(); ++c) {
    const DetailedCamera& of = report->cameras[c];
    const RigCamera &was = before->rig().cameras[c], &is = after->rig().cameras[c];
    EXPECT_EQ(is.model.width, was.model.width * of.zoom);
    EXPECT_EQ(is.model.fx, was.model.fx * of.zoom);
    EXPECT_EQ(fs::exists(out / "detail" / (of.serial + ".png")), of.zoom > 1);
    if (of.zoom == 1) {
      EXPECT_EQ(*to_rgb(*after->frame(static_cast<int>(c), 0)), instant->pictures[c]) << of.serial;
    }
    larger += of.zoom > 1 ? 1 : 0;
  }
  EXPECT_GE(larger, 2);
  EXPECT_LT(larger, kCameras) << "from behind nobody sees the print";
  EXPECT_THAT((*capture::load_derivation(out))->how, HasSubstr("add-detail"));
  ASSERT_THAT(process_take({.take = out}), IsOk()) << "mattes and hull are there";
}

TEST_F(DetailedTake, RefusesStillsOfAnotherPersonAndSaysWhy) {
  SynthesizeOptions other = studio_take(*shared_ / "other", 77);
  const SyntheticStudio somebody = std::move(*SyntheticStudio::create(true_rig(other), other.studio));
  const fs::path folder = stills(somebody, *shared_ / "wrong"), out = *shared_ / "refused";
  ASSERT_THAT(save_png(somebody.plate(3), folder / "room.png"), IsOk());
  fs::remove(folder / "print.png");  // both wear one print, so that this still is right
  const auto report = add_detail({.take = take(), .out = out, .stills = folder});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::NotFound);
  EXPECT_THAT(report.error().message,
              AllOf(HasSubstr("face.png"), HasSubstr("room.png"), HasSubstr("camera '")));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(DetailedTake, SaysWhatIsWrongWithTheStillsFolder) {
  const fs::path out = *shared_ / "none", empty = *shared_ / "empty";
  fs::create_directories(empty);
  EXPECT_THAT(add_detail({.take = take(), .out = out, .stills = *shared_ / "nowhere"}),
              FailsWith(ErrorCode::NotFound, "no such folder"));
  EXPECT_THAT(add_detail({.take = take(), .out = out, .stills = empty}),
              FailsWith(ErrorCode::NotFound, "no photograph in it"));
  std::ofstream(empty / "cut.png") << "\x89PNG";
  const auto damaged = add_detail({.take = take(), .out = out, .stills = empty});
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message, HasSubstr("cut.png"));
  EXPECT_THAT(add_detail({.take = take(), .out = out, .stills = empty, .zoom = 99}),
              FailsWith(ErrorCode::InvalidArgument, "--zoom 99"));
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace floatstage::pipeline
