// `export mesh` is opened by Blender, which draws it as a camera of the take saw it.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/export/export_mesh.h"
#include "pipeline/export/instant.h"
#include "tests/pipeline/export/processed_take.h"
#include "tests/support/places.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// What Blender draws of `glb` by `camera` at those times, by this folder's script, and what it found in the
// file.
struct Drawn {
  nlohmann::json report;
  std::vector<Image> pictures;  // RGBA, straight alpha
};
Drawn draw_in_blender(const fs::path& glb, const RigCamera& camera, const std::vector<double>& seconds,
                      const TempFolder& folder) {
  const Eigen::Matrix4d pose = camera.cam_from_world.inverse().matrix();
  nlohmann::json rows;
  for (int r = 0; r < 4; ++r) rows.push_back({pose(r, 0), pose(r, 1), pose(r, 2), pose(r, 3)});
  const CameraModel& model = camera.model;
  folder.write("view.json", nlohmann::json{{"world_from_cam", rows},
                                           {"width", model.width},
                                           {"height", model.height},
                                           {"fy", model.fy},
                                           {"cx", model.cx},
                                           {"cy", model.cy},
                                           {"seconds", seconds}}
                                .dump());
  const fs::path script = source_folder() / "tests/pipeline/export/in_blender.py", out = folder / "blender";
  const int code = run_other(
      text("blender --background --factory-startup --python-exit-code 1 --python '", script.string(),
           "' -- '", glb.string(), "' '", (folder / "view.json").string(), "' '", out.string(), "'"),
      folder / "log");
  EXPECT_EQ(code, 0) << read_file(folder / "log").value();
  Drawn drawn;
  if (code != 0) return drawn;
  drawn.report = nlohmann::json::parse(read_file(out / "report.json").value());
  for (std::size_t i = 0; i < seconds.size(); ++i) drawn.pictures.push_back(*load_png(out / text(i, ".png")));
  return drawn;
}

// How well Blender's picture, moved by (right, down) px, covers the matte, and its colours where both are
// opaque.
struct Likeness {
  double iou, psnr;
};
Likeness compare(const Image& drawn, const StraightInstant& instant, std::size_t camera, int right = 0,
                 int down = 0) {
  const Image &photograph = instant.pictures[camera], &matte = instant.mattes[camera];
  long both = 0, either = 0;
  double squares = 0;
  for (int y = 1; y < matte.height - 1; ++y)
    for (int x = 1; x < matte.width - 1; ++x) {
      const std::uint8_t* pixel = drawn.at(x - right, y - down);
      const bool a = pixel[3] > 127, b = *matte.at(x, y) > 127;
      either += a || b;
      if (!a || !b) continue;
      ++both;
      for (int c = 0; c < 3; ++c) {
        const double d = pixel[c] - photograph.at(x, y)[c];
        squares += d * d / 3;
      }
    }
  return {static_cast<double>(both) / either, 10 * std::log10(255.0 * 255.0 * both / squares)};
}

TEST(ExportMeshToBlender, LooksAsTheCameraSawItInEveryFrame) {
  TempFolder folder;
  const fs::path take_folder =
      processed_take(folder, {.cameras = 8, .frames = 3, .width = 320, .height = 240});
  const auto report =
      export_mesh({.take = take_folder, .out = folder / "take.glb", .frames = {0, 1, 2}, .spacing = 1});
  ASSERT_THAT(report, IsOk());
  auto take = capture::TakeReader::open(take_folder);
  ASSERT_THAT(take, IsOk());
  SceneLoader loader(**take, true);
  std::vector<StraightInstant> instants;
  for (int f = 0; f < 3; ++f) {
    Result<StraightInstant> instant = load_straight_instant(**take, loader, f);
    ASSERT_THAT(instant, IsOk());
    instants.push_back(std::move(*instant));
  }
  // In the middle of each frame's time, at the synthetic studio's 25 a second.
  const Drawn drawn =
      draw_in_blender(folder / "take.glb", instants[0].rig.cameras[2], {0.02, 0.06, 0.10}, folder);
  ASSERT_EQ(drawn.pictures.size(), 3u);

  ASSERT_EQ(drawn.report["meshes"].size(), 3u);
  std::size_t faces = 0;
  for (const nlohmann::json& mesh : drawn.report["meshes"]) {
    faces += mesh["faces"].get<std::size_t>();
    EXPECT_EQ(mesh["color_attributes"].size(), 1u) << "Blender found the colours";
  }
  EXPECT_EQ(faces, report->triangles);
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(drawn.report["shown"][f], nlohmann::json::array({text("frame ", f)})) << "one frame at a time";
    const Image& picture = drawn.pictures[f];
    const Likeness own = compare(picture, instants[f], 2);
    EXPECT_GT(own.iou, 0.96) << "frame " << f;
    EXPECT_GT(own.psnr, 24) << "frame " << f;
    for (const auto& [right, down] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      EXPECT_LT(compare(picture, instants[f], 2, right, down).psnr, own.psnr - 3)
          << "it lies where it should";
    EXPECT_LT(compare(picture, instants[f], 3).iou, 0.8) << "another camera saw something else";
  }
}

}  // namespace
}  // namespace floatstage::pipeline
