#include "apps/viewer/mattes/matte_panels.h"

#include <algorithm>
#include <cmath>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/window/transport.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr float kQuestionWidth = 420;
constexpr ImU32 kSubject = IM_COL32(70, 230, 110, 255), kBackground = IM_COL32(255, 80, 70, 255);
constexpr ImU32 kStale = IM_COL32(255, 170, 40, 255), kPlayhead = IM_COL32(255, 255, 255, 255),
                kFlicker = IM_COL32(120, 170, 255, 255), kReach = IM_COL32(70, 230, 110, 110);

ImU32 color_of(MatteLabel label, int alpha) {
  return ((label == MatteLabel::Foreground ? kSubject : kBackground) & ~IM_COL32_A_MASK) |
         (static_cast<ImU32>(alpha) << IM_COL32_A_SHIFT);
}

template <class Choice>
bool choose(const char* label, Choice& chosen, Choice value) {
  if (!ImGui::RadioButton(label, chosen == value)) return false;
  chosen = value;
  return true;
}

// Whose strokes are.
void draw_labels(EditorState& state) {
  EditSession& session = state.session;
  constexpr const char* kNobodys = "nobody's";
  const char* now = session.subject.empty() ? kNobodys : session.subject.c_str();
  if (ImGui::BeginCombo("label (L)", now)) {
    if (ImGui::Selectable(kNobodys, session.subject.empty())) session.subject.clear();
    for (const std::string& label : state.labels)
      if (ImGui::Selectable(label.c_str(), label == session.subject)) session.subject = label;
    ImGui::EndCombo();
  }
  if (ImGui::InputText("new label", &state.new_label, ImGuiInputTextFlags_EnterReturnsTrue) &&
      choose_label(state, state.new_label))
    state.new_label.clear();
}

void draw_tools(EditorState& state) {
  EditSession& session = state.session;
  choose("subject | background (F)", session.tool, EditTool::Stroke);
  choose("garbage brush (G)", session.tool, EditTool::Garbage);
  choose("hold-out brush (H)", session.tool, EditTool::HoldOut);
  float radius = static_cast<float>(session.radius);
  if (ImGui::SliderFloat("radius []", &radius, 0.5f, 100, "%.1f px", ImGuiSliderFlags_Logarithmic))
    session.grow(radius / session.radius);
  if (session.tool == EditTool::Stroke) {
    draw_labels(state);
    ImGui::TextDisabled("left: subject  right: background\ndrag: scribble");
    return;
  }
  choose("whole clip", session.mask_reach, MaskReach::WholeClip);
  ImGui::SameLine();
  choose("from here", session.mask_reach, MaskReach::FromHere);
  ImGui::SameLine();
  choose("here", session.mask_reach, MaskReach::ThisFrame);
  ImGui::TextDisabled("left: paint  right: remove");
}

EditorRequests draw_work(MatteEditorModel& model) {
  EditorRequests requests;
  EditorState& state = model.state();
  if (ImGui::Button("undo")) requests.edited |= state.session.undo();
  ImGui::SameLine();
  if (ImGui::Button("redo")) requests.edited |= state.session.redo();
  ImGui::SameLine();
  if (ImGui::Button("remove keyframe")) requests.edited |= state.session.remove_keyframe(state.time.frame());
  requests.remake = ImGui::Button("make mattes (Enter)");
  ImGui::Checkbox("after every edit (A)", &state.automatic);
  if (ImGui::Button("worst frame (W)")) go_to_worst(state);
  const MatteEffort effort = effort_of(state.session.edits());
  ImGui::Text("%d keyframes, %d clicks,\n%d scribbles, %d masks", effort.keyframes, effort.clicks,
              effort.scribbles, effort.masks);
  const long stale = std::count(state.stale.begin(), state.stale.end(), true);
  if (stale > 0)
    ImGui::TextColored(ImVec4(1, 0.67f, 0.16f, 1), "%ld of %d mattes to be made", stale, state.time.frames());
  else
    ImGui::TextUnformatted("all mattes are made");
  if (const auto doubts = state.doubts.find(state.time.frame()); doubts != state.doubts.end()) {
    ImGui::PushStyleColor(ImGuiCol_Text, kBackground);
    for (const std::string& why : doubts->second) ImGui::TextWrapped("%s", why.c_str());
    ImGui::PopStyleColor();
  }
  if (const std::optional<BackgroundTask::Progress> p = model.progress(); p && p->all > 0) {
    ImGui::ProgressBar(static_cast<float>(p->done) / static_cast<float>(p->all), ImVec2(-1, 0));
    ImGui::TextWrapped("%s", p->what.c_str());
  }
  return requests;
}

// On a ground of its own, to be read before any picture.
void draw_name(ImDrawList* list, const ImVec2& at, ImU32 color, const std::string& name) {
  const ImVec2 size = ImGui::CalcTextSize(name.c_str());
  list->AddRectFilled({at.x - 2, at.y}, {at.x + size.x + 2, at.y + size.y}, IM_COL32(0, 0, 0, 180));
  list->AddText(at, color, name.c_str());
}

void draw_stroke(ImDrawList* list, const PictureFit& fit, const MatteStroke& stroke, int alpha) {
  const float thickness = static_cast<float>(std::max(2.0, 2 * stroke.radius * fit.scale()));
  const ImU32 color = color_of(stroke.label, alpha);
  std::vector<ImVec2> points;
  for (const Eigen::Vector2d& p : stroke.points) {
    const Eigen::Vector2d q = fit.to_window(p);
    points.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()));
  }
  if (points.size() > 1)
    list->AddPolyline(points.data(), static_cast<int>(points.size()), color, ImDrawFlags_None, thickness);
  if (points.size() == 1) list->AddCircleFilled(points[0], thickness / 2, color);
  if (points.size() == 1) list->AddCircle(points[0], thickness / 2 + 1, IM_COL32_BLACK);
  if (!stroke.subject.empty())
    draw_name(list, {points[0].x + thickness / 2 + 5, points[0].y - 7}, color, stroke.subject);
}

void draw_mask(ImDrawList* list, const PictureFit& fit, const MatteMask& mask) {
  if (mask.radius > 0) return draw_stroke(list, fit, {mask.label, mask.radius, mask.polygon}, 70);
  std::vector<ImVec2> points;
  for (const Eigen::Vector2d& p : mask.polygon) {
    const Eigen::Vector2d q = fit.to_window(p);
    points.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()));
  }
  list->AddPolyline(points.data(), static_cast<int>(points.size()), color_of(mask.label, 160),
                    ImDrawFlags_Closed, 2);
}

}  // namespace

MattePanelRequests draw_matte_controls(MatteEditorModel& model) {
  MattePanelRequests requests;
  EditorState& state = model.state();
  ImGui::PushItemWidth(150);
  if (ImGui::BeginCombo("camera", model.serial().c_str())) {
    for (const RigCamera& camera : model.take().rig().cameras)
      if (ImGui::Selectable(camera.serial.c_str(), camera.serial == model.serial()) &&
          camera.serial != model.serial())
        requests.camera = camera.serial;
    ImGui::EndCombo();
  }
  ImGui::Text("mattes by %s", model.method().c_str());
  ImGui::Separator();
  const std::vector<std::string>& views = matte_view_names();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i % 2 == 1) ImGui::SameLine(142);
    choose(text(views[i], " (", i + 1, ")").c_str(), state.view, static_cast<MatteView>(i));
  }
  if (state.view == MatteView::Labels)
    for (std::size_t l = 0; l < state.labels.size(); ++l) {
      const std::array<std::uint8_t, 3> color = component_color(static_cast<int>(l));
      ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(color[0], color[1], color[2], 255));
      ImGui::BulletText("%s", state.labels[l].c_str());
      ImGui::PopStyleColor();
    }
  ImGui::Separator();
  draw_tools(state);
  ImGui::Separator();
  requests.editor = draw_work(model);
  ImGui::Separator();
  ImGui::TextDisabled(
      ", .  keyframes   V  view\nCtrl-Z  undo\nCtrl-Shift-Z  redo\nwheel: zoom  middle: pan  0: all\nTab: "
      "camera  F12: screenshot\nM: player");
  ImGui::PopItemWidth();
  return requests;
}

void draw_matte_time_line(MatteEditorModel& model) {
  EditorState& state = model.state();
  TimeLine& time = state.time;
  draw_transport(time);
  ImGui::Text("frame %d of %d%s", time.frame(), time.frames(),
              state.session.keyframe(time.frame()) ? ", a keyframe" : "");
  ImGui::SameLine(330);
  ImGui::TextUnformatted(state.status.c_str());

  const ImVec2 origin = ImGui::GetCursorScreenPos(), size(ImGui::GetContentRegionAvail().x, 46);
  ImGui::InvisibleButton("line", size);
  const float step = size.x / static_cast<float>(time.frames());
  if (ImGui::IsItemActive())
    time.playing = false, time.seek(static_cast<int>((ImGui::GetIO().MousePos.x - origin.x) / step));
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float bottom = origin.y + size.y;
  list->AddRectFilled(origin, ImVec2(origin.x + size.x, bottom), IM_COL32(40, 42, 48, 255));
  double largest = 1e-3;
  for (const std::optional<double>& f : state.flicker) largest = std::max(largest, f.value_or(0));
  for (int f = 0; f < time.frames(); ++f) {
    const std::size_t i = static_cast<std::size_t>(f);
    const float left = origin.x + step * static_cast<float>(f),
                right = std::max(left + 1, left + step - (step > 4 ? 1 : 0));
    if (state.flicker[i])
      list->AddRectFilled(ImVec2(left, bottom - 6 - 26 * static_cast<float>(*state.flicker[i] / largest)),
                          ImVec2(right, bottom - 6), kFlicker);
    if (state.stale[i]) list->AddRectFilled(ImVec2(left, bottom - 5), ImVec2(right, bottom), kStale);
    if (state.guided[i])  // how far keyframes reach
      list->AddRectFilled(ImVec2(left, origin.y + 4), ImVec2(left + step, origin.y + 10), kReach);
    if (state.doubts.contains(f))
      list->AddRectFilled(ImVec2(left, origin.y), ImVec2(right, origin.y + 14), kBackground);
    if (!state.session.keyframe(f)) continue;
    const float middle = left + step / 2, y = origin.y + 7;
    list->AddQuadFilled(ImVec2(middle, y - 6), ImVec2(middle + 6, y), ImVec2(middle, y + 6),
                        ImVec2(middle - 6, y), kSubject);
  }
  const float now = origin.x + step * (static_cast<float>(time.frame()) + 0.5f);
  list->AddLine(ImVec2(now, origin.y), ImVec2(now, bottom), kPlayhead, 2);
}

EditorRequests draw_question(const EditorState& state, float x, float y) {
  EditorRequests answer;
  if (state.question.empty()) return answer;
  ImGui::SetNextWindowPos({x, y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({kQuestionWidth, 0});
  ImGui::SetNextWindowFocus();
  ImGui::Begin("question", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
  ImGui::TextWrapped("%s. May the editor change them? The originals are kept in mattes/given.",
                     state.question.c_str());
  answer.yes = ImGui::Button("change them (Y)");
  ImGui::SameLine();
  answer.no = ImGui::Button("leave them (N)");
  ImGui::End();
  return answer;
}

void draw_edits(const MatteEditorModel& model, const EditorState& state) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const PictureFit& fit = state.fit;
  for (const MatteMask& mask : state.session.edits().masks)
    if (holds_in(mask, state.time.frame())) draw_mask(list, fit, mask);
  if (const MatteKeyframe* keyframe = state.session.keyframe(state.time.frame()))
    for (const MatteStroke& stroke : keyframe->strokes) draw_stroke(list, fit, stroke, 170);
  if (const MatteStroke* drawing = state.session.drawing()) draw_stroke(list, fit, *drawing, 170);
  if (fit.holds(state.pointer_x, state.pointer_y) && !model.picture().empty()) {
    const ImVec2 at(static_cast<float>(state.pointer_x), static_cast<float>(state.pointer_y));
    const float radius = static_cast<float>(std::max(2.0, state.session.radius * fit.scale()));
    list->AddCircle(at, radius + 1, IM_COL32_BLACK, 0, 1);
    list->AddCircle(at, radius, state.session.tool == EditTool::Garbage ? kBackground : kSubject, 0, 1.5f);
  }
}

}  // namespace floatstage::apps
