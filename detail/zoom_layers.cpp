#include "detail/zoom_layers.h"

#include "detail/photo_file.h"

namespace floatstage::detail {
Result<ZoomLayers> zoom_layers(const PhotoGraph& graph, const ZoomLayersOptions& options) {
  ZoomLayers out;
  ComposeOptions composing;
  composing.own_pixels = options.own_pixels;
  composing.adapt = options.adapt;
  composing.threads = options.threads;
  composing.watch = options.watch;
  composing.laid = [&](const LaidPhoto& laid) {
    out.layers.push_back({laid.report.name, to_image_with_opacity(laid.layer), laid.root_from_layer,
                          laid.report.zoom, laid.report.adapted});
  };
  Result<Composition> composed = compose(graph, composing);
  if (!composed) return forward(composed);
  out.photos = std::move(composed->photos);
  Result<Image> picture =
      load_photo(graph.folder / graph.photos[static_cast<std::size_t>(graph.root)].photo.name);
  if (!picture) return forward(picture);
  out.root = std::move(*picture);
  return out;
}

}  // namespace floatstage::detail
