#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/viewer/mattes/matte_desk.h"

namespace floatstage::apps {

/// The matte editor in its window: a MatteDesk drawn with ImGui, one camera at a time. GL thread only.
class MatteEditor {
 public:
  /// Errors: those of MatteDesk::open().
  static Result<std::unique_ptr<MatteEditor>> open(MatteDeskOptions options);
  ~MatteEditor();
  MatteEditor(const MatteEditor&) = delete;
  MatteEditor& operator=(const MatteEditor&) = delete;

  /// One frame of the user interface. What comes back is for the player's loop: screenshot, player, quit.
  EditorRequests frame(const std::vector<InputEvent>& input);

  bool busy() const { return desk_->busy() || next_; }
  /// The picture of the present frame is there, and nothing is being made.
  bool stands() const { return texture_number_ == desk_->picture_number() && !desk_->busy(); }
  int frame_number() const { return desk_->state().time.frame(); }
  void go_to(int frame) { desk_->state().time.seek(frame); }
  void tell(std::string status) { desk_->state().status = std::move(status); }

 private:
  explicit MatteEditor(MatteDeskOptions options, std::unique_ptr<MatteDesk> desk)
      : options_(std::move(options)), desk_(std::move(desk)) {}
  void draw_canvas();
  void upload();
  void change_camera(const std::string& serial);
  std::string serial_after() const;

  MatteDeskOptions options_;
  std::unique_ptr<MatteDesk> desk_;
  std::unique_ptr<MatteDesk> next_;  // of another camera, shown from the next frame on
  unsigned texture_ = 0;
  int texture_number_ = -1;
};

}  // namespace floatstage::apps
