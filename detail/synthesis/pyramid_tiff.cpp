// TIFF 6.0 with the JPEG tiles of its Technical Note 2: each a whole JPEG stream, without shared tables.

#include "detail/synthesis/pyramid_tiff.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <vector>

#include <tiffio.h>

#include "core/check.h"
#include "core/jpeg.h"
#include "core/text.h"
#include "detail/synthesis/tile_pyramid.h"
#include "detail/tiff_complaints.h"

namespace floatstage::detail {
namespace {

namespace fs = std::filesystem;

constexpr int kTile = 256, kQuality = 92;
constexpr double kLargestOldTiff = 4e9;  // bytes: offsets of 32 bits

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// A file as libtiff's callbacks want it.
struct OpenTiff : TiffHandle {
  File file;
};
std::FILE* file_of(thandle_t handle) {
  return static_cast<OpenTiff&>(*static_cast<TiffHandle*>(handle)).file.get();
}

tmsize_t read(thandle_t handle, void* to, tmsize_t size) {
  return static_cast<tmsize_t>(std::fread(to, 1, static_cast<std::size_t>(size), file_of(handle)));
}
tmsize_t write(thandle_t handle, void* from, tmsize_t size) {
  return static_cast<tmsize_t>(std::fwrite(from, 1, static_cast<std::size_t>(size), file_of(handle)));
}
toff_t seek(thandle_t handle, toff_t offset, int whence) {
  ::fseeko(file_of(handle), static_cast<off_t>(offset), whence);
  return static_cast<toff_t>(::ftello(file_of(handle)));
}
int close(thandle_t) { return 0; }
toff_t size(thandle_t handle) {
  const off_t here = ::ftello(file_of(handle));
  const toff_t all = seek(handle, 0, SEEK_END);
  seek(handle, static_cast<toff_t>(here), SEEK_SET);
  return all;
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

int levels_of(int width, int height) {
  int levels = 1;
  for (; std::max(width, height) > kTile; ++levels) width = (width + 1) / 2, height = (height + 1) / 2;
  return levels;
}

// Tiles of a TIFF are all of one size.
Image padded(const Image& tile) {
  if (tile.width == kTile && tile.height == kTile) return tile;
  Image out(kTile, kTile, 3);
  for (int y = 0; y < kTile; ++y)
    for (int x = 0; x < kTile; ++x)
      std::copy_n(tile.at(std::min(x, tile.width - 1), std::min(y, tile.height - 1)), 3, out.at(x, y));
  return out;
}

class PyramidTiff final : public RowWriter {
 public:
  PyramidTiff(fs::path file, int width, int height)
      : name_(std::move(file)),
        pyramid_(width, height, levels_of(width, height), kTile, 0,
                 [this](const TilePyramid::Tile& tile) { return take(tile); }),
        waiting_(static_cast<std::size_t>(pyramid_.levels())) {}
  ~PyramidTiff() override {
    tiff_.reset();
    std::error_code error;
    fs::remove(waiting_name(), error);
    if (!finished_) fs::remove(name_, error);
  }
  PyramidTiff(const PyramidTiff&) = delete;
  PyramidTiff& operator=(const PyramidTiff&) = delete;

  Result<void> open() {
    keep_complaints();
    open_.file.reset(std::fopen(name_.c_str(), "w+b"));
    if (!open_.file) return failed(name_);
    waiting_file_.reset(std::fopen(waiting_name().c_str(), "w+b"));
    if (!waiting_file_) return failed(waiting_name());
    const double most = 4.0 * pyramid_.width(0) * pyramid_.height(0);  // bytes, all levels, badly packed
    tiff_.reset(TIFFClientOpen(name_.c_str(), most > kLargestOldTiff ? "w8" : "w",
                               static_cast<TiffHandle*>(&open_), read, write, seek, close, size, nullptr,
                               nullptr));
    if (!tiff_) return failed(name_);
    describe(0);
    return {};
  }

  Result<void> add(const Image& rows) override { return pyramid_.add(rows); }

  Result<void> finish() override {
    FLOATSTAGE_CHECK(pyramid_.complete(), "a TIFF without all of its rows");
    if (TIFFWriteDirectory(tiff_.get()) != 1) return failed(name_);
    std::rewind(waiting_file_.get());
    for (int level = 1; level < pyramid_.levels(); ++level)
      if (Result<void> ok = append(level); !ok) return ok;
    tiff_.reset();
    if (std::fflush(open_.file.get()) != 0 || !open_.complaint.empty()) return failed(name_);
    finished_ = true;
    return {};
  }

 private:
  struct Waiting {
    off_t at = 0;
    std::size_t size = 0;
  };
  fs::path waiting_name() const { return name_.string() + ".levels"; }

  Result<void> failed(const fs::path& what) const {
    return fail(ErrorCode::Io, text(what.string(), ": cannot be written (",
                                    open_.complaint.empty() ? std::strerror(errno) : open_.complaint, ")"));
  }

  void describe(int level) const {
    TIFF* t = tiff_.get();
    TIFFSetField(t, TIFFTAG_SUBFILETYPE, level == 0 ? 0 : FILETYPE_REDUCEDIMAGE);
    TIFFSetField(t, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(pyramid_.width(level)));
    TIFFSetField(t, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(pyramid_.height(level)));
    TIFFSetField(t, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(t, TIFFTAG_TILELENGTH, kTile);
    TIFFSetField(t, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(t, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(t, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(t, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    TIFFSetField(t, TIFFTAG_COMPRESSION, COMPRESSION_JPEG);
    TIFFSetField(t, TIFFTAG_JPEGTABLESMODE, 0);
    TIFFSetField(t, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_YCBCR);
    TIFFSetField(t, TIFFTAG_YCBCRSUBSAMPLING, 1, 1);
  }

  Result<void> write_tile(std::uint32_t number, std::string& jpeg) {
    const auto bytes = static_cast<tmsize_t>(jpeg.size());
    return TIFFWriteRawTile(tiff_.get(), number, jpeg.data(), bytes) == bytes ? Result<void>()
                                                                              : failed(name_);
  }

  Result<void> take(const TilePyramid::Tile& tile) {
    std::string jpeg = encode_jpeg(padded(tile.picture), kQuality);
    const auto columns = static_cast<std::uint32_t>((pyramid_.width(tile.level) + kTile - 1) / kTile);
    if (tile.level == 0)
      return write_tile(
          static_cast<std::uint32_t>(tile.row) * columns + static_cast<std::uint32_t>(tile.column), jpeg);
    waiting_[static_cast<std::size_t>(tile.level)].push_back({::ftello(waiting_file_.get()), jpeg.size()});
    return std::fwrite(jpeg.data(), 1, jpeg.size(), waiting_file_.get()) == jpeg.size()
               ? Result<void>()
               : failed(waiting_name());
  }

  // They came by rows, as their numbers go.
  Result<void> append(int level) {
    describe(level);
    std::uint32_t number = 0;
    std::string jpeg;
    for (const Waiting& tile : waiting_[static_cast<std::size_t>(level)]) {
      jpeg.resize(tile.size);
      if (::fseeko(waiting_file_.get(), tile.at, SEEK_SET) != 0 ||
          std::fread(jpeg.data(), 1, tile.size, waiting_file_.get()) != tile.size)
        return failed(waiting_name());
      if (Result<void> ok = write_tile(number++, jpeg); !ok) return ok;
    }
    return TIFFWriteDirectory(tiff_.get()) == 1 ? Result<void>() : failed(name_);
  }

  const fs::path name_;
  TilePyramid pyramid_;
  std::vector<std::vector<Waiting>> waiting_;  // tiles of the smaller levels
  OpenTiff open_;
  File waiting_file_;
  std::unique_ptr<TIFF, CloseTiff> tiff_;
  bool finished_ = false;
};

}  // namespace

Result<std::unique_ptr<RowWriter>> write_pyramid_tiff(const fs::path& file, int width, int height) {
  auto writer = std::make_unique<PyramidTiff>(file, width, height);
  if (Result<void> ok = writer->open(); !ok) return forward(ok);
  return std::unique_ptr<RowWriter>(std::move(writer));
}

}  // namespace floatstage::detail
