#include "apps/viewer/detail/zoom_panel.h"

#include <algorithm>

#include <imgui.h>

#include "apps/viewer/window/layout.h"

namespace floatstage::apps {
namespace {

constexpr double kMebibyte = 1 << 20;
// Outlines by generation: far ones pale, close ones strong.
constexpr ImU32 kColors[] = {IM_COL32(120, 200, 255, 255), IM_COL32(255, 210, 90, 255),
                             IM_COL32(255, 130, 110, 255), IM_COL32(170, 255, 140, 255)};

ImVec2 screen(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

void look_at(const ZoomOutline& outline, ZoomState& state) {
  Eigen::Vector2d low = outline.corners[0], high = low;
  for (const Eigen::Vector2d& corner : outline.corners)
    low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  const double across = std::max((high - low).x(), 1.0);
  state.fit.look_at((low + high) / 2, 0.7 * state.stage_width / across);
}

}  // namespace

void draw_zoom_controls(const ZoomScene& scene, const render::GlZipmap& zipmap,
                        const render::DrawnZipmap& drawn, ZoomState& state) {
  ImGui::Text("%.2f window px a px of the root", state.fit.scale());
  if (ImGui::Button("whole (H)")) state.fit.whole();
  ImGui::Checkbox("split: plain at the right (X)", &state.split);
  ImGui::Checkbox("where pixels come from (P)", &state.provenance);
  ImGui::Checkbox("photographs (G)", &state.graph);
  if (state.provenance)
    ImGui::TextWrapped("blue: a photograph; green: bent, or mixed at its rim; grey: the root enlarged");
  ImGui::Separator();
  ImGui::Text("root %d x %d", scene.width, scene.height);
  ImGui::Text("%.1fx at most", scene.zipmap->finest());
  ImGui::Text("%.0f MiB of video memory", static_cast<double>(zipmap.allocated()) / kMebibyte);
  ImGui::Text("one flat texture: %.0f MiB", scene.zipmap->bytes_when_flat() / kMebibyte);
  ImGui::Text("%d photographs in %d %s", drawn.patches, drawn.passes, drawn.passes == 1 ? "pass" : "passes");
  ImGui::Separator();
  for (const ZoomOutline& outline : scene.outlines) {
    ImGui::PushID(&outline);
    if (ImGui::Selectable(outline.name.c_str(), false, 0, ImVec2(190 * ui_scale(), 0)))
      look_at(outline, state);
    ImGui::SameLine(205 * ui_scale());
    ImGui::Text("%.1fx", outline.zoom);
    ImGui::PopID();
  }
}

void draw_outlines(ImDrawList* list, const ZoomScene& scene, const ZoomState& state) {
  for (std::size_t i = 0; i < scene.outlines.size(); ++i) {
    const ZoomOutline& outline = scene.outlines[i];
    const ImU32 color = kColors[i % std::size(kColors)];
    std::vector<ImVec2> points;
    for (const Eigen::Vector2d& corner : outline.corners)
      points.push_back(screen(state.fit.to_window(corner)));
    list->AddPolyline(points.data(), static_cast<int>(points.size()), color, ImDrawFlags_Closed, 1.5f);
    list->AddText({points[0].x + 4, points[0].y + 3}, color, outline.name.c_str());
  }
}

}  // namespace floatstage::apps
