#include "apps/viewer/live/live_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include "studio/live/live_quality.h"

namespace floatstage::apps {
namespace {

const ImVec4 kGood(0.45f, 0.85f, 0.5f, 1), kBad(1, 0.45f, 0.35f, 1);

unsigned long long number(std::uint64_t n) { return n; }

void complain(const std::string& sentence) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(kBad, "%s", sentence.c_str());
  ImGui::PopTextWrapPos();
}

// As wide as the panel; larger where the pointer is.
void draw_doubts(const LivePanelState& state) {
  constexpr float kLarge = 640;
  const auto show = [&](float width) {
    ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(state.doubts)),
                 ImVec2(width, width * state.doubts_shape));
  };
  show(ImGui::GetContentRegionAvail().x);
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  show(kLarge);
  ImGui::EndTooltip();
}

void draw_cameras(const studio::NodeStatus& node) {
  if (!ImGui::BeginTable(node.node.c_str(), 4, ImGuiTableFlags_SizingStretchProp)) return;
  for (const studio::NodeCamera& camera : node.cameras) {
    const bool well = camera.trouble.empty();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(well ? kGood : kBad, "%s", camera.serial.c_str());
    if (!well && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", camera.trouble.c_str());
    ImGui::TableNextColumn();
    ImGui::Text("%.1f fps", camera.frame_rate);
    ImGui::TableNextColumn();
    ImGui::Text("%llu lost", number(camera.lost + camera.failed));
    ImGui::TableNextColumn();
    if (camera.temperature_c) ImGui::Text("%.0f C", *camera.temperature_c);
  }
  ImGui::EndTable();
}

void draw_node(const studio::NodeStatus& node) {
  ImGui::Separator();
  if (!node.node.empty()) ImGui::TextUnformatted(node.node.c_str());
  for (const std::string& complaint : node.complaints) complain(complaint);
  if (!node.last_recording.empty()) complain(node.last_recording);
  if (node.cameras.empty()) return;
  ImGui::Text("%.1f GB free, spread %.2f ms", static_cast<double>(node.disk_free_bytes) * 1e-9,
              node.spread_max_ms);
  if (const std::optional<studio::NodeRecording>& take = node.recording) {
    ImGui::TextColored(kBad, "%s", take->take.c_str());
    ImGui::Text("%.0f s, %llu pictures, %llu gaps", take->seconds, number(take->frames), number(take->gaps));
    for (const std::string& complaint : take->complaints) complain(complaint);
  }
  draw_cameras(node);
}

void draw_recording(LivePanelState& state, const ControlModel::State& studio, ControlModel& model) {
  if (studio.busy) {
    ImGui::TextDisabled("a moment...");
  } else if (studio.recording()) {
    if (ImGui::Button("stop")) model.stop();
  } else {
    if (ImGui::Button("record")) model.record(state.label);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(120);
    ImGui::InputText("label", &state.label);
  }
  if (studio.told.empty()) return;
  if (studio.failed)
    complain(studio.told);
  else
    ImGui::TextUnformatted(studio.told.c_str());
}

}  // namespace

void draw_live_panel(LivePanelState& state, ControlModel& model) {
  ImGui::Text("%.1f scenes a second, %.0f ms old", state.fps, state.latency_ms);
  ImGui::Checkbox("hold this scene (space)", &state.hold);
  ImGui::Checkbox("automatic quality", &state.automatic);
  const std::vector<studio::LiveQuality>& qualities = studio::live_qualities();
  ImGui::SetNextItemWidth(150);
  if (ImGui::BeginCombo("quality", qualities[state.quality].name.c_str())) {
    for (std::size_t i = 0; i < qualities.size(); ++i) {
      if (!ImGui::Selectable(studio::describe(qualities[i]).c_str(), i == state.quality)) continue;
      state.quality = i;
      state.automatic = false;
    }
    ImGui::EndCombo();
  }
  if (!state.remark.empty()) complain(state.remark);
  if (state.doubts != 0) draw_doubts(state);
  if (!state.stream.empty()) ImGui::TextWrapped("%s", state.stream.c_str());
  if (model.empty()) {
    ImGui::TextDisabled("nothing to record here");
    return;
  }
  const ControlModel::State studio = model.state();
  draw_recording(state, studio, model);
  for (const studio::NodeStatus& node : studio.nodes) draw_node(node);
}

}  // namespace floatstage::apps
