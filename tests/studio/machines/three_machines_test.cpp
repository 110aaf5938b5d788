// The live chain over machines of their own: two capture nodes, one that reconstructs, one for the view.

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "tests/studio/machines/studio_lab.h"

namespace floatstage::studio {
namespace {

nlohmann::json json_of(const StudioLab& studio, const std::string& name) {
  const Result<std::string> bytes = read_file(studio.json_of(name));
  EXPECT_THAT(bytes, IsOk());
  return bytes ? nlohmann::json::parse(*bytes, nullptr, false) : nlohmann::json();
}

TEST(ThreeMachines, ShowTheSubjectAndOnlyTheThreeSubscribedTexturesTravel) {
  StudioLab studio;
  if (const std::string why = NetworkLab::forbidden(); !why.empty()) GTEST_SKIP() << why;
  ASSERT_TRUE(studio.lab);
  const auto left = studio.start_node(StudioLab::kLeft), right = studio.start_node(StudioLab::kRight);
  const auto recon = studio.start_recon();
  // A view that stands still: the same three cameras all the time.
  const auto view =
      studio.lab->run(StudioLab::kView,
                      {FLOATSTAGE_PROGRAM,
                       "live",
                       "view",
                       studio.recon_address(),
                       "--nodes",
                       studio.node_address(StudioLab::kLeft) + "," + studio.node_address(StudioLab::kRight),
                       "--rig",
                       (studio.folder / "rig.json").string(),
                       "--keys",
                       (studio.folder / "studio.keys").string(),
                       "--headless",
                       "--seconds",
                       "8",
                       "--orbit",
                       "1000000",
                       "--size",
                       "160x120",
                       "--target-fps",
                       "0",
                       "--json",
                       studio.json_of("view")},
                      (studio.folder / "view.log").string());
  ASSERT_EQ(view->wait(), 0) << view->output();
  for (const auto& program : {&left, &right, &recon}) {
    (*program)->terminate();
    ASSERT_EQ((*program)->wait(), 0) << (*program)->output();
  }

  const nlohmann::json seen = json_of(studio, "view"), made = json_of(studio, "recon");
  EXPECT_GT(seen["fps"].get<double>(), 0) << seen.dump(1);
  EXPECT_EQ(seen["network"]["malformed"], 0);
  EXPECT_EQ(made["from_nodes"]["malformed"], 0);

  int textured = 0;
  std::uint64_t outlines = 0, tiles = 0, outline_bytes = 0, tile_bytes = 0;
  for (const char* node : {"node0", "node1"}) {
    const nlohmann::json told = json_of(studio, node)["published"];
    textured += static_cast<int>(told["tiles_by_camera"].size());
    outlines += told["outlines"]["sent"].get<std::uint64_t>();
    outline_bytes += told["outlines"]["bytes"].get<std::uint64_t>();
    tiles += told["tiles"]["sent"].get<std::uint64_t>();
    tile_bytes += told["tiles"]["bytes"].get<std::uint64_t>();
    EXPECT_EQ(told["refused"], 0);
  }
  EXPECT_EQ(textured, 3) << "cameras whose textures travelled, of six";
  EXPECT_GT(tiles, 0u);
  EXPECT_LT(tiles, outlines) << "outlines of six cameras, textures of three";

  // What went over the cables, with headers, encryption and acknowledgements. No texture goes to the
  // reconstruction.
  const double to_recon = static_cast<double>(studio.lab->received_bytes(StudioLab::kRecon));
  const double to_view = static_cast<double>(studio.lab->received_bytes(StudioLab::kView));
  EXPECT_LT(to_recon, 2.0 * static_cast<double>(outline_bytes) + 200'000);
  EXPECT_GT(to_view, static_cast<double>(tile_bytes));
  EXPECT_GT(seen["network"]["tile_bytes_per_second"], 0);
  EXPECT_GT(made["from_nodes"]["bytes_per_second"], 0);
  std::printf(
      "cables: %.0f kB to the reconstruction, %.0f kB to the view; outlines %.0f kB, tiles %.0f kB\n%s\n%s\n",
      1e-3 * to_recon, 1e-3 * to_view, 1e-3 * static_cast<double>(outline_bytes),
      1e-3 * static_cast<double>(tile_bytes), seen["network"].dump(1).c_str(),
      made["from_nodes"].dump(1).c_str());
}

}  // namespace
}  // namespace floatstage::studio
