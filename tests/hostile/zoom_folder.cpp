#include "tests/hostile/zoom_folder.h"

#include <gtest/gtest.h>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "detail/graph_json.h"
#include "tests/detail/pictures.h"
#include "tests/hostile/traps.h"
#include "tests/support/matchers.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using detail::test::photograph;
using detail::test::view_of_world;

constexpr int kWidth = 240, kHeight = 180;

// Grey: a TIFF's writer for three channels would be longer.
Image grey_photo(const Eigen::Matrix3d& view) {
  Image grey = photograph(kWidth, kHeight, view);
  for (std::size_t p = 0; p < grey.pixels.size(); p += 3)
    grey.pixels[p] = grey.pixels[p + 2] = grey.pixels[p + 1];
  return grey;
}

std::string tiff_of(const Image& grey) {
  std::string tiff = tiff_claiming(kWidth, kHeight, 122, kWidth * kHeight);
  for (std::size_t p = 0; p < grey.pixels.size(); p += 3) tiff += static_cast<char>(grey.pixels[p]);
  return tiff;
}

// Which takes a second to find.
const detail::PhotoGraph& graph_of(const fs::path& folder) {
  static const detail::PhotoGraph kGraph = [&] {
    const Result<detail::PhotoGraph> graph = detail::build_photo_graph(folder, {});
    EXPECT_THAT(graph, IsOk());
    EXPECT_EQ(graph->photos[0].parent, 1) << "a detail of the other";
    return *graph;
  }();
  return kGraph;
}

}  // namespace

void write_zoom_folder(const fs::path& folder) {
  static const std::string kWide = encode_jpeg(grey_photo(view_of_world(0, 0, 4)), 95);
  static const std::string kClose = tiff_of(grey_photo(view_of_world(330, 190, 1.5, 0.05)));
  ASSERT_THAT(write_file(folder / kWidePhoto, kWide), IsOk());
  ASSERT_THAT(write_file(folder / kClosePhoto, kClose), IsOk());
  write_zoom_graph(folder);
}

void write_zoom_graph(const fs::path& folder) {
  detail::PhotoGraph graph = graph_of(folder);
  graph.folder = folder;
  for (detail::GraphPhoto& photo : graph.photos)
    if (const Result<std::string> bytes = read_file(folder / photo.photo.name))
      photo.photo.hash = content_hash(*bytes);
  ASSERT_THAT(detail::save_graph(graph, folder / kZoomGraph), IsOk());
}

}  // namespace floatstage
