#include "apps/viewer/play/play.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>

#include "apps/viewer/mattes/matte_editor.h"
#include "apps/viewer/play/player.h"
#include "apps/viewer/window/screenshot.h"
#include "apps/viewer/window/window.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

void say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

// One window with two modes. What is not open is null.
class PlayWindow {
 public:
  explicit PlayWindow(const PlayOptions& options) : options_(options), editing_(options.mattes) {}

  Result<void> open() {
    Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(options_.take, options_.labels);
    if (!take) return forward(take);
    take_ = std::move(*take);
    // What is wrong is said before a window opens.
    if (Result<void> ok = editing_ ? open_editor(options_.frame) : Player::check(options_, *take_); !ok)
      return ok;
    Result<std::unique_ptr<Window>> window =
        Window::open("Floatstage: " + options_.take.string(), options_.width, options_.height);
    if (!window) return forward(window);
    window_ = std::move(*window);
    options_.renderer.back_end = render::back_end_in_window(options_.renderer.back_end, window_->gl());
    if (editing_) return {};
    return open_player();
  }

  Result<void> run() {
    constexpr double kIdle = 0.1;     // seconds to sleep while nothing moves
    constexpr int kSettleFrames = 3;  // the user interface needs a few frames before its layout stands
    int settled = 0;
    bool said = false;
    looked_ = Clock::now();  // what came while it opened is not an input to a picture
    while (!window_->should_close() && !(options_.stop && options_.stop())) {
      const bool busy = editing_ ? editor_->busy() : player_->busy();
      const bool waits = !busy && options_.screenshot.empty() && !window_->input_waits();
      const Clock::time_point polled = Clock::now();
      window_->begin_frame(waits ? kIdle : 0);
      const Clock::time_point begun = Clock::now();
      // While the window waits an input wakes it; what came while it drew has waited since the last look.
      Clock::time_point came = waits && woke(begun - polled) ? begun : std::exchange(looked_, begun);
      looked_ = begun;
      if (owed_) came = std::min(came, *owed_);
      const bool has_input = frame() || owed_;
      settled = (editing_ ? editor_->stands() : player_->stands()) ? settled + 1 : 0;
      const bool last = !options_.screenshot.empty() && settled >= kSettleFrames;
      if (!editing_ && player_->gave_up() && !screenshot_) {  // a hand waits: what it wants is next
        window_->drop_frame();
        if (has_input) owed_ = came;
        continue;
      }
      owed_.reset();
      Image picture;
      window_->end_frame(last || screenshot_ ? &picture : nullptr);
      if (has_input && !editing_)
        after_input_.add(1e3 * std::chrono::duration<double>(Clock::now() - came).count());
      if (!editing_) player_->frame_took(std::chrono::duration<double>(Clock::now() - begun).count());
      if (last) return save_png(picture, options_.screenshot);
      if (std::exchange(screenshot_, false)) keep(picture);
      if (editing_ && !said) say("the matte editor is open");
      said = said || editing_;
    }
    return {};
  }

  PlayReport report() const {
    return {.pictures = player_ ? player_->times() : CanvasTimes(),
            .after_input = after_input_,
            .frame = editing_ ? editor_->frame_number() : player_->frame_number(),
            .events = events_,
            .keys = keys_,
            .presses = presses_,
            .renderer = options_.renderer.back_end == render::BackEnd::Gl ? "gl" : "cpu",
            .heard = player_ ? player_->shown_while_heard() : std::vector<ShownWhileHeard>()};
  }

 private:
  using Clock = std::chrono::steady_clock;

  Result<void> open_editor(int frame) {
    MatteEditorModelOptions model;
    model.camera = {.take = options_.take,
                    .serial = options_.camera.empty() ? take_->rig().cameras.front().serial : options_.camera,
                    .how = options_.matte,
                    .guide = options_.guide,
                    .threads = 0};
    model.frame = frame;
    model.view = options_.view;
    model.automatic = options_.automatic;
    model.say = say;
    Result<std::unique_ptr<MatteEditor>> editor = MatteEditor::open(std::move(model));
    if (!editor) return forward(editor);
    editor_ = std::move(*editor);
    return {};
  }

  Result<void> open_player() {
    Result<std::unique_ptr<Player>> player = Player::open(options_, *take_);
    if (!player) return forward(player);
    player_ = std::move(*player);
    player_->give_up_when([this] { return hand_waits(); });
    return {};
  }

  // Whether it slept: an event that was there already is handed out at once.
  static bool woke(Clock::duration waited) { return waited > std::chrono::milliseconds(1); }

  /// Looks for events, but not for every row of a picture.
  bool hand_waits() {
    constexpr auto kPatience = std::chrono::milliseconds(2);
    const Clock::time_point now = Clock::now();
    if (now - asked_ < kPatience) return false;
    asked_ = now;
    const bool heard = window_->input_waits(), hand = window_->hand_waits();
    if (!heard && !window_->input_waits()) looked_ = now;
    return hand;
  }

  /// Whether hands did something.
  bool frame() {
    const std::vector<InputEvent> input = window_->take_input();
    events_ += static_cast<long>(input.size());
    for (const InputEvent& e : input) {
      keys_ += e.kind == InputEvent::Kind::Key && !e.repeated ? 1 : 0;
      presses_ += e.kind == InputEvent::Kind::Press ? 1 : 0;
    }
    if (!editing_) {
      const auto pressed = [&](int key) {
        return std::any_of(input.begin(), input.end(), [&](const InputEvent& e) {
          return e.kind == InputEvent::Kind::Key && e.key == key && !e.control;
        });
      };
      screenshot_ = pressed(kKeyF12);
      player_->frame(input);
      if (pressed('M')) to_editor();
      return !input.empty();
    }
    const EditorRequests requests = editor_->frame(input);
    screenshot_ = requests.screenshot;
    if (requests.quit) window_->close();
    if (requests.player) to_player();
    return !input.empty();
  }

  void to_editor() {
    if (!editor_)
      if (Result<void> ok = open_editor(player_->frame_number()); !ok)
        return player_->show_status(ok.error().message);
    editor_->go_to(player_->frame_number());
    editing_ = true;
  }

  void to_player() {
    if (!player_)
      if (Result<void> ok = open_player(); !ok) return editor_->show_status(ok.error().message);
    player_->forget_scenes();
    player_->go_to(editor_->frame_number());
    editing_ = false;
  }

  void keep(const Image& picture) {
    const std::string line = keep_screenshot(picture);
    say(line);
    editing_ ? editor_->show_status(line) : player_->show_status(line);
  }

  PlayOptions options_;
  bool editing_, screenshot_ = false;
  long events_ = 0, keys_ = 0, presses_ = 0;
  PictureTimes after_input_;
  Clock::time_point looked_ = Clock::now();  // for events
  Clock::time_point asked_;                  // while a picture was drawn
  std::optional<Clock::time_point> owed_;    // when the input came whose frame was not shown
  std::unique_ptr<capture::TakeReader> take_;
  std::unique_ptr<Window> window_;  // outlives what draws in it
  std::unique_ptr<Player> player_;
  std::unique_ptr<MatteEditor> editor_;
};

}  // namespace

Result<PlayReport> play_take(const PlayOptions& options) {
  PlayWindow window(options);
  if (Result<void> ok = window.open(); !ok) return forward(ok);
  if (Result<void> ok = window.run(); !ok) return forward(ok);
  return window.report();
}

}  // namespace floatstage::apps
