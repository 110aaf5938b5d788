// Microsoft's Deep Zoom format, as the schema of 2008 describes it.

#include "detail/synthesis/deep_zoom.h"

#include <algorithm>

#include "core/check.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/text.h"
#include "detail/synthesis/tile_pyramid.h"

namespace floatstage::detail {
namespace {

constexpr int kTile = 254, kOverlap = 1, kQuality = 92;

// Down to one pixel.
int levels_of(int width, int height) {
  int level = 0;
  while ((1 << level) < std::max(width, height)) ++level;
  return level + 1;
}

class DeepZoomWriter final : public RowWriter {
 public:
  DeepZoomWriter(std::filesystem::path file, int width, int height)
      : file_(std::move(file)),
        pyramid_(width, height, levels_of(width, height), kTile, kOverlap,
                 [this](const TilePyramid::Tile& tile) {
                   return write_file(folder_of(tile.level) / text(tile.column, "_", tile.row, ".jpg"),
                                     encode_jpeg(tile.picture, kQuality));
                 }) {}

  Result<void> make_folders() const {
    for (int level = 0; level < pyramid_.levels(); ++level)
      if (Result<void> ok = make_folder(folder_of(level)); !ok) return ok;
    return {};
  }
  Result<void> add(const Image& rows) override { return pyramid_.add(rows); }
  Result<void> finish() override {
    FLOATSTAGE_CHECK(pyramid_.complete(), "a Deep Zoom image without all of its rows");
    return write_file(
        file_, text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Image "
                    "xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" Format=\"jpg\" Overlap=\"",
                    kOverlap, "\" TileSize=\"", kTile, "\"><Size Width=\"", pyramid_.width(0), "\" Height=\"",
                    pyramid_.height(0), "\"/></Image>\n"));
  }

 private:
  // Deep Zoom counts from the smallest.
  std::filesystem::path folder_of(int level) const {
    return deep_zoom_tiles(file_) / text(pyramid_.levels() - 1 - level);
  }
  const std::filesystem::path file_;
  TilePyramid pyramid_;
};

}  // namespace

std::filesystem::path deep_zoom_tiles(const std::filesystem::path& file) {
  return file.parent_path() / (file.stem().string() + "_files");
}

Result<std::unique_ptr<RowWriter>> write_deep_zoom(const std::filesystem::path& file, int width, int height) {
  auto writer = std::make_unique<DeepZoomWriter>(file, width, height);
  if (Result<void> ok = writer->make_folders(); !ok) return forward(ok);
  return std::unique_ptr<RowWriter>(std::move(writer));
}

}  // namespace floatstage::detail
