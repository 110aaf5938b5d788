// `export mesh` is read back by assimp's program, and by tinygltf.
#include "pipeline/export/export_mesh.h"

#include <gmock/gmock.h>

#include "core/file.h"
#include "core/mesh_io.h"
#include "core/rig_io.h"
#include "pipeline/export/surface_sights.h"
#include "tests/pipeline/export/processed_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// What assimp says of a file; its meshes are listed with vertices and faces.
std::string assimp_info(const fs::path& file, const fs::path& log) {
  fs::remove(log);
  EXPECT_EQ(run_other(text("assimp info '", file.string(), "'"), log), 0);
  return read_file(log).value();
}

double number_after(const std::string& words, const std::string& label) {
  const std::size_t at = words.find(label);
  return at == std::string::npos ? std::nan("") : std::atof(words.c_str() + at + label.size());
}

TEST(ExportMesh, IsOneAnimatedFileThatAssimpReads) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 3});
  const Result<ExportMeshReport> report =
      export_mesh({.take = take, .out = folder / "take.glb", .frames = {0, 1, 2}, .spacing = 4});
  ASSERT_THAT(report, IsOk());
  const std::string words = assimp_info(folder / "take.glb", folder / "log");
  EXPECT_EQ(number_after(words, "Meshes:"), 3) << words;
  EXPECT_EQ(number_after(words, "Animations:"), 1) << words;
  EXPECT_EQ(number_after(words, "Animation Channels:"), 3) << words;
  EXPECT_EQ(number_after(words, "Faces:"), static_cast<double>(report->triangles)) << words;
  EXPECT_THAT(words, HasSubstr("frame 2"));
}

// assimp's own text of a mesh: "v x y z r g b" lines of a wavefront file.
std::vector<Eigen::Vector3d> positions_in_obj(const std::string& obj) {
  std::vector<Eigen::Vector3d> found;
  for (std::size_t at = obj.find("\nv "); at != std::string::npos; at = obj.find("\nv ", at + 1)) {
    Eigen::Vector3d p;
    if (std::sscanf(obj.c_str() + at, "\nv %lf %lf %lf", &p.x(), &p.y(), &p.z()) == 3) found.push_back(p);
  }
  return found;
}

TEST(ExportMesh, StandsUprightInEitherConvention) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1});
  for (const auto& [up, axis] : {std::pair{GlbUp::Y, 1}, std::pair{GlbUp::Z, 2}}) {
    const fs::path out = folder / text("up", axis);
    ASSERT_THAT(export_mesh({.take = take, .out = out, .frames = {0}, .spacing = 8, .up = up}), IsOk());
    ASSERT_EQ(run_other(text("assimp export '", (out / "000000.glb").string(), "' '",
                             (out / "a.obj").string(), "' -ptv"),
                        folder / "log"),
              0);
    const std::vector<Eigen::Vector3d> positions = positions_in_obj(read_file(out / "a.obj").value());
    ASSERT_GT(positions.size(), 100u);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : positions) box.extend(p);
    Eigen::Index tallest = 0;
    box.sizes().maxCoeff(&tallest);
    EXPECT_EQ(tallest, axis);
    EXPECT_NEAR(box.min()[axis], 0, 0.1) << "the performer stands on the floor";
  }
}

// Colours of a mesh: how far they are from a photograph where it sees them.
TEST(ExportMesh, HasTheColoursOfThePhotographs) {
  TempFolder folder;
  const fs::path folder_of_take = processed_take(folder, {.cameras = 8, .frames = 1});
  auto take = capture::TakeReader::open(folder_of_take);
  ASSERT_THAT(take, IsOk());
  SceneLoader loader(**take, true);
  const Result<StraightInstant> instant = load_straight_instant(**take, loader, 0);
  ASSERT_THAT(instant, IsOk());
  const SurfaceSights sights(*instant);
  const std::vector<Rgb> colors = colors_of_vertices(*instant, sights, instant->mesh);
  double sum = 0;
  int seen = 0;
  for (std::size_t v = 0; v < colors.size(); ++v)
    for (std::size_t c = 0; c < instant->rig.cameras.size(); ++c) {
      const auto pixel = sights.see(c, instant->mesh.positions[v].cast<double>());
      if (!pixel) continue;
      const std::uint8_t* there =
          instant->pictures[c].at(static_cast<int>(pixel->x()), static_cast<int>(pixel->y()));
      for (std::size_t k = 0; k < 3; ++k) sum += std::abs(there[k] - colors[v][k]);
      ++seen;
    }
  ASSERT_GT(seen, 1000);
  EXPECT_LT(sum / (3 * seen), 20) << "levels of 255, stripes of a few pixels and outlines included";
}

TEST(ExportMesh, RefusesWhatCannotBe) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1});
  EXPECT_THAT(export_mesh({.take = take, .out = folder / "a.obj", .frames = {0}}),
              FailsWith(ErrorCode::InvalidArgument, "name a .glb"));
  EXPECT_THAT(export_mesh({.take = take, .out = folder / "a", .frames = {0}, .spacing = 0}),
              FailsWith(ErrorCode::InvalidArgument, "--spacing"));
  EXPECT_THAT(export_mesh({.take = take, .out = folder / "a", .frames = {0}, .spacing = 1e-4}),
              FailsWith(ErrorCode::InvalidArgument, "larger --spacing"));
  folder.write("b.glb", "yesterday's");
  EXPECT_THAT(export_mesh({.take = take, .out = folder / "b.glb", .frames = {0}}),
              FailsWith(ErrorCode::AlreadyExists, "b.glb"));
  EXPECT_THAT(folder.names(), testing::ElementsAre("b.glb", "take"));
}

}  // namespace
}  // namespace floatstage::pipeline
