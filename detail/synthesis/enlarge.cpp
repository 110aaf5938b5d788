#include "detail/synthesis/enlarge.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/text.h"
#include "detail/photo_file.h"
#include "detail/synthesis/synthesis.h"

namespace floatstage::detail {
namespace {

constexpr double kMostPixels = 32e6;

DetailLayer layer_of(const LaidPhoto& laid, int levels) {
  DetailLayer out;
  out.picture = to_image_with_opacity(laid.patch);
  out.x = laid.x;
  out.y = laid.y;
  out.level = std::clamp(static_cast<int>(std::lround(std::log2(laid.report.zoom))), 0, levels);
  out.moved = laid.report.adapted;
  return out;
}

// The power of two nearest to the closest photograph's zoom.
Result<int> levels_for(const PhotoGraph& graph, int zoom) {
  const Photo& root = graph.photos[static_cast<std::size_t>(graph.root)].photo;
  const double pixels = static_cast<double>(root.width) * root.height;
  const auto fits = [&](int levels) { return pixels * std::pow(4.0, levels) <= kMostPixels; };
  if (zoom != 0) {
    const int levels = static_cast<int>(std::lround(std::log2(std::max(1, zoom))));
    if (levels < 1 || levels > 6 || zoom != 1 << levels)
      return fail(ErrorCode::InvalidArgument, text("--zoom ", zoom, ": 2, 4, 8, 16, 32 or 64"));
    if (!fits(levels))
      return fail(ErrorCode::InvalidArgument,
                  text("--zoom ", zoom, ": ", root.name, " would have ",
                       std::lround(pixels * zoom * zoom / 1e6), " million pixels; the picture may have 32"));
    return levels;
  }
  double closest = 1;
  for (const int i : graph.descendants(graph.root)) {
    double z = 1;
    for (int p = i; p != graph.root; p = graph.photos[static_cast<std::size_t>(p)].parent)
      z *= graph.photos[static_cast<std::size_t>(p)].zoom;
    closest = std::max(closest, z);
  }
  int levels = std::clamp(static_cast<int>(std::lround(std::log2(closest))), 1, 6);
  while (levels > 1 && !fits(levels)) --levels;
  if (fits(levels)) return levels;
  return fail(
      ErrorCode::InvalidArgument,
      text(root.name, " has ", std::lround(pixels / 1e6),
           " million pixels; twice as large it would have more than 32 million: make it smaller, or take "
           "another --root"));
}

// Every tile into the pictures.
Result<void> fill(const Synthesis& synthesis, const EnlargeOptions& options, Enlargement& out) {
  const int side = std::max(16, options.tile);
  const int columns = (synthesis.width() + side - 1) / side, rows = (synthesis.height() + side - 1) / side;
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  out.picture = Image(synthesis.width(), synthesis.height(), 3);
  out.provenance = Image(synthesis.width(), synthesis.height(), 1);
  if (options.watch.begin) options.watch.begin("tiles", count);
  parallel_for(count, options.threads, [&](std::size_t i) {
    if (options.watch.is_cancelled()) return;
    const int x = static_cast<int>(i) % columns * side, y = static_cast<int>(i) / columns * side;
    const Region region = common({x, y, x + side, y + side}, {0, 0, synthesis.width(), synthesis.height()});
    const SynthesisTile tile = synthesis.tile(region);
    const Image picture = to_picture(tile.colors);
    const auto width = static_cast<std::size_t>(region.width());
    for (int row = 0; row < region.height(); ++row) {
      std::copy_n(picture.at(0, row), 3 * width, out.picture.at(region.x0, region.y0 + row));
      std::copy_n(&tile.provenance.at(region.x0, region.y0 + row), width,
                  out.provenance.at(region.x0, region.y0 + row));
    }
    if (options.watch.advance) options.watch.advance();
  });
  if (options.watch.end) options.watch.end();
  if (options.watch.is_cancelled()) return fail(ErrorCode::Cancelled, "interrupted; nothing was written");
  return {};
}

void judge(const Image& root, Enlargement& out) {
  for (const std::uint8_t p : out.provenance.pixels)
    out.shares[std::min<std::size_t>(p, 3)] += 1.0 / static_cast<double>(out.provenance.pixels.size());
  double squares = 0, count = 0;
  for (int y = 0; y < root.height; ++y)
    for (int x = 0; x < root.width; ++x) {
      std::array<double, 3> sum{};
      bool made = true;
      for (int v = y * out.zoom; v < (y + 1) * out.zoom; ++v)
        for (int u = x * out.zoom; u < (x + 1) * out.zoom; ++u) {
          made = made && *out.provenance.at(u, v) <= static_cast<std::uint8_t>(Provenance::Synthesised);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += out.picture.at(u, v)[c];
        }
      for (std::size_t c = 0; c < 3 && made; ++c) {
        const double off = sum[c] / (out.zoom * out.zoom) - root.at(x, y)[c];
        squares += off * off;
        ++count;
      }
    }
  if (squares > 0) out.like_root = std::min(99.0, 10 * std::log10(255.0 * 255.0 * count / squares));
}

}  // namespace

Result<Enlargement> enlarge(const PhotoGraph& graph, const EnlargeOptions& options) {
  const GraphPhoto& root = graph.photos[static_cast<std::size_t>(graph.root)];
  if (graph.descendants(graph.root).empty())
    return fail(ErrorCode::InvalidArgument, text("nothing lies below ", root.photo.name,
                                                 ": there are no details to make up others from"));
  const Result<int> levels = levels_for(graph, options.zoom);
  if (!levels) return forward(levels);
  Enlargement out;
  out.zoom = 1 << *levels;
  std::vector<DetailLayer> layers;
  ComposeOptions composing;
  composing.zoom = out.zoom;
  composing.threads = options.threads;
  composing.watch = options.watch;
  composing.laid = [&](const LaidPhoto& laid) { layers.push_back(layer_of(laid, *levels)); };
  Result<Composition> composed = compose(graph, composing);
  if (!composed) return forward(composed);
  out.photos = std::move(composed->photos);
  composed->picture = Image();  // its memory is wanted
  const Result<Image> picture = load_photo(graph.folder / root.photo.name);
  if (!picture) return forward(picture);
  SynthesisOptions making;
  making.levels = *levels;
  making.threads = options.threads;
  const Result<Synthesis> synthesis = Synthesis::make(*picture, layers, making);
  if (!synthesis) return forward(synthesis);
  layers.clear();
  if (Result<void> ok = fill(*synthesis, options, out); !ok) return forward(ok);
  judge(*picture, out);
  return out;
}

Image provenance_picture(const Image& provenance) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kColors = {
      {{128, 128, 128}, {200, 60, 40}, {60, 170, 60}, {40, 90, 200}}};
  Image out(provenance.width, provenance.height, 3);
  for (std::size_t i = 0; i < provenance.pixels.size(); ++i)
    std::copy_n(kColors[std::min<std::size_t>(provenance.pixels[i], 3)].data(), 3, &out.pixels[3 * i]);
  return out;
}

}  // namespace floatstage::detail
