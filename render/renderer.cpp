#include "render/renderer.h"

#include <cmath>

#include <epoxy/gl.h>

#include "core/text.h"
#include "render/camera_choice.h"
#include "render/cpu/renderers.h"
#include "render/gl/blend_renderer.h"
#include "render/gl/floating_renderer.h"

namespace floatstage::render {
namespace {

constexpr int kMostFlowShrink = 8;
constexpr double kLargestRadius = 64;  // px; distances are stored in bytes

// The table of renderers: one line each.
using Maker = Result<std::unique_ptr<ViewRenderer>> (*)();
struct Entry {
  const char* name;
  const char* help;
  Maker cpu, gl;
};
constexpr Entry kRenderers[] = {
    {"nearest", "the best camera per pixel, no blending", [] { return cpu::make_blend_renderer(true); },
     [] { return make_blend_renderer(true); }},
    {"linear", "Unstructured Lumigraph: photographs blended by viewing angle",
     [] { return cpu::make_blend_renderer(false); }, [] { return make_blend_renderer(false); }},
    {"floating", "Floating Textures: photographs aligned by optical flow, then blended",
     cpu::make_floating_renderer, make_floating_renderer},
};

}  // namespace

const std::vector<std::string>& render_output_names() {
  static const std::vector<std::string> names = {"color", "weights",  "visibility", "soft-visibility",
                                                 "flow",  "ghosting", "depth"};
  return names;
}

const std::vector<std::string>& position_names() {
  static const std::vector<std::string> names = {"parallax", "mean"};
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
  for (const Entry& entry : kRenderers) list.push_back({entry.name, entry.help});
  return list;
}

std::vector<int> needed_cameras(const Rig& rig, const Mesh& mesh, const View& view, int count) {
  CameraRanking memory;
  const CameraChoice choice = choose_cameras(rig.cameras, ranking_samples(mesh), view, count, {}, memory);
  return {choice.listed.begin(), choice.listed.begin() + choice.chosen};
}

Image download(const RenderedView& view) {
  if (view.picture != nullptr) return *view.picture;
  Image image(view.width, view.height, 4);
  glGetTextureImage(view.texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(image.pixels.size()),
                    image.pixels.data());
  return image;
}

}  // namespace floatstage::render
