#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/mattes/editor_state.h"
#include "apps/viewer/window/background_task.h"
#include "pipeline/matte/edited_camera.h"

namespace floatstage::apps {

struct MatteEditorModelOptions {
  pipeline::EditedCameraOptions camera;
  int frame = 0;
  MatteView view = MatteView::Checker;
  bool automatic = true;
  std::string subject = {};              ///< whose strokes are; empty: not said
  std::vector<std::string> labels = {};  ///< known beside those of the take
  std::function<void(const std::string& line)> say = [](const std::string&) {
  };  ///< what was finished, one line each
};

/// The matte editor without its window: input goes in, pictures come out, mattes/edits.json is written after
/// every edit, and mattes are made again in the background. One camera. All calls come from one thread.
///
/// Before mattes of unknown origin are changed, the state has a question. Yes lets them be changed, and their
/// originals are kept in mattes/given/; no takes the last edit back.
class MatteEditorModel {
 public:
  /// Errors: those of EditedCamera::open() and TakeReader::open(); InvalidArgument for a frame that is not
  /// there; BadData for a camera of which no size is known.
  static Result<std::unique_ptr<MatteEditorModel>> open(MatteEditorModelOptions options);
  ~MatteEditorModel();

  EditorState& state() { return *state_; }
  const capture::TakeReader& take() const { return *take_; }
  const std::string& serial() const { return options_.camera.serial; }
  const std::string& method() const { return method_; }

  /// After each event and after whatever panels changed.
  void apply(const EditorRequests& requests);
  /// Goes on by so many seconds: time line, results of the work beside, the picture.
  void update(double seconds);

  /// RGB; empty where the frame has no photograph. `picture_number` grows with every other picture.
  const Image& picture() const { return picture_; }
  int picture_number() const { return picture_number_; }
  bool has_matte() const { return has_matte_; }

  /// Something runs or will run by itself.
  bool busy() const;
  /// Mattes are being made again, or will be.
  bool remaking() const { return pending_ || job_ == Job::Remake; }
  std::optional<BackgroundTask::Progress> progress() const;
  /// Until what runs beside has ended; update() takes its result. For those who have no window to draw
  /// meanwhile.
  void wait() const { task_.wait(); }

 private:
  enum class Job { None, Remake, Components, Flicker };

  MatteEditorModel(MatteEditorModelOptions options, std::unique_ptr<capture::TakeReader> take,
                   std::unique_ptr<pipeline::EditedCamera> edited);
  void take_state();
  void take_labels();
  void answer(const EditorRequests& requests);
  bool save_edits();
  void collect();
  void collect_made();
  void end_job();
  void begin_job();
  void begin_remake();
  void begin_components();
  bool begin_flicker();
  void show();
  Image load_matte(int frame) const;
  std::vector<Image> load_labels(int frame);
  std::string labels_lag(int frame) const;
  bool matte_exists(int frame) const;

  MatteEditorModelOptions options_;
  std::unique_ptr<capture::TakeReader> take_;  // of this thread; the work beside has its own
  std::unique_ptr<pipeline::EditedCamera> edited_;
  std::string method_;  // how mattes are made
  int camera_;
  std::unique_ptr<EditorState> state_;
  CameraEdits last_edits_;  // as of the last apply()
  bool pending_ = false;    // mattes are to be made again

  Image photograph_, picture_;
  int photograph_frame_ = -1, picture_number_ = 0;
  struct Shown {
    int frame = -1;
    MatteView view = MatteView::Photograph;
    bool operator==(const Shown&) const = default;
  };
  std::optional<Shown> shown_;
  bool has_matte_ = false;
  int components_frame_ = -1;
  matting::MattingComponents components_;

  Job job_ = Job::None;
  std::chrono::steady_clock::time_point job_began_;
  struct Outcome {  // written by the work beside, read after it has ended; `made` at any time
    std::mutex mutex;
    std::vector<int> made;
    Result<std::vector<int>> remade = std::vector<int>();
    Result<matting::MattingComponents> components = matting::MattingComponents();
    std::vector<std::pair<int, double>> flicker;
    std::vector<int> unasked;  // it was stopped before them
    std::optional<Error> flicker_error;
    int frame = 0;
  };
  Outcome outcome_;
  std::vector<bool> unmetered_;  // frames whose flicker is not known and can be
  BackgroundTask task_;          // last: it ends before what it works on
};

}  // namespace floatstage::apps
