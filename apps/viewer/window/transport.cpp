#include "apps/viewer/window/transport.h"

#include <imgui.h>

namespace floatstage::apps {

void draw_transport(TimeLine& time) {
  if (ImGui::Button(time.playing ? "pause" : "play ")) time.playing = !time.playing;
  ImGui::SameLine();
  if (ImGui::Button("<")) time.step(-1);
  ImGui::SameLine();
  if (ImGui::Button(">")) time.step(1);
  ImGui::SameLine();
}

}  // namespace floatstage::apps
