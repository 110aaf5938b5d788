#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/viewer/mattes/matte_editor_model.h"

namespace floatstage::apps {

/// The matte editor in its window: a MatteEditorModel drawn with ImGui, one camera at a time. GL thread only.
class MatteEditor {
 public:
  /// Errors: those of MatteEditorModel::open().
  static Result<std::unique_ptr<MatteEditor>> open(MatteEditorModelOptions options);
  ~MatteEditor();
  MatteEditor(const MatteEditor&) = delete;
  MatteEditor& operator=(const MatteEditor&) = delete;

  /// One frame of the user interface. What comes back is for the player's loop: screenshot, player, quit.
  EditorRequests frame(const std::vector<InputEvent>& input);

  bool busy() const { return model_->busy() || next_; }
  /// The picture of the present frame is there, and nothing is being made.
  bool stands() const { return texture_number_ == model_->picture_number() && !model_->busy(); }
  int frame_number() const { return model_->state().time.frame(); }
  void go_to(int frame) { model_->state().time.seek(frame); }
  void show_status(std::string status) { model_->state().status = std::move(status); }

 private:
  explicit MatteEditor(MatteEditorModelOptions options, std::unique_ptr<MatteEditorModel> model)
      : options_(std::move(options)), model_(std::move(model)) {}
  void draw_canvas();
  void upload();
  void change_camera(const std::string& serial);
  std::string serial_after() const;

  MatteEditorModelOptions options_;
  std::unique_ptr<MatteEditorModel> model_;
  std::unique_ptr<MatteEditorModel> next_;  // of another camera, shown from the next frame on
  unsigned texture_ = 0;
  int texture_number_ = -1;
};

}  // namespace floatstage::apps
