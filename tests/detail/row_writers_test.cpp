// Pictures that are written while they are made: Deep Zoom images and pyramids in a TIFF.

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>
#include <unistd.h>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "detail/photo_file.h"
#include "detail/photo_graph.h"
#include "detail/synthesis/deep_zoom.h"
#include "detail/synthesis/enlarge.h"
#include "detail/synthesis/pyramid_tiff.h"
#include "detail/synthesis/tile_pyramid.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

using test::photograph;
using test::view_of_world;

Image rows_of(const Image& picture, int from, int to) {
  Image rows(picture.width, to - from, 3);
  std::copy_n(picture.at(0, from), rows.pixels.size(), rows.pixels.begin());
  return rows;
}

// In portions that agree with nothing.
Result<void> write(RowWriter& writer, const Image& picture, int portion = 37) {
  for (int y = 0; y < picture.height; y += portion)
    if (Result<void> ok = writer.add(rows_of(picture, y, std::min(y + portion, picture.height))); !ok)
      return ok;
  return writer.finish();
}

// As one makes it with the whole picture at hand.
Image halved(const Image& from) {
  Image out((from.width + 1) / 2, (from.height + 1) / 2, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int u = std::min(2 * x + 1, from.width - 1), v = std::min(2 * y + 1, from.height - 1);
        out.at(x, y)[c] = static_cast<std::uint8_t>(
            (from.at(2 * x, 2 * y)[c] + from.at(u, 2 * y)[c] + from.at(2 * x, v)[c] + from.at(u, v)[c] + 2) /
            4);
      }
  return out;
}

TEST(ATilePyramid, GivesTheTilesOfThePictureAndItsHalvesWhateverItsSizeAndPortions) {
  for (const auto& [width, height, overlap] :
       {std::tuple(301, 203, 1), {64, 64, 0}, {1, 1, 1}, {5, 400, 3}, {129, 1, 0}}) {
    const Image picture = photograph(width, height, view_of_world(0, 0, 2));
    std::vector<Image> levels = {picture};
    while (levels.size() < 4) levels.push_back(halved(levels.back()));
    std::size_t tiles = 0, expected = 0;
    for (const Image& level : levels)
      expected += static_cast<std::size_t>(((level.width + 31) / 32) * ((level.height + 31) / 32));
    TilePyramid pyramid(width, height, 4, 32, overlap, [&](const TilePyramid::Tile& tile) -> Result<void> {
      const Image& level = levels[static_cast<std::size_t>(tile.level)];
      const int x0 = std::max(0, tile.column * 32 - overlap), y0 = std::max(0, tile.row * 32 - overlap);
      EXPECT_EQ(x0 + tile.picture.width, std::min(level.width, (tile.column + 1) * 32 + overlap));
      EXPECT_EQ(y0 + tile.picture.height, std::min(level.height, (tile.row + 1) * 32 + overlap));
      for (int y = 0; y < tile.picture.height; ++y)
        EXPECT_TRUE(std::equal(tile.picture.at(0, y), tile.picture.at(0, y) + 3 * tile.picture.width,
                               level.at(x0, y0 + y)));
      ++tiles;
      return {};
    });
    for (int y = 0; y < height; y += 7)
      ASSERT_THAT(pyramid.add(rows_of(picture, y, std::min(height, y + 7))), IsOk());
    EXPECT_TRUE(pyramid.complete());
    EXPECT_EQ(tiles, expected) << width << "x" << height;
  }
}

TEST(ADeepZoomImage, HasATileOfEveryLevelAndItsDocumentLast) {
  const TempFolder folder;
  const Image picture = photograph(300, 200, view_of_world(0, 0, 2));
  Result<std::unique_ptr<RowWriter>> writer = write_deep_zoom(folder / "z.dzi", 300, 200);
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->add(rows_of(picture, 0, 199)), IsOk());
  EXPECT_FALSE(std::filesystem::exists(folder / "z.dzi"));
  ASSERT_THAT((*writer)->add(rows_of(picture, 199, 200)), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  EXPECT_TRUE(std::filesystem::exists(folder / "z_files/0/0_0.jpg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "z_files/10"));
  EXPECT_THAT(*read_file(folder / "z.dzi"), testing::HasSubstr("<Size Width=\"300\" Height=\"200\"/>"));
  const Result<Image> tile = load_photo(folder / "z_files/9/1_0.jpg");
  ASSERT_THAT(tile, IsOk());
  ASSERT_EQ(tile->width, 300 - 253);
  Image truth(47, 200, 3);
  for (int y = 0; y < 200; ++y) std::copy_n(picture.at(253, y), 3 * 47, truth.at(0, y));
  EXPECT_GT(psnr(*tile, truth), 35);
}

TEST(APyramidTiff, IsThePictureAndItsHalvesInTiles) {
  const TempFolder folder;
  const Image picture = photograph(611, 397, view_of_world(0, 0, 2));
  {
    Result<std::unique_ptr<RowWriter>> writer = write_pyramid_tiff(folder / "z.tif", 611, 397);
    ASSERT_THAT(writer, IsOk());
    ASSERT_THAT(write(**writer, picture), IsOk());
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "z.tif.levels"));
  const Result<Image> read = load_photo(folder / "z.tif");
  ASSERT_THAT(read, IsOk());
  EXPECT_GT(psnr(*read, picture), 34) << "of so many details JPEG loses some";
  TIFF* tiff = TIFFOpen((folder / "z.tif").c_str(), "r");
  ASSERT_NE(tiff, nullptr);
  Image level = picture;
  int directories = 0;
  do {
    std::uint32_t width = 0, height = 0, kind = 9, tile = 0;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &kind);
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile);
    EXPECT_EQ(tile, 256u);
    EXPECT_EQ(kind, directories == 0 ? 0u : static_cast<std::uint32_t>(FILETYPE_REDUCEDIMAGE));
    ASSERT_EQ(static_cast<int>(width), level.width);
    ASSERT_EQ(static_cast<int>(height), level.height);
    std::vector<std::uint32_t> raster(static_cast<std::size_t>(width) * height);
    ASSERT_EQ(TIFFReadRGBAImageOriented(tiff, width, height, raster.data(), ORIENTATION_TOPLEFT, 1), 1);
    double off = 0;
    for (std::size_t i = 0; i < raster.size(); ++i)
      off += std::abs(static_cast<int>(TIFFGetG(raster[i])) - level.pixels[3 * i + 1]);
    EXPECT_LT(off / static_cast<double>(raster.size()), 4) << "directory " << directories;
    level = halved(level);
    ++directories;
  } while (TIFFReadDirectory(tiff) == 1);
  TIFFClose(tiff);
  EXPECT_EQ(directories, 3);
}

TEST(APyramidTiff, ThatWasNotFinishedLeavesNothing) {
  const TempFolder folder;
  {
    Result<std::unique_ptr<RowWriter>> writer = write_pyramid_tiff(folder / "z.tif", 300, 900);
    ASSERT_THAT((*writer)->add(Image(300, 600, 3, 9)), IsOk());
    EXPECT_TRUE(std::filesystem::exists(folder / "z.tif"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_THAT(write_pyramid_tiff(folder / "no/z.tif", 300, 900), FailsWith(ErrorCode::Io, "no/z.tif"));
}

std::size_t resident() {
  std::size_t pages = 0, here = 0;
  std::ifstream("/proc/self/statm") >> pages >> here;
  return here * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// A picture of 108 MB, made a row of tiles at a time.
TEST(RowWriters, HoldARowOfTilesAndNotThePicture) {
  if (kSanitized) GTEST_SKIP() << "sanitizers keep what was freed";
  constexpr int kSide = 6000, kRows = 250;
  const TempFolder folder;
  Image rows(kSide, kRows, 3);
  for (std::size_t i = 0; i < rows.pixels.size(); ++i)
    rows.pixels[i] = static_cast<std::uint8_t>(i / 64 + i / (3 * kSide));
  for (const bool tiff : {true, false}) {
    const std::size_t before = resident();
    std::size_t most = 0;
    Result<std::unique_ptr<RowWriter>> writer = tiff ? write_pyramid_tiff(folder / "z.tif", kSide, kSide)
                                                     : write_deep_zoom(folder / "z.dzi", kSide, kSide);
    ASSERT_THAT(writer, IsOk());
    for (int y = 0; y < kSide; y += kRows) {
      ASSERT_THAT((*writer)->add(rows), IsOk());
      most = std::max(most, resident());
    }
    ASSERT_THAT((*writer)->finish(), IsOk());
    EXPECT_LT(most - std::min(before, most), 40'000'000u) << (tiff ? "TIFF" : "Deep Zoom");
  }
}

TEST(Enlargements, ThatAreWrittenAreThoseThatAreKept) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "photos");
  ASSERT_THAT(save_png(photograph(240, 180, view_of_world(0, 0, 4)), folder / "photos/wide.png"), IsOk());
  ASSERT_THAT(save_png(photograph(240, 180, view_of_world(330, 190, 1.5)), folder / "photos/close.png"),
              IsOk());
  const Result<PhotoGraph> graph = build_photo_graph(folder / "photos", {});
  ASSERT_THAT(graph, IsOk());
  struct Kept : RowWriter {
    explicit Kept(Image& picture) : to(picture) {}
    Result<void> add(const Image& rows) override {
      to.pixels.insert(to.pixels.end(), rows.pixels.begin(), rows.pixels.end());
      return {};
    }
    Result<void> finish() override { return {}; }
    Image& to;
  };
  EnlargeOptions options;
  options.zoom = 2;
  options.tile = 50;  // rounded to whole pixels of the root
  const Result<Enlargement> kept = enlarge(*graph, options);
  ASSERT_THAT(kept, IsOk());
  Image written(480, 360, 3), large = written;
  written.pixels.clear(), large.pixels.clear();
  options.writer = [&](int width, int height) -> Result<std::unique_ptr<RowWriter>> {
    EXPECT_EQ(width, 480);
    EXPECT_EQ(height, 360);
    return std::unique_ptr<RowWriter>(std::make_unique<Kept>(written));
  };
  const Result<Enlargement> streamed = enlarge(*graph, options);
  ASSERT_THAT(streamed, IsOk());
  EXPECT_TRUE(streamed->picture.empty());
  EXPECT_EQ(streamed->like_root, kept->like_root);
  EXPECT_EQ(written.pixels, kept->picture.pixels);
  // As if it did not fit into memory: the photographs meet elsewhere, and lie at the same place.
  options.in_memory = 1000;
  options.writer = [&](int, int) -> Result<std::unique_ptr<RowWriter>> {
    return std::unique_ptr<RowWriter>(std::make_unique<Kept>(large));
  };
  const Result<Enlargement> beyond = enlarge(*graph, options);
  ASSERT_THAT(beyond, IsOk());
  EXPECT_GT(psnr(large, kept->picture), 32) << "dB";
  EXPECT_NEAR(beyond->shares[3] + beyond->shares[2], kept->shares[3] + kept->shares[2], 0.02);
}

}  // namespace
}  // namespace floatstage::detail
