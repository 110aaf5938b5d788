#include "detail/synthesis/enlarge.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/text.h"
#include "detail/float_picture.h"
#include "detail/photo_file.h"
#include "detail/quad.h"
#include "detail/synthesis/synthesis.h"

namespace floatstage::detail {
namespace {

constexpr double kMostPixels = 32e6, kMostWritten = 1e9;  // in memory; written while they are made
constexpr double kOwnPixels = 8e6;  // of one photograph, where the picture is larger than memory

DetailLayer layer_of(const LaidPhoto& laid, const LightPicture& patch, int x, int y, int levels) {
  DetailLayer out;
  out.picture = to_image_with_opacity(patch);
  out.x = x;
  out.y = y;
  out.level = std::clamp(static_cast<int>(std::lround(std::log2(laid.report.zoom))), 0, levels);
  out.moved = laid.report.adapted;
  return out;
}

/// Photographs as they lie in the picture, which compose() has not: it would not fit into memory.
class LargeLayers {
 public:
  LargeLayers(int width, int height, int levels, int threads)
      : width_(width), height_(height), levels_(levels), threads_(threads) {}

  void lay(const LaidPhoto& laid) {
    const Eigen::Matrix3d picture_from_layer =
        Eigen::DiagonalMatrix<double, 3>(1 << levels_, 1 << levels_, 1) * laid.root_from_layer;
    const Quad quad = *sane_quad(picture_from_layer, laid.layer.width, laid.layer.height);
    Eigen::Vector2d low = quad[0], high = quad[0];
    for (const Eigen::Vector2d& corner : quad) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
    const int x0 = std::max(0, static_cast<int>(std::floor(low.x()))),
              y0 = std::max(0, static_cast<int>(std::floor(low.y()))),
              x1 = std::min(width_, static_cast<int>(std::ceil(high.x()))),
              y1 = std::min(height_, static_cast<int>(std::ceil(high.y())));
    if (x1 <= x0 || y1 <= y0) return;
    pixels_ += static_cast<double>(x1 - x0) * (y1 - y0);
    if (pixels_ > kMostPixels) return;
    Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
    shift(0, 2) = x0;
    shift(1, 2) = y0;
    const LightPicture patch =
        warped(laid.layer, picture_from_layer.inverse() * shift, x1 - x0, y1 - y0, threads_);
    layers_.push_back(layer_of(laid, patch, x0, y0, levels_));
  }
  Result<std::vector<DetailLayer>> take() {
    if (pixels_ <= kMostPixels) return std::move(layers_);
    return fail(
        ErrorCode::InvalidArgument,
        text("--zoom ", 1 << levels_, ": the close photographs would cover ", std::lround(pixels_ / 1e6),
             " million pixels, which do not fit into memory; at most 32: choose a smaller one"));
  }

 private:
  const int width_, height_, levels_, threads_;
  std::vector<DetailLayer> layers_;
  double pixels_ = 0;
};

// The power of two nearest to the closest photograph's zoom.
Result<int> levels_for(const PhotoGraph& graph, int zoom, double most) {
  const Photo& root = graph.photos[static_cast<std::size_t>(graph.root)].photo;
  const double pixels = static_cast<double>(root.width) * root.height;
  const auto fits = [&](int levels) { return pixels * std::pow(4.0, levels) <= most; };
  if (zoom != 0) {
    const int levels = static_cast<int>(std::lround(std::log2(std::max(1, zoom))));
    if (levels < 1 || levels > 6 || zoom != 1 << levels)
      return fail(ErrorCode::InvalidArgument, text("--zoom ", zoom, ": 2, 4, 8, 16, 32 or 64"));
    if (!fits(levels))
      return fail(ErrorCode::InvalidArgument,
                  text("--zoom ", zoom, ": ", root.name, " would have ",
                       std::lround(pixels * zoom * zoom / 1e6), " million pixels; the picture may have ",
                       std::lround(most / 1e6), most < kMostWritten ? " (a .dzi or .tif 1000)" : ""));
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
  return fail(ErrorCode::InvalidArgument,
              text(root.name, " has ", std::lround(pixels / 1e6),
                   " million pixels; twice as large it would have more than ", std::lround(most / 1e6),
                   " million: make it smaller, or take another --root"));
}

// Rows below those that are there, of a picture that is to have `height`.
void append(const Image& rows, int height, Image& to) {
  if (to.empty()) {
    to.width = rows.width, to.channels = rows.channels;
    to.pixels.reserve(static_cast<std::size_t>(height) * rows.pixels.size() /
                      static_cast<std::size_t>(rows.height));
  }
  to.pixels.insert(to.pixels.end(), rows.pixels.begin(), rows.pixels.end());
  to.height += rows.height;
}

/// Shares and likeness, of bands of rows.
class Judge {
 public:
  Judge(const Image& root, Enlargement& out) : root_(root), out_(out) {}

  // Rows from `top` on, which begins a row of the root.
  void look(const Image& picture, const Image& provenance, int top) {
    const double all = static_cast<double>(out_.width) * out_.height;
    for (const std::uint8_t p : provenance.pixels) out_.shares[std::min<std::size_t>(p, 3)] += 1 / all;
    for (int y = 0; y < picture.height / out_.zoom; ++y)
      for (int x = 0; x < root_.width; ++x) compare(picture, provenance, x, y, top / out_.zoom);
    if (squares_ > 0) out_.like_root = std::min(99.0, 10 * std::log10(255.0 * 255.0 * count_ / squares_));
  }

 private:
  void compare(const Image& picture, const Image& provenance, int x, int y, int top) {
    const int zoom = out_.zoom;
    std::array<double, 3> sum{};
    for (int v = y * zoom; v < (y + 1) * zoom; ++v)
      for (int u = x * zoom; u < (x + 1) * zoom; ++u) {
        if (*provenance.at(u, v) > static_cast<std::uint8_t>(Provenance::Synthesised)) return;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += picture.at(u, v)[c];
      }
    for (std::size_t c = 0; c < 3; ++c) {
      const double off = sum[c] / (zoom * zoom) - root_.at(x, top + y)[c];
      squares_ += off * off;
      ++count_;
    }
  }
  const Image& root_;
  Enlargement& out_;
  double squares_ = 0, count_ = 0;
};

// All tiles of the rows [top, top + picture.height).
Result<void> fill(const Synthesis& synthesis, int side, int top, const EnlargeOptions& options,
                  Image& picture, Image& provenance) {
  parallel_for(static_cast<std::size_t>((synthesis.width() + side - 1) / side), options.threads,
               [&](std::size_t column) {
                 if (options.watch.is_cancelled()) return;
                 const int x = static_cast<int>(column) * side;
                 const Region region{x, top, std::min(x + side, synthesis.width()), top + picture.height};
                 const SynthesisTile tile = synthesis.tile(region);
                 const Image rgb = to_picture(tile.colors);
                 const auto width = static_cast<std::size_t>(region.width());
                 for (int row = 0; row < region.height(); ++row) {
                   std::copy_n(rgb.at(0, row), 3 * width, picture.at(x, row));
                   std::copy_n(&tile.provenance.at(x, top + row), width, provenance.at(x, row));
                 }
                 if (options.watch.advance) options.watch.advance();
               });
  return options.watch.is_cancelled() ? fail(ErrorCode::Cancelled, "interrupted; nothing was written")
                                      : Result<void>();
}

// The picture from the top, a row of tiles at a time.
Result<void> make_rows(const Synthesis& synthesis, const Image& root, const EnlargeOptions& options,
                       Enlargement& out) {
  const int side = (std::max(16, options.tile) + out.zoom - 1) / out.zoom * out.zoom;
  std::unique_ptr<RowWriter> writer;
  if (options.writer) {
    Result<std::unique_ptr<RowWriter>> made = options.writer(out.width, out.height);
    if (!made) return forward(made);
    writer = std::move(*made);
  }
  Judge judge(root, out);
  const auto tiles = [&](int length) { return static_cast<std::size_t>((length + side - 1) / side); };
  if (options.watch.begin) options.watch.begin("tiles", tiles(out.width) * tiles(out.height));
  for (int top = 0; top < out.height; top += side) {
    Image picture(out.width, std::min(side, out.height - top), 3), provenance(out.width, picture.height, 1);
    if (Result<void> ok = fill(synthesis, side, top, options, picture, provenance); !ok) return ok;
    judge.look(picture, provenance, top);
    if (options.keep_provenance) append(provenance, out.height, out.provenance);
    if (!writer) {
      append(picture, out.height, out.picture);
    } else if (Result<void> ok = writer->add(picture); !ok) {
      return ok;
    }
  }
  if (options.watch.end) options.watch.end();
  return writer ? writer->finish() : Result<void>();
}

}  // namespace

Result<Enlargement> enlarge(const PhotoGraph& graph, const EnlargeOptions& options) {
  const GraphPhoto& root = graph.photos[static_cast<std::size_t>(graph.root)];
  if (graph.descendants(graph.root).empty())
    return fail(ErrorCode::InvalidArgument, text("nothing lies below ", root.photo.name,
                                                 ": there are no details to make up others from"));
  const Result<int> levels =
      levels_for(graph, options.zoom, options.writer && options.zoom > 0 ? kMostWritten : kMostPixels);
  if (!levels) return forward(levels);
  Enlargement out;
  out.zoom = 1 << *levels;
  out.width = root.photo.width * out.zoom;
  out.height = root.photo.height * out.zoom;
  std::vector<DetailLayer> layers;
  LargeLayers large(out.width, out.height, *levels, options.threads);
  ComposeOptions composing;
  composing.threads = options.threads;
  composing.watch = options.watch;
  const double pixels = static_cast<double>(out.width) * out.height;
  if (pixels > kMostPixels && options.keep_provenance)
    return fail(ErrorCode::InvalidArgument,
                text("where ", std::lround(pixels / 1e6),
                     " million pixels come from is not kept; at most 32: choose a smaller --zoom"));
  const bool fits = pixels <= std::min(kMostPixels, options.in_memory);
  if (fits) {
    composing.zoom = out.zoom;
    composing.laid = [&](const LaidPhoto& laid) {
      layers.push_back(layer_of(laid, laid.patch, laid.x, laid.y, *levels));
    };
  } else {
    composing.own_pixels = kOwnPixels;
    composing.laid = [&](const LaidPhoto& laid) { large.lay(laid); };
  }
  Result<Composition> composed = compose(graph, composing);
  if (!composed) return forward(composed);
  out.photos = std::move(composed->photos);
  composed->picture = Image();  // its memory is wanted
  if (!fits) {
    Result<std::vector<DetailLayer>> laid = large.take();
    if (!laid) return forward(laid);
    layers = std::move(*laid);
  }
  const Result<Image> picture = load_photo(graph.folder / root.photo.name);
  if (!picture) return forward(picture);
  SynthesisOptions making;
  making.levels = *levels;
  making.threads = options.threads;
  const Result<Synthesis> synthesis = Synthesis::make(*picture, layers, making);
  if (!synthesis) return forward(synthesis);
  layers.clear();
  if (Result<void> ok = make_rows(*synthesis, *picture, options, out); !ok) return forward(ok);
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
