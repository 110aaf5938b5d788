#include "apps/viewer/mattes/matte_editor.h"

#include <cstdint>

#include <epoxy/gl.h>
#include <imgui.h>

#include "apps/viewer/mattes/matte_panels.h"
#include "apps/viewer/window/layout.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr float kPanelWidth = 270, kTimeLineHeight = 92;  // before ui_scale()

}  // namespace

Result<std::unique_ptr<MatteEditor>> MatteEditor::open(MatteEditorModelOptions options) {
  Result<std::unique_ptr<MatteEditorModel>> model = MatteEditorModel::open(options);
  if (!model) return forward(model);
  return std::unique_ptr<MatteEditor>(new MatteEditor(std::move(options), std::move(*model)));
}

MatteEditor::~MatteEditor() {
  if (texture_) glDeleteTextures(1, &texture_);  // without one there may be no context either
}

void MatteEditor::upload() {
  if (texture_number_ == model_->picture_number()) return;
  texture_number_ = model_->picture_number();
  glDeleteTextures(1, &texture_);
  texture_ = 0;
  const Image& rgb = model_->picture();
  if (rgb.empty()) return;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
  glTextureStorage2D(texture_, 1, GL_RGB8, rgb.width, rgb.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture_, 0, 0, 0, rgb.width, rgb.height, GL_RGB, GL_UNSIGNED_BYTE, rgb.pixels.data());
  glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);  // who looks closely wants to see pixels
}

void MatteEditor::draw_canvas() {
  EditorState& state = model_->state();
  const ImVec2 origin = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
  state.fit.set_area(origin.x, origin.y, size.x, size.y);
  upload();
  ImDrawList* list = ImGui::GetWindowDrawList();
  const Image& picture = model_->picture();
  list->PushClipRect(origin, ImVec2(origin.x + size.x, origin.y + size.y), true);
  if (texture_) {
    const Eigen::Vector2d a = state.fit.to_window({0, 0}),
                          b = state.fit.to_window({picture.width, picture.height});
    list->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture_)),
                   ImVec2(static_cast<float>(a.x()), static_cast<float>(a.y())),
                   ImVec2(static_cast<float>(b.x()), static_cast<float>(b.y())));
  } else {
    list->AddText(ImVec2(origin.x + 20, origin.y + 20), IM_COL32_WHITE, "no photograph");
  }
  draw_edits(*model_, state);
  if (texture_ && !model_->has_matte() && state.view != MatteView::Photograph)
    list->AddText(ImVec2(origin.x + 12, origin.y + 10), IM_COL32(255, 200, 80, 255),
                  "no matte yet: Enter makes it");
  list->PopClipRect();
}

std::string MatteEditor::serial_after() const {
  const std::vector<RigCamera>& cameras = model_->take().rig().cameras;
  const int here = camera_index(model_->take().rig(), model_->serial());
  return cameras[(static_cast<std::size_t>(here) + 1) % cameras.size()].serial;
}

void MatteEditor::change_camera(const std::string& serial) {
  MatteEditorModelOptions options = options_;
  options.camera.serial = serial;
  options.frame = frame_number();
  options.view = model_->state().view;
  options.automatic = model_->state().automatic;
  options.subject = model_->state().session.subject;
  options.labels = model_->state().labels;
  Result<std::unique_ptr<MatteEditorModel>> model = MatteEditorModel::open(options);
  if (model)
    next_ = std::move(*model);
  else
    model_->state().status = model.error().message;
}

EditorRequests MatteEditor::frame(const std::vector<InputEvent>& input) {
  if (next_) model_ = std::move(next_), texture_number_ = -1;
  EditorRequests all;
  for (const InputEvent& event : input) {
    const EditorRequests requests = take_input(event, model_->state());
    model_->apply(requests);
    all.add(requests);
  }
  model_->update(ImGui::GetIO().DeltaTime);

  constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav;
  const ImVec2 whole = ImGui::GetIO().DisplaySize;
  const float left = kPanelWidth * ui_scale(), strip = kTimeLineHeight * ui_scale();
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({left, whole.y - strip});
  ImGui::Begin("mattes", nullptr, kFixed & ~ImGuiWindowFlags_NoScrollbar);
  const MattePanelRequests panel = draw_matte_controls(*model_);
  ImGui::End();
  ImGui::SetNextWindowPos({0, whole.y - strip});
  ImGui::SetNextWindowSize({whole.x, strip});
  ImGui::Begin("matte time", nullptr, kFixed);
  draw_matte_time_line(*model_);
  ImGui::End();
  ImGui::SetNextWindowPos({left, 0});
  ImGui::SetNextWindowSize({whole.x - left, whole.y - strip});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::Begin("photograph", nullptr, kFixed);
  draw_canvas();
  ImGui::End();
  ImGui::PopStyleVar();
  EditorRequests asked = panel.editor;
  asked.add(draw_question(model_->state(), (left + whole.x) / 2, (whole.y - strip) / 2));
  model_->apply(asked);
  if (!panel.camera.empty()) change_camera(panel.camera);
  if (all.next_camera) change_camera(serial_after());
  return all;
}

}  // namespace floatstage::apps
