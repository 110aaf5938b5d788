#include "detail/compose.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"
#include "detail/photo_file.h"
#include "detail/quad.h"
#include "detail/transfer.h"
#include "detail/transfer_pictures.h"

namespace floatstage::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr double kMostPixels = 32e6;
constexpr double kCanvas = 8e6;  // px in which photographs meet that bring their own pixels
constexpr int kSmallest =
    32;  // px a side of a child in the picture, below which there is nothing to carry over

Matrix3d scaling(double s) { return Eigen::DiagonalMatrix<double, 3>(s, s, 1); }

Result<Image> load(const PhotoGraph& graph, const GraphPhoto& photo) {
  const std::filesystem::path file = graph.folder / photo.photo.name;
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  if (content_hash(*bytes) != photo.photo.hash)
    return fail(ErrorCode::BadData, text(file.string(),
                                         " is not the photograph that was related; run `floatstage "
                                         "detail graph` again"));
  Result<Image> picture = decode_photo(*bytes, file.string());
  if (!picture) return picture;
  if (picture->width != photo.photo.width || picture->height != photo.photo.height)
    return fail(ErrorCode::BadData, text(file.string(), " has another size than the graph says"));
  return picture;
}

/// A child no finer than the canvas, and its pixels' place in the photograph.
struct Child {
  LightPicture picture;
  Matrix3d photo_from_child = Matrix3d::Identity();
};

Child shrunk(const Image& photo, double shrink, int threads) {
  if (shrink >= 0.99) return {to_light(photo), Matrix3d::Identity()};
  const int w = std::max(1, static_cast<int>(std::lround(photo.width * shrink))),
            h = std::max(1, static_cast<int>(std::lround(photo.height * shrink)));
  const Matrix3d back = Eigen::DiagonalMatrix<double, 3>(static_cast<double>(photo.width) / w,
                                                         static_cast<double>(photo.height) / h, 1);
  if (static_cast<double>(photo.width) * photo.height <= kMostPixels)
    return {warped(to_light(photo), back, w, h, threads), back};
  Image small(w, h, 3);  // the whole in floats would take gigabytes
  cv::Mat to(h, w, CV_8UC3, small.pixels.data());
  cv::resize(cv::Mat(photo.height, photo.width, CV_8UC3, const_cast<std::uint8_t*>(photo.pixels.data())), to,
             to.size(), 0, 0, cv::INTER_AREA);
  return {to_light(small), back};
}

/// Where a photograph lies in the root, and how far it zooms.
struct Place {
  Matrix3d root_from_photo = Matrix3d::Identity();
  double zoom = 1;
};

std::map<int, Place> places_below(const PhotoGraph& graph) {
  std::map<int, Place> places;
  places[graph.root] = {};
  for (const int i : graph.descendants(graph.root)) {
    const GraphPhoto& photo = graph.photos[static_cast<std::size_t>(i)];
    const Place& parent = places.at(photo.parent);
    places[i] = {parent.root_from_photo * photo.parent_from_child, parent.zoom * photo.zoom};
  }
  return places;
}

double share(const std::vector<std::uint8_t>& mask) {
  return static_cast<double>(std::accumulate(mask.begin(), mask.end(), std::size_t{0})) /
         static_cast<double>(mask.size());
}

ComposedPhoto report_of(const std::string& name, double zoom, const Transfer& t) {
  ComposedPhoto r;
  r.name = name;
  r.zoom = zoom;
  r.used = share(t.seam.child);
  r.same = share(t.same);
  r.edges = static_cast<int>(t.structure.on_seam.size());
  for (const EdgePair& e : t.structure.on_seam) r.moved += (e.child - e.parent).norm() / r.edges;
  r.adapted = t.adapted;
  r.seam_before = t.first_seam.energy;
  r.seam_after = t.seam_cost;
  r.correction = t.correction;
  return r;
}

// Lays the child over the canvas, as opaque as its mask says.
void lay_over(const Transfer& t, const Matrix3d& canvas_from_child, double canvas_zoom,
              const ComposedPhoto& report, const ComposeOptions& options, LightPicture& canvas) {
  const Quad quad = *sane_quad(canvas_from_child, t.adjusted.width, t.adjusted.height);
  Vector2d low = quad[0], high = quad[0];
  for (const Vector2d& corner : quad) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  const int x0 = std::max(0, static_cast<int>(std::floor(low.x()))),
            y0 = std::max(0, static_cast<int>(std::floor(low.y())));
  const int x1 = std::min(canvas.width, static_cast<int>(std::ceil(high.x()))),
            y1 = std::min(canvas.height, static_cast<int>(std::ceil(high.y())));
  if (x1 <= x0 || y1 <= y0) return;
  LightPicture layer = t.adjusted;
  for (std::size_t i = 0; i < layer.pixels.size(); ++i) layer.pixels[i][3] = t.alpha.values[i];
  Matrix3d shift = Matrix3d::Identity();
  shift(0, 2) = x0;
  shift(1, 2) = y0;
  const LightPicture patch =
      warped(layer, canvas_from_child.inverse() * shift, x1 - x0, y1 - y0, options.threads);
  if (options.laid)
    options.laid({report, patch, x0, y0, layer, scaling(1 / canvas_zoom) * canvas_from_child});
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const Light& from = patch.at(x - x0, y - y0);
      Light& to = canvas.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) to[k] += from[3] * (from[k] - to[k]);
    }
}

// "a/b.jpg" as the beginning of a file's name.
std::string flat(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

Result<ComposedPhoto> carry(const PhotoGraph& graph, int index, const Place& place, double canvas_zoom,
                            const ComposeOptions& options, LightPicture& canvas) {
  const GraphPhoto& photo = graph.photos[static_cast<std::size_t>(index)];
  const Result<Image> loaded = load(graph, photo);
  if (!loaded) return forward(loaded);
  // What the canvas cannot show costs memory only.
  const double pixels = static_cast<double>(photo.photo.width) * photo.photo.height;
  const double shrink = std::min(
      1.0, options.own_pixels > 0 ? std::sqrt(options.own_pixels / pixels) : canvas_zoom / place.zoom);
  const Child made = shrunk(*loaded, shrink, options.threads);
  const LightPicture* child = &made.picture;
  ComposedPhoto skipped;
  skipped.name = photo.photo.name;
  skipped.zoom = place.zoom;
  if (std::min(child->width, child->height) < kSmallest) {
    skipped.why_not =
        text("in this picture it has ", child->width, "x", child->height, " px; ask for more --zoom");
    return skipped;
  }
  const Matrix3d canvas_from_child = scaling(canvas_zoom) * place.root_from_photo * made.photo_from_child;
  if (!sane_quad(canvas_from_child, child->width, child->height)) {
    skipped.why_not = "its place in the root folds over";
    return skipped;
  }
  const LightPicture parent = warped(canvas, canvas_from_child, child->width, child->height, options.threads);
  // What the parent has details for: its photograph's pixels, where the canvas has them.
  const double finer = shrink * std::max(photo.zoom, place.zoom / canvas_zoom);
  const Transfer t = transfer_detail(*child, parent, std::max(1.0, finer), {options.adapt});
  if (!options.steps.empty())
    if (Result<void> ok = save_steps(*child, parent, t, options.steps, flat(photo.photo.name)); !ok)
      return forward(ok);
  const ComposedPhoto report = report_of(photo.photo.name, place.zoom, t);
  lay_over(t, canvas_from_child, canvas_zoom, report, options, canvas);
  return report;
}

}  // namespace

Result<Composition> compose(const PhotoGraph& graph, const ComposeOptions& options) {
  const GraphPhoto& root = graph.photos[static_cast<std::size_t>(graph.root)];
  const std::map<int, Place> places = places_below(graph);
  const double pixels = static_cast<double>(root.photo.width) * root.photo.height;
  if (pixels > kMostPixels)
    return fail(ErrorCode::InvalidArgument,
                text(root.photo.name, " has ", std::lround(pixels / 1e6),
                     " million pixels; a picture may have 32: make it smaller, or take another --root"));
  double closest = 1;
  for (const auto& [i, place] : places) closest = std::max(closest, place.zoom);
  Composition out;
  const double most = options.own_pixels > 0 ? kCanvas : kMostPixels;
  out.zoom = options.zoom > 0 ? options.zoom : std::max(1.0, std::min(closest, std::sqrt(most / pixels)));
  if (!(out.zoom >= 1) || (options.zoom > 0 && pixels * out.zoom * out.zoom > kMostPixels))
    return fail(ErrorCode::InvalidArgument,
                text("--zoom ", out.zoom, ": 1 to ", std::floor(100 * std::sqrt(kMostPixels / pixels)) / 100,
                     " (the picture may have 32 million pixels)"));
  const Result<Image> picture = load(graph, root);
  if (!picture) return forward(picture);
  if (!options.steps.empty())
    if (Result<void> ok = make_folder(options.steps); !ok) return forward(ok);
  LightPicture canvas = warped(to_light(*picture), scaling(1 / out.zoom),
                               static_cast<int>(std::lround(root.photo.width * out.zoom)),
                               static_cast<int>(std::lround(root.photo.height * out.zoom)), options.threads);
  // By zoom, so that nothing coarse covers what is finer; a parent comes before its children that way, too.
  std::vector<int> below = graph.descendants(graph.root);
  std::stable_sort(below.begin(), below.end(),
                   [&](int a, int b) { return places.at(a).zoom < places.at(b).zoom; });
  if (options.watch.begin) options.watch.begin("photographs", below.size());
  for (const int i : below) {
    if (options.watch.is_cancelled()) return fail(ErrorCode::Cancelled, "interrupted; nothing was written");
    Result<ComposedPhoto> photo = carry(graph, i, places.at(i), out.zoom, options, canvas);
    if (!photo) return forward(photo);
    out.photos.push_back(std::move(*photo));
    if (options.watch.advance) options.watch.advance();
  }
  if (options.watch.end) options.watch.end();
  out.picture = to_image(canvas);
  return out;
}

}  // namespace floatstage::detail
