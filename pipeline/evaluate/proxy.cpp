#include "pipeline/evaluate/proxy.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/text.h"
#include "pipeline/chosen_take.h"
#include "pipeline/hull_record.h"
#include "pipeline/light_field.h"
#include "pipeline/mesh_record.h"
#include "pipeline/occluders.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

constexpr std::string_view kPlane = "plane:";

Result<Mesh> load_proxy(const std::filesystem::path& file) {
  Result<Mesh> mesh = load_ply(file);
  if (mesh && mesh->empty())
    return fail(ErrorCode::BadData, text(file.string(), ": a proxy of no triangles; nothing can be drawn"));
  return mesh;
}

}  // namespace

Result<Proxy> parse_proxy(std::string_view words, const recon::HullOptions& hull) {
  Proxy proxy{Proxy::Kind::Hull, hull, {}, 0};
  if (words == "exact" || words == "octree") {
    proxy.hull.method = words == "exact" ? recon::HullMethod::Exact : recon::HullMethod::Octree;
    return proxy;
  }
  if (words.ends_with(".ply")) {
    proxy.kind = Proxy::Kind::File;
    proxy.file = words;
    return proxy;
  }
  if (words.starts_with(kPlane)) {
    const std::string_view number = words.substr(kPlane.size());
    const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), proxy.distance);
    proxy.kind = Proxy::Kind::Plane;
    if (error == std::errc() && stop == number.data() + number.size() && std::isfinite(proxy.distance))
      return proxy;
  }
  return fail(ErrorCode::InvalidArgument,
              text("--proxy '", words, "' is none of exact, octree, FILE.ply and plane:Z (metres)"));
}

Result<Instant> load_instant(capture::TakeReader& take, int frame, const Proxy& proxy) {
  Result<FrameSet> images = take.frame_set(frame);
  if (!images) return forward(images);
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  Instant instant{frame, std::move(*images), std::move(*mattes), false, {}};
  for (const Matte& m : instant.mattes) instant.any_matte = instant.any_matte || !m.empty();
  const bool has_mesh = proxy.kind == Proxy::Kind::Films && is_there(take.layout().mesh(frame));
  const bool needs_mattes =
      proxy.kind == Proxy::Kind::Hull || (proxy.kind == Proxy::Kind::Films && !has_mesh);
  if (needs_mattes && !instant.any_matte)
    return fail(ErrorCode::NotFound,
                text("frame ", frame, " of ", take.layout().folder().string(),
                     " has no mattes yet; run `floatstage process ", take.layout().folder().string(), "`"));
  return instant;
}

namespace {

Result<Mesh> hull_without(const capture::TakeReader& take, const Instant& instant, int held,
                          const std::vector<bool>& input, const Proxy& proxy) {
  Result<std::vector<Matte>> silhouettes =
      silhouettes_of_labels(take, instant.frame, instant.mattes, proxy.hull.threads);
  if (!silhouettes) return forward(silhouettes);
  std::vector<Matte> mattes = std::move(*silhouettes);
  for (std::size_t i = 0; i < mattes.size(); ++i)
    if (!input[i] || static_cast<int>(i) == held) mattes[i] = {};
  const Result<Occluders> occluders = load_occluders(take.layout(), take.rig());
  if (!occluders) return forward(occluders);
  silhouettes = occluders->props.silhouettes(take.rig(), std::move(mattes), proxy.hull.threads);
  if (!silhouettes) return forward(silhouettes);
  recon::HullOptions options = proxy.hull;
  if (proxy.kind == Proxy::Kind::Films) {
    const Result<MeshRecord> record = load_mesh_record(take.layout());
    if (!record) return forward(record);
    options = parse_hull_options(record->options).value_or(options);
  }
  options.quality = false;
  Result<recon::HullReport> hull = recon::visual_hull(take.rig(), *silhouettes, options);
  const std::string without =
      held < 0 ? ""
               : text("without camera '", take.rig().cameras[static_cast<std::size_t>(held)].serial, "' ");
  if (!hull) return fail(hull.error().code, text(without, "there is no hull: ", hull.error().message));
  if (hull->mesh.empty())
    return fail(ErrorCode::BadData, text(without, "the hull is empty: the mattes contradict one another"));
  return std::move(hull->mesh);
}

}  // namespace

Result<Mesh> proxy_without(const capture::TakeReader& take, Instant& instant, int held,
                           const std::vector<bool>& input, const Proxy& proxy) {
  const auto h = static_cast<std::size_t>(held);
  const bool is_hull =
      instant.any_matte && (proxy.kind == Proxy::Kind::Hull || proxy.kind == Proxy::Kind::Films);
  const bool changes = is_hull && held >= 0 && input[h] && !instant.mattes[h].empty();
  if (!changes && instant.with_all) return *instant.with_all;
  Result<Mesh> mesh =
      is_hull ? hull_without(take, instant, held, input, proxy)
      : proxy.kind == Proxy::Kind::Plane
          ? plane_before(take.rig(), proxy.distance)
          : load_proxy(proxy.kind == Proxy::Kind::File ? proxy.file : take.layout().mesh(instant.frame));
  if (mesh && !changes) instant.with_all = *mesh;
  return mesh;
}

}  // namespace floatstage::pipeline
