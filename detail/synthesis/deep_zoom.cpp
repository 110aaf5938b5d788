// Microsoft's Deep Zoom format, as the schema of 2008 describes it.

#include "detail/synthesis/deep_zoom.h"

#include <algorithm>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/text.h"

namespace floatstage::detail {
namespace {

constexpr int kTile = 254, kOverlap = 1, kQuality = 92;

// Half as large, rounded up.
Image halved(const Image& from) {
  Image out((from.width + 1) / 2, (from.height + 1) / 2, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int u = std::min(2 * x + 1, from.width - 1), v = std::min(2 * y + 1, from.height - 1);
      for (int c = 0; c < 3; ++c)
        out.at(x, y)[c] = static_cast<std::uint8_t>(
            (from.at(2 * x, 2 * y)[c] + from.at(u, 2 * y)[c] + from.at(2 * x, v)[c] + from.at(u, v)[c] + 2) /
            4);
    }
  return out;
}

Image cut(const Image& from, int x0, int y0, int x1, int y1) {
  Image out(x1 - x0, y1 - y0, 3);
  for (int y = y0; y < y1; ++y)
    std::copy_n(from.at(x0, y), 3 * static_cast<std::size_t>(out.width), out.at(0, y - y0));
  return out;
}

Result<void> save_level(const Image& picture, const std::filesystem::path& folder) {
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  for (int row = 0; row * kTile < picture.height; ++row)
    for (int column = 0; column * kTile < picture.width; ++column) {
      const Image tile =
          cut(picture, std::max(0, column * kTile - kOverlap), std::max(0, row * kTile - kOverlap),
              std::min(picture.width, (column + 1) * kTile + kOverlap),
              std::min(picture.height, (row + 1) * kTile + kOverlap));
      if (Result<void> ok = write_file(folder / text(column, "_", row, ".jpg"), encode_jpeg(tile, kQuality));
          !ok)
        return ok;
    }
  return {};
}

}  // namespace

std::filesystem::path deep_zoom_tiles(const std::filesystem::path& file) {
  return file.parent_path() / (file.stem().string() + "_files");
}

Result<void> save_deep_zoom(const Image& rgb, const std::filesystem::path& file) {
  int level = 0;
  while ((1 << level) < std::max(rgb.width, rgb.height)) ++level;
  const std::filesystem::path folder = deep_zoom_tiles(file);
  Image smaller;
  for (const Image* picture = &rgb; level >= 0; --level) {
    if (Result<void> ok = save_level(*picture, folder / text(level)); !ok) return ok;
    if (level > 0) smaller = halved(*picture);
    picture = &smaller;
  }
  return write_file(file,
                    text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Image "
                         "xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" Format=\"jpg\" Overlap=\"",
                         kOverlap, "\" TileSize=\"", kTile, "\"><Size Width=\"", rgb.width, "\" Height=\"",
                         rgb.height, "\"/></Image>\n"));
}

}  // namespace floatstage::detail
