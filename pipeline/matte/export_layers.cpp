#include "pipeline/matte/export_layers.h"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <mutex>
#include <optional>
#include <utility>

#include "capture/take.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/foreground.h"
#include "pipeline/exr_file.h"
#include "pipeline/keying.h"
#include "pipeline/label_record.h"
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

// A photograph whose subject is written: that of all, and each label's.
struct Item {
  int camera, frame;
  std::string key;
  fs::path matte, file;
  struct Label {
    std::string name;
    fs::path matte, file;  // `file` is empty where labels are channels of the picture
  };
  std::vector<Label> labels = {};
};

bool newer(const fs::path& layer, const fs::path& matte) {
  std::error_code none;
  return fs::exists(layer, none) && fs::last_write_time(layer, none) >= fs::last_write_time(matte, none);
}

// A picture that lies there already, made after its matte and in this format: what an interrupted export goes
// on from.
bool png_up_to_date(const fs::path& layer, const fs::path& matte, const std::string& format) {
  if (!newer(layer, matte)) return false;
  constexpr std::streamoff kBitDepth = 24;  // in a PNG's header
  std::ifstream png(layer, std::ios::binary);
  png.seekg(kBitDepth);
  return png.get() == (format == "png16" ? 16 : 8);
}

bool exr_up_to_date(const Item& item) {
  std::vector<std::string> channels = {"A", "B", "G", "R"};
  bool all = newer(item.file, item.matte);
  for (const Item::Label& l : item.labels) {
    channels.push_back(l.name + ".A");
    all = all && newer(item.file, l.matte);
  }
  std::sort(channels.begin(), channels.end());
  return all && exr_channels(item.file) == channels;
}

// Where a camera was keyed by chroma, its keyer knows which light is the cloth's.
Result<Image> photograph_of(capture::TakeReader& take, int camera, const Frame& frame,
                            const std::string& key) {
  if (!key.starts_with("chroma:")) return to_rgb(frame);
  Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, camera, key);
  if (!keyer) return forward(keyer);
  return (*keyer)->suppress_spill(frame);
}

// The photograph as it is composed; empty for a gap.
Result<Image> photograph_of(capture::TakeReader& take, const Item& item) {
  Result<Frame> photograph = take.frame(item.camera, item.frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Image();
  return photograph_of(take, item.camera, *photograph, item.key);
}

Result<Image> subject_of(const Image& photograph, const Image& matte) {
  Result<matting::Layers> layers = matting::estimate_foreground(photograph, matte);
  if (!layers) return forward(layers);
  return joined(layers->foreground, matte);
}

// One picture, in which each label is a channel.
Result<void> export_exr(capture::TakeReader& take, const Item& item) {
  if (exr_up_to_date(item)) return {};
  const Result<Image> photograph = photograph_of(take, item);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return {};
  const Result<Image> matte = load_png(item.matte);
  if (!matte) return forward(matte);
  const Result<Image> rgba = subject_of(*photograph, *matte);
  if (!rgba) return forward(rgba);
  std::vector<Image> opacities;
  for (const Item::Label& l : item.labels) {
    Result<Image> opacity = load_png(l.matte);
    if (!opacity) return forward(opacity);
    if (opacity->channels != 1 || opacity->width != matte->width || opacity->height != matte->height)
      return fail(ErrorCode::BadData, text(l.matte.string(), " is not a grey picture of ", matte->width, "x",
                                           matte->height, " like its camera's mattes"));
    opacities.push_back(std::move(*opacity));
  }
  std::vector<ExrLayer> layers;
  for (std::size_t l = 0; l < opacities.size(); ++l) layers.push_back({item.labels[l].name, opacities[l]});
  return save_exr(*rgba, item.file, ExrAlpha::Straight, layers);
}

// A picture of all, and one a label, whose colours at its edge are its own.
Result<void> export_pngs(capture::TakeReader& take, const Item& item, const std::string& format) {
  std::vector<std::pair<fs::path, fs::path>> todo;  // matte, picture
  if (!png_up_to_date(item.file, item.matte, format)) todo.emplace_back(item.matte, item.file);
  for (const Item::Label& l : item.labels)
    if (!png_up_to_date(l.file, l.matte, format)) todo.emplace_back(l.matte, l.file);
  if (todo.empty()) return {};
  const Result<Image> photograph = photograph_of(take, item);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return {};
  for (const auto& [from, to] : todo) {
    const Result<Image> matte = load_png(from);
    if (!matte) return forward(matte);
    const Result<Image> rgba = subject_of(*photograph, *matte);
    if (!rgba) return forward(rgba);
    if (Result<void> ok = format == "png16" ? save_png16(*rgba, to) : save_png(*rgba, to); !ok) return ok;
  }
  return {};
}

// Everything that there is to write, its folders made.
Result<std::vector<Item>> items_of(const capture::TakeReader& take, const ExportOptions& options) {
  const Result<MatteRecord> made = load_matte_record(take.layout());
  if (!made) return forward(made);
  const Result<LabelRecord> labels = load_label_record(take.layout());
  if (!labels) return forward(labels);
  const bool exr = options.format == "exr";
  std::vector<Item> items;
  for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
    const std::string& serial = take.rig().cameras[c].serial;
    if (!options.cameras.empty() &&
        std::find(options.cameras.begin(), options.cameras.end(), serial) == options.cameras.end())
      continue;
    const fs::path folder = options.out / serial;
    if (Result<void> ok = make_folder(folder); !ok) return forward(ok);
    for (const std::string& label : exr ? std::vector<std::string>() : labels->labels)
      if (Result<void> ok = make_folder(folder / label); !ok) return forward(ok);
    const auto of = made->find(serial);
    for (int f = 0; f < take.frame_count(); ++f) {
      if (!options.frames.empty() && !std::count(options.frames.begin(), options.frames.end(), f)) continue;
      const fs::path matte = take.layout().matte(serial, f),
                     name = matte.filename().replace_extension(exr ? ".exr" : ".png");
      if (!is_there(matte)) continue;
      Item item{static_cast<int>(c), f, of == made->end() ? "" : of->second.key, matte, folder / name};
      for (const std::string& label : labels->labels)
        item.labels.push_back(
            {label, take.layout().label_matte(serial, label, f), exr ? fs::path() : folder / label / name});
      items.push_back(std::move(item));
    }
  }
  if (!items.empty()) return items;
  return fail(ErrorCode::NotFound,
              text(take.layout().mattes().string(), " holds no mattes; run `floatstage matte` first"));
}

}  // namespace

Result<int> export_layers(const ExportOptions& options) {
  if (options.format != "png8" && options.format != "png16" && options.format != "exr")
    return fail(ErrorCode::InvalidArgument,
                text("'", options.format, "' is no format of layers; there are png8, png16 and exr"));
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  capture::TakeReader& take = **opened;
  const Result<std::vector<Item>> items = items_of(take, options);
  if (!items) return forward(items);
  std::mutex mutex;
  std::optional<Error> failure;
  std::atomic<bool> stop = false;
  ProgressPart progress(options.progress, "layers", items->size());
  parallel_for(items->size(), options.threads, [&](std::size_t i) {
    if (stop || is_cancelled(options.progress)) return;
    const Item& item = (*items)[i];
    if (Result<void> ok =
            options.format == "exr" ? export_exr(take, item) : export_pngs(take, item, options.format);
        !ok) {
      std::lock_guard lock(mutex);
      stop = true;
      if (!failure) failure = ok.error();
    }
    progress.advance();
  });
  if (failure) return Unexpected{*failure};
  if (is_cancelled(options.progress)) return cancelled();
  std::size_t pictures = items->size();
  for (const Item& item : *items)
    if (options.format != "exr") pictures += item.labels.size();
  return static_cast<int>(pictures);
}

}  // namespace floatstage::pipeline
