#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "calib/surface_colors.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/rig_io.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"
#include "pipeline/scene_loader.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

// A camera with its own white balance and gamma. The first is as it should be.
struct OddCamera {
  Eigen::Vector3d gain, gamma;
  Eigen::Vector3d see(const Eigen::Vector3d& rgb) const {
    return (gain.array() * rgb.array().pow(2.2)).min(1.0).pow(1 / gamma.array());
  }
};
OddCamera odd(int camera) {
  const OddCamera kinds[] = {{{1, 1, 1}, {2.2, 2.2, 2.2}},         {{0.85, 0.95, 0.7}, {2.2, 2.2, 2.2}},
                             {{0.7, 0.9, 0.95}, {1.9, 1.9, 1.9}},  {{0.95, 0.8, 0.7}, {2.5, 2.4, 2.6}},
                             {{0.75, 0.75, 0.9}, {2.1, 2.2, 2.3}}, {{0.9, 0.85, 0.8}, {1.8, 2, 1.9}}};
  return kinds[camera % 6];
}

Image through(const Image& image, const OddCamera& camera) {
  Image out = image;
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
    const Eigen::Vector3d seen =
        camera.see(Eigen::Vector3d(image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]) / 255);
    for (std::size_t c = 0; c < 3; ++c)
      out.pixels[i + c] = static_cast<std::uint8_t>(
          std::lround(255 * std::clamp(seen[static_cast<Eigen::Index>(c)], 0.0, 1.0)));
  }
  return out;
}

Result<void> run(const std::string& arguments) {
  CLI::App app;
  Chosen chosen;
  add_calibrate_color(app, chosen);
  app.parse("color " + arguments);
  return chosen.run();
}

struct Studio {
  Rig rig;
  std::vector<Image> truth;  // the first instant as the first camera's kind would see it
  std::vector<Matte> mattes;
};

// Eight odd cameras around the dancer, three instants, with the meshes that `process` would leave.
Studio make_take(const std::filesystem::path& folder) {
  SyntheticRigOptions ring;
  ring.cameras = 8, ring.width = 400, ring.height = 300;
  Studio out{synthetic_rig(ring), {}, {}};
  const Result<SyntheticStudio> studio = SyntheticStudio::create(out.rig, {.samples = 4});
  EXPECT_THAT(studio, IsOk());
  const auto writer =
      capture::TakeWriter::create(folder, out.rig, {.frame_rate = 5, .label = {}, .created = {}});
  EXPECT_THAT(writer, IsOk());
  for (int frame = 0; frame < 3; ++frame)
    for (int camera = 0; camera < 8; ++camera) {
      const SyntheticShot shot = studio->shoot(camera, 10 * frame);
      const Result<Image> image = to_rgb(shot.frame);
      FrameInfo info;
      info.camera = camera, info.sequence = static_cast<std::uint64_t>(frame),
      info.exposure_start = Timestamp{frame * 200'000'000LL};
      EXPECT_THAT((*writer)->write(make_frame(info, through(*image, odd(camera)))), IsOk());
      if (frame == 0) out.truth.push_back(*image), out.mattes.push_back(shot.matte);
    }
  EXPECT_THAT((*writer)->finish(), IsOk());
  const TakeLayout layout(folder);
  EXPECT_THAT(make_folder(layout.meshes()), IsOk());
  for (int frame = 0; frame < 3; ++frame)
    EXPECT_THAT(save_ply(studio->performer(10 * frame), layout.mesh(frame)), IsOk());
  return out;
}

TEST(CalibrateColor, BringsCamerasOfOtherWhiteBalanceAndGammaTogether) {
  const TempFolder folder;
  const Studio studio = make_take(folder / "take");
  const std::string serial = studio.rig.cameras[0].serial;
  ASSERT_THAT(run(text((folder / "take").string(), " --out ", (folder / "rig.json").string(), " --report ",
                       (folder / "report").string(), " --reference ", serial)),
              IsOk());
  const Result<Rig> rig = load_rig(folder / "rig.json");
  ASSERT_THAT(rig, IsOk());
  for (std::size_t camera = 0; camera < 8; ++camera) {
    // Every pixel of the dancer, against how the first camera's kind would have shown it.
    const Image seen = through(studio.truth[camera], odd(static_cast<int>(camera)));
    double before = 0, after = 0;
    int count = 0;
    for (int y = 0; y < 300; y += 2)
      for (int x = 0; x < 400; x += 2) {
        const auto rgb = [&](const Image& image) {
          return Eigen::Vector3d(Eigen::Vector3d(image.at(x, y)[0], image.at(x, y)[1], image.at(x, y)[2]) /
                                 255);
        };
        const Eigen::Vector3d s = rgb(seen), t = rgb(studio.truth[camera]);
        if (studio.mattes[camera].row(y)[x] < 255 || s.minCoeff() < 0.02 || s.maxCoeff() > 0.99) continue;
        before += calib::delta_e_2000(calib::lab_from_srgb(s), calib::lab_from_srgb(t));
        after += calib::delta_e_2000(calib::lab_from_srgb(apply(rig->cameras[camera].color, s)),
                                     calib::lab_from_srgb(t));
        ++count;
      }
    ASSERT_GT(count, 500);
    std::printf("camera %zu: dE00 %.2f before, %.2f after, %d pixels\n", camera, before / count,
                after / count, count);
    EXPECT_LE(after / count, 1.5) << camera;
    if (camera % 6 > 0) {
      EXPECT_GT(before / count, 3) << camera;
    }
  }
  const nlohmann::json report = nlohmann::json::parse(*read_file(folder / "report" / "color.json"));
  EXPECT_EQ(report["pass"], true);
  ASSERT_EQ(report["cameras"].size(), 8u);
  EXPECT_LE(report["cameras"][3]["delta_e"].get<double>(), 1.5);
  EXPECT_GT(report["cameras"][3]["delta_e_before"].get<double>(), 3);
  EXPECT_NE(read_file(folder / "report" / "color.html")->find("PASS"), std::string::npos);
}

Image chart(const OddCamera& camera) {
  Image image(360, 260, 3, 25);
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3d seen = camera.see(calib::chart_colors()[static_cast<std::size_t>(i)]);
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(35 + i % 6 * 50 + x, 35 + i / 6 * 50 + y)[c] =
              static_cast<std::uint8_t>(std::lround(255 * seen[c]));
  }
  return image;
}

TEST(CalibrateColor, IsUsedByTheRendererOfTheTakeFromThenOn) {
  const TempFolder folder;
  const Rig rig = synthetic_rig({.cameras = 2, .width = 360, .height = 260});
  const auto writer =
      capture::TakeWriter::create(folder / "take", rig, {.frame_rate = 5, .label = {}, .created = {}});
  for (int camera = 0; camera < 2; ++camera) {
    FrameInfo info;
    info.camera = camera;
    ASSERT_THAT((*writer)->write(make_frame(info, chart(odd(camera + 1)))), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / "take");
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE(pipeline::rig_with_colors(**take)->cameras[1].color.is_identity());
  ASSERT_THAT(run((folder / "take").string() + " --chart"), IsOk());
  const Result<Rig> colored = pipeline::rig_with_colors(**take);
  ASSERT_THAT(colored, IsOk());
  EXPECT_FALSE(colored->cameras[1].color.is_identity());
  EXPECT_EQ(colored->cameras[1].cam_from_world.translation,
            (*take)->rig().cameras[1].cam_from_world.translation);
  ASSERT_THAT(
      save_rig(synthetic_rig({.cameras = 1, .width = 360, .height = 260}), (*take)->layout().colors()),
      IsOk());
  EXPECT_THAT(pipeline::rig_with_colors(**take),
              FailsWith(ErrorCode::BadData, "camera 'cam01' is not in it"));
}

TEST(CalibrateColor, SaysWhatIsMissing) {
  const TempFolder folder;
  const auto writer =
      capture::TakeWriter::create(folder / "take", synthetic_rig({.cameras = 2, .width = 64, .height = 48}),
                                  {.frame_rate = 5, .label = {}, .created = {}});
  for (int camera = 0; camera < 2; ++camera) {
    FrameInfo info;
    info.camera = camera;
    ASSERT_THAT((*writer)->write(make_frame(info, Image(64, 48, 3, 90))), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  const std::string take = (folder / "take").string(), out = " --out " + (folder / "rig.json").string();
  EXPECT_THAT(run(take + out), FailsWith(ErrorCode::NotFound, "floatstage process"));
  EXPECT_THAT(run(take + out + " --chart"),
              FailsWith(ErrorCode::NotFound, "camera 'cam00': no 24-patch colour chart"));
  EXPECT_FALSE(std::filesystem::exists(folder / "rig.json"));
}

TEST(CalibrateColor, ReadsAChartThatEveryCameraWasShown) {
  const TempFolder folder;
  const auto writer =
      capture::TakeWriter::create(folder / "take", synthetic_rig({.cameras = 3, .width = 360, .height = 260}),
                                  {.frame_rate = 5, .label = {}, .created = {}});
  for (int frame = 0; frame < 3; ++frame)
    for (int camera = 0; camera < 3; ++camera) {
      FrameInfo info;
      info.camera = camera, info.sequence = static_cast<std::uint64_t>(frame),
      info.exposure_start = Timestamp{frame * 200'000'000LL};
      ASSERT_THAT((*writer)->write(
                      make_frame(info, frame == camera ? chart(odd(camera + 1)) : Image(360, 260, 3, 60))),
                  IsOk());
    }
  ASSERT_THAT((*writer)->finish(), IsOk());
  ASSERT_THAT(run(text((folder / "take").string(), " --chart --out ", (folder / "rig.json").string(),
                       " --json ", (folder / "r.json").string())),
              IsOk());
  const Result<Rig> rig = load_rig(folder / "rig.json");
  ASSERT_THAT(rig, IsOk());
  for (int camera = 0; camera < 3; ++camera) {
    double mean = 0;
    for (const Eigen::Vector3d& rgb : calib::chart_colors())
      mean +=
          calib::delta_e_2000(calib::lab_from_srgb(apply(rig->cameras[static_cast<std::size_t>(camera)].color,
                                                         odd(camera + 1).see(rgb))),
                              calib::lab_from_srgb(rgb)) /
          24;
    EXPECT_LE(mean, 1.5) << camera;
  }
  EXPECT_EQ(nlohmann::json::parse(*read_file(folder / "r.json"))["pass"], true);
}

TEST(DepthMap, IsThatOfTheNearerSurface) {
  RigCamera camera{.serial = "a",
                   .model = {.width = 40, .height = 40, .fx = 40, .fy = 40, .cx = 20, .cy = 20, .lens = {}},
                   .cam_from_world = {},
                   .color = {}};
  Mesh mesh;
  for (const float z : {2.f, 3.f}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const float s = z == 2.f ? 0.4f : 1.2f;
    for (const auto& [x, y] : {std::pair{-s, -s}, {s, -s}, {s, s}, {-s, s}})
      mesh.positions.emplace_back(x, y, z);
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.triangles.push_back(first + i);
  }
  const std::vector<float> depth = calib::depth_map(mesh, camera);
  EXPECT_FLOAT_EQ(depth[20 * 40 + 20], 2);
  EXPECT_FLOAT_EQ(depth[20 * 40 + 6], 3);
  EXPECT_TRUE(std::isinf(depth[20 * 40 + 1]));
}

}  // namespace
}  // namespace floatstage::apps
