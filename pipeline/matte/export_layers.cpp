#include "pipeline/matte/export_layers.h"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>

#include "capture/take.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/foreground.h"
#include "pipeline/exr_file.h"
#include "pipeline/keying.h"
#include "pipeline/matte_record.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

Image joined(const Image& rgb, const Image& alpha) {
  Image out(rgb.width, rgb.height, 4);
  for (std::size_t p = 0; p < alpha.pixels.size(); ++p) {
    std::copy_n(rgb.pixels.data() + 3 * p, 3, out.pixels.data() + 4 * p);
    out.pixels[4 * p + 3] = alpha.pixels[p];
  }
  return out;
}

// A layer that lies there already, made after its matte and in this format: what an interrupted export goes
// on from.
bool up_to_date(const fs::path& layer, const fs::path& matte, const std::string& format) {
  std::error_code none;
  if (!fs::exists(layer, none) || fs::last_write_time(layer, none) < fs::last_write_time(matte, none))
    return false;
  if (format == "exr") return true;
  constexpr std::streamoff kBitDepth = 24;  // in a PNG's header
  std::ifstream png(layer, std::ios::binary);
  png.seekg(kBitDepth);
  return png.get() == (format == "png16" ? 16 : 8);
}

Result<void> save(const Image& rgba, const std::string& format, const fs::path& file) {
  if (format == "exr") return save_exr(rgba, file, ExrAlpha::Straight);
  return format == "png16" ? save_png16(rgba, file) : save_png(rgba, file);
}

// Where a camera was keyed by chroma, its keyer knows which light is the cloth's.
Result<Image> photograph_of(capture::TakeReader& take, int camera, const Frame& frame,
                            const std::string& key) {
  if (!key.starts_with("chroma:")) return to_rgb(frame);
  Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, camera, key);
  if (!keyer) return forward(keyer);
  return (*keyer)->suppress_spill(frame);
}

Result<void> export_one(capture::TakeReader& take, int camera, int frame, const std::string& key,
                        const std::string& format, const fs::path& file) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  Result<Image> matte = load_png(take.layout().matte(serial, frame));
  if (!matte) return forward(matte);
  Result<Frame> photograph = take.frame(camera, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return {};
  Result<Image> rgb = photograph_of(take, camera, *photograph, key);
  if (!rgb) return forward(rgb);
  Result<matting::Layers> layers = matting::estimate_foreground(*rgb, *matte);
  if (!layers) return forward(layers);
  return save(joined(layers->foreground, *matte), format, file);
}

}  // namespace

Result<int> export_layers(const ExportOptions& options) {
  if (options.format != "png8" && options.format != "png16" && options.format != "exr")
    return fail(ErrorCode::InvalidArgument,
                text("'", options.format, "' is no format of layers; there are png8, png16 and exr"));
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  capture::TakeReader& take = **opened;
  const Result<MatteRecord> made = load_matte_record(take.layout());
  if (!made) return forward(made);
  const auto key_of = [&](std::size_t camera) -> std::string {
    const auto found = made->find(take.rig().cameras[camera].serial);
    return found == made->end() ? std::string() : found->second.key;
  };
  struct Item {
    int camera, frame;
    std::string key;
    fs::path matte, file;
  };
  std::vector<Item> items;
  for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
    const std::string& serial = take.rig().cameras[c].serial;
    if (!options.cameras.empty() &&
        std::find(options.cameras.begin(), options.cameras.end(), serial) == options.cameras.end())
      continue;
    if (Result<void> ok = make_folder(options.out / serial); !ok) return forward(ok);
    for (int f = 0; f < take.frame_count(); ++f) {
      if (!options.frames.empty() && !std::count(options.frames.begin(), options.frames.end(), f)) continue;
      const fs::path matte = take.layout().matte(serial, f);
      if (is_there(matte))
        items.push_back({static_cast<int>(c), f, key_of(c), matte,
                         options.out / serial /
                             matte.filename().replace_extension(options.format == "exr" ? ".exr" : ".png")});
    }
  }
  if (items.empty())
    return fail(ErrorCode::NotFound,
                text(take.layout().mattes().string(), " holds no mattes; run `floatstage matte` first"));
  std::mutex mutex;
  std::optional<Error> failure;
  std::atomic<bool> stop = false;
  ProgressPart progress(options.progress, "layers", items.size());
  parallel_for(items.size(), options.threads, [&](std::size_t i) {
    if (stop || is_cancelled(options.progress)) return;
    if (!up_to_date(items[i].file, items[i].matte, options.format))
      if (Result<void> ok =
              export_one(take, items[i].camera, items[i].frame, items[i].key, options.format, items[i].file);
          !ok) {
        std::lock_guard lock(mutex);
        stop = true;
        if (!failure) failure = ok.error();
      }
    progress.advance();
  });
  if (failure) return Unexpected{*failure};
  if (is_cancelled(options.progress)) return cancelled();
  return static_cast<int>(items.size());
}

}  // namespace floatstage::pipeline
