#include "apps/viewer/window/layout.h"

#include <imgui.h>

namespace floatstage::apps {

float ui_scale() { return ImGui::GetFontSize() / kFontPixels; }

void lay_out_window(float strip_height, const std::array<float, 3>& background, const WindowParts& parts) {
  const float panel_width = 270 * ui_scale();
  strip_height *= ui_scale();
  constexpr ImGuiWindowFlags kFixed =
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus;
  const ImVec2 whole = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({panel_width, whole.y - strip_height});
  ImGui::Begin("controls", nullptr, kFixed & ~ImGuiWindowFlags_NoScrollbar);
  parts.controls();
  ImGui::End();
  ImGui::SetNextWindowPos({0, whole.y - strip_height});
  ImGui::SetNextWindowSize({whole.x, strip_height});
  ImGui::Begin("strip", nullptr, kFixed);
  parts.strip();
  ImGui::End();
  ImGui::SetNextWindowPos({panel_width, 0});
  ImGui::SetNextWindowSize({whole.x - panel_width, whole.y - strip_height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(background[0], background[1], background[2], 1));
  ImGui::Begin("stage", nullptr, kFixed);
  parts.stage();
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

}  // namespace floatstage::apps
