#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include <epoxy/gl.h>

#include "core/text.h"
#include "render/band_limit.h"
#include "render/camera_choice.h"
#include "render/cpu/renderers.h"
#include "render/drawn_from.h"
#include "render/footprint.h"
#include "render/gl/blend_renderer.h"
#include "render/gl/filtered_renderer.h"
#include "render/gl/floating_renderer.h"
#include "render/gl/light_field_renderer.h"
#include "render/gl/static_renderer.h"

namespace floatstage::render {
namespace {

constexpr int kMostFlowShrink = 8;
constexpr double kMostBlur = 0.95;      // more would outlast any walk
constexpr double kMostMemory = 0.95;    // the same
constexpr double kWidestFilter = 512;   // px
constexpr double kMostUncertain = 0.5;  // of the diagonal: the subject's own size
constexpr double kLargestRadius = 64;   // px; distances are stored in bytes
constexpr double kAround = 4;           // px: edges are straight between corners, what the lens bends is not
constexpr double kWorthPhotographs = 0.01;  // of a view, beyond the chosen cameras' pictures
constexpr int kPartCell = 16;               // px: a part of a photograph has whole ones
constexpr double kSpline = 2;               // pixels to each side that it looks at

// The table of renderers: one line each.
using Maker = Result<std::unique_ptr<ViewRenderer>> (*)();
struct Entry {
  const char* name;
  const char* help;
  Maker cpu, gl;
  bool needs_grid = false;
  bool reads_proxy_alone = false;  ///< of photographs: the points where the proxy projects
};
constexpr Entry kRenderers[] = {
    {"nearest", "the best camera per pixel, no blending", [] { return cpu::make_blend_renderer(true); },
     [] { return make_blend_renderer(true); }, false, true},
    {"linear", "Unstructured Lumigraph: photographs blended by viewing angle",
     [] { return cpu::make_blend_renderer(false); }, [] { return make_blend_renderer(false); }, false, true},
    {"floating", "Floating Textures: photographs aligned by optical flow, then blended",
     cpu::make_floating_renderer, make_floating_renderer, false, true},
    {"floating-static", "Floating Textures by fields between the cameras' own pictures, estimated once",
     cpu::make_static_renderer, make_static_renderer},
    {"band-limited", "photographs filtered beforehand until ghosts run together, then linear",
     [] { return make_band_limited_renderer(BackEnd::Cpu); },
     [] { return make_band_limited_renderer(BackEnd::Gl); }},
    {"filtered", "Filtered Blending: photographs filtered along their lines of disparity, then linear",
     cpu::make_filtered_renderer, make_filtered_renderer},
    {"light-field", "quadrilinear: of cameras on a grid the four around each ray",
     cpu::make_light_field_renderer, make_light_field_renderer, true},
};

}  // namespace

const std::vector<std::string>& render_output_names() {
  static const std::vector<std::string> names = {
      "color",   "weights",    "visibility", "soft-visibility", "flow",   "ghosting",         "depth",
      "opacity", "projected",  "aliasing",   "predicted",       "warped", "position-weights", "color-weights",
      "field",   "confidence", "measured"};
  return names;
}

const std::vector<std::string>& position_names() {
  static const std::vector<std::string> names = {"parallax", "mean"};
  return names;
}

const std::vector<std::string>& alignment_names() {
  static const std::vector<std::string> names = {"flow", "depth", "auto"};
  return names;
}

Result<void> check(const RendererOptions& o) {
  auto bad = [](const auto&... parts) { return fail(ErrorCode::InvalidArgument, text(parts...)); };
  if (o.cameras < 1 || o.cameras > kMostListed)
    return bad(o.cameras, " photographs a view; 1 to ", kMostListed, " are possible");
  if (!(o.soft_radius >= 0) || o.soft_radius > kLargestRadius)
    return bad("the soft visibility radius ", o.soft_radius, " px is not between 0 and ", kLargestRadius);
  if (o.flow.shrink < 1 || o.flow.shrink > kMostFlowShrink)
    return bad("a flow at 1/", o.flow.shrink, " of the view's size; 1 to ", kMostFlowShrink, " are possible");
  if (!(o.band_limit >= 0) || o.band_limit > kWidestFilter)
    return bad("a band limit of ", o.band_limit, " px is not between 0 (by the depth range) and ",
               kWidestFilter);
  if (!(o.nearest >= 0) || !std::isfinite(o.farthest) || (o.nearest >= o.farthest && o.farthest != 0) ||
      (o.nearest > 0) != (o.farthest > 0))
    return bad("the depths ", o.nearest, " and ", o.farthest, " m are not 0 < nearest < farthest");
  if (!(o.uncertainty >= 0) || o.uncertainty > kMostUncertain)
    return bad("an uncertainty of ", o.uncertainty, " of the proxy's diagonal is not between 0 and ",
               kMostUncertain);
  if (!(o.motion_blur >= 0) || o.motion_blur > kMostBlur)
    return bad("a motion blur of ", o.motion_blur, " is not between 0 (none) and ", kMostBlur);
  if (!(o.field_memory >= 0) || o.field_memory > kMostMemory)
    return bad("a field memory of ", o.field_memory, " is not between 0 (none) and ", kMostMemory);
  if (o.threads < 0) return bad(o.threads, " threads; 0 means one per core");
  for (float c : o.background)
    if (!(c >= 0) || !(c <= 1)) return bad("the background colour ", c, " is not between 0 and 1");
  return {};
}

Result<std::unique_ptr<ViewRenderer>> make_renderer(std::string_view name, BackEnd back_end) {
  std::string known;
  for (const Entry& entry : kRenderers) {
    if (name == entry.name) return back_end == BackEnd::Gl ? entry.gl() : entry.cpu();
    known += text(known.empty() ? "" : ", ", entry.name);
  }
  return fail(ErrorCode::InvalidArgument, text("unknown renderer '", name, "'; there are: ", known));
}

std::vector<RendererInfo> renderers() {
  std::vector<RendererInfo> list;
  for (const Entry& entry : kRenderers) list.push_back({entry.name, entry.help, entry.needs_grid});
  return list;
}

std::vector<int> drawn_from(const Rig& rig, const Mesh& mesh, const View& view, int count) {
  CameraRanking ranking(rig.cameras, ranking_samples(mesh));
  const CameraChoice choice = choose_cameras(ranking, view, count, {});
  return {choice.listed.begin(), choice.listed.end()};
}

std::vector<PixelBox> parts_drawn_from(const RigCamera& camera, const Mesh& mesh, std::span<const View> views,
                                       std::string_view method) {
  const CameraModel& m = camera.model;
  const std::vector<PixelBox> whole{{0, 0, m.width, m.height}};
  const auto* entry = std::find_if(std::begin(kRenderers), std::end(kRenderers),
                                   [&](const Entry& e) { return method == e.name; });
  if (entry == std::end(kRenderers) || !entry->reads_proxy_alone || mesh.empty()) return whole;
  int deepest = 0;
  const Eigen::AlignedBox3f bounds = bounding_box(mesh);
  for (const View& view : views) deepest = std::max(deepest, deepest_level(camera, view, bounds));
  // Whole pixels of the coarsest level that is read, and of them those that a spline looks at.
  const double cell = 1 << deepest;
  const auto low = [&](double v, int size) {
    return static_cast<int>(cell *
                            std::clamp(std::floor((v - kAround) / cell) - kSpline, 0.0, (size - 1) / cell));
  };
  const auto high = [&](double v, int first, int size) {
    const double end = cell * (std::ceil((v + kAround) / cell) + kSpline);
    return static_cast<int>(std::clamp<double>(end, first + 1, size));
  };
  struct Reach {
    int left, top, right, bottom;
  };
  const auto corners = project_all(m, camera.cam_from_world, mesh.positions);
  if (!corners) return whole;
  std::vector<Reach> reaches;  // of each corner
  reaches.reserve(corners->size());
  for (const Eigen::Vector2d& pixel : *corners) {
    const int left = low(pixel.x(), m.width), top = low(pixel.y(), m.height);
    reaches.push_back({left, top, high(pixel.x(), left, m.width), high(pixel.y(), top, m.height)});
  }
  // Marked in cells of a grid.
  const auto cells = [](int size) { return (size + kPartCell - 1) / kPartCell; };
  const int across = cells(m.width), down = cells(m.height);
  std::vector<std::uint8_t> needed(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Reach &a = reaches[mesh.triangles[t]], &b = reaches[mesh.triangles[t + 1]],
                &c = reaches[mesh.triangles[t + 2]];
    const int left = std::min({a.left, b.left, c.left}) / kPartCell,
              right = cells(std::max({a.right, b.right, c.right})),
              bottom = cells(std::max({a.bottom, b.bottom, c.bottom}));
    for (int y = std::min({a.top, b.top, c.top}) / kPartCell; y < bottom; ++y)
      std::fill_n(needed.data() + static_cast<std::ptrdiff_t>(y) * across + left, right - left,
                  std::uint8_t{1});
  }
  std::vector<PixelBox> parts;
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x) {
      const auto is_needed = [&](int column) {
        return needed[static_cast<std::size_t>(y) * static_cast<std::size_t>(across) +
                      static_cast<std::size_t>(column)] != 0;
      };
      if (!is_needed(x)) continue;
      const int first = x;
      while (x < across && is_needed(x)) ++x;
      parts.push_back({first * kPartCell, y * kPartCell, std::min(x * kPartCell, m.width) - first * kPartCell,
                       std::min(kPartCell, m.height - y * kPartCell)});
    }
  return parts;
}

std::vector<int> needed_cameras(const Rig& rig, const Mesh& mesh, const View& view, int count) {
  CameraRanking ranking(rig.cameras, ranking_samples(mesh));
  const CameraChoice choice = choose_cameras(ranking, view, count, {});
  const std::size_t needed = choice.lacking > kWorthPhotographs ? choice.listed.size() : choice.chosen;
  return {choice.listed.begin(), choice.listed.begin() + needed};
}

Image download(const RenderedView& view) {
  if (view.picture != nullptr) return *view.picture;
  Image image(view.width, view.height, 4);
  glGetTextureImage(view.texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(image.pixels.size()),
                    image.pixels.data());
  return image;
}

SeenPixels seen_pixels(const RenderedView& view) {
  if (view.seen_buffer == 0) return view.seen;
  SeenPixels seen;
  glGetNamedBufferSubData(view.seen_buffer, 0, sizeof seen, &seen);
  return seen;
}

}  // namespace floatstage::render
