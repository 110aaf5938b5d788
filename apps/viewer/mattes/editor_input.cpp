#include <algorithm>
#include <cmath>

#include "apps/viewer/mattes/editor_state.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr int kLeft = 0, kRight = 1, kMiddle = 2;
constexpr double kNotch = 1.2;  // of the wheel
constexpr double kBrushStep = 1.25;

EditorRequests press(const InputEvent& e, EditorState& state) {
  EditorRequests requests;
  if (!state.fit.holds(e.x, e.y) || state.held >= 0 || !state.question.empty()) return requests;
  state.held = e.button;
  if (e.button != kLeft && e.button != kRight) return requests;
  state.time.playing = false;
  requests.edited =
      state.session.press(state.time.frame(), state.fit.to_photograph(e.x, e.y), e.button == kRight);
  return requests;
}

void jump(EditorState& state, std::optional<int> frame, const char* otherwise) {
  if (frame)
    state.time.playing = false, state.time.seek(*frame);
  else
    state.status = otherwise;
}

EditorRequests control_key(const InputEvent& e, EditorState& state) {
  EditorRequests requests;
  EditSession& session = state.session;
  const bool again = e.key == 'Y' || (e.key == 'Z' && e.shift);
  if (e.key == 'Z' || e.key == 'Y') {
    requests.edited = again ? session.redo() : session.undo();
    if (!requests.edited) state.status = again ? "there is nothing to redo" : "there is nothing to undo";
  }
  requests.quit = e.key == 'Q';
  return requests;
}

// Whether the key moves in time.
bool time_key(int key, EditorState& state) {
  TimeLine& time = state.time;
  switch (key) {
    case ' ':
      time.playing = !time.playing;
      return true;
    case kKeyLeft:
      time.step(-1);
      return true;
    case kKeyRight:
      time.step(1);
      return true;
    case kKeyHome:
      time.seek(0);
      return true;
    case kKeyEnd:
      time.seek(time.frames() - 1);
      return true;
    case ',':
      jump(state, state.session.keyframe_before(time.frame()), "there is no keyframe before this frame");
      return true;
    case '.':
      jump(state, state.session.keyframe_after(time.frame()), "there is no keyframe after this frame");
      return true;
    case 'W':
      go_to_worst(state);
      return true;
    default:
      return false;
  }
}

// Whether the key changes the tool or how the matte is looked at.
bool tool_key(int key, EditorState& state) {
  EditSession& session = state.session;
  const int views = static_cast<int>(matte_view_names().size());
  if (key >= '1' && key < '1' + views) {
    state.view = static_cast<MatteView>(key - '1');
    return true;
  }
  switch (key) {
    case 'V':
      state.view = static_cast<MatteView>((static_cast<int>(state.view) + 1) % views);
      return true;
    case 'L':
      choose_next_label(state);
      return true;
    case 'F':
      session.tool = EditTool::Stroke;
      return true;
    case 'G':
      session.tool = EditTool::Garbage;
      return true;
    case 'H':
      session.tool = EditTool::HoldOut;
      return true;
    case '[':
      session.grow(1 / kBrushStep);
      return true;
    case ']':
      session.grow(kBrushStep);
      return true;
    case '0':
      state.fit.whole();
      return true;
    case 'A':
      state.automatic = !state.automatic;
      return true;
    case kKeyEscape:
      session.give_up();
      return true;
    default:
      return false;
  }
}

EditorRequests key(const InputEvent& e, EditorState& state) {
  if (e.control) return control_key(e, state);
  EditorRequests requests;
  requests.yes = !state.question.empty() && e.key == 'Y';
  requests.no = !state.question.empty() && (e.key == 'N' || e.key == kKeyEscape);
  if (requests.yes || requests.no) return requests;
  if (time_key(e.key, state) || tool_key(e.key, state)) return requests;
  if (e.key == kKeyDelete) {
    requests.edited = state.session.remove_keyframe(state.time.frame());
    if (!requests.edited) state.status = "this frame is no keyframe";
  }
  requests.remake = e.key == kKeyEnter;
  requests.next_camera = e.key == kKeyTab;
  requests.player = e.key == 'M';
  requests.screenshot = e.key == kKeyF12;
  return requests;
}

}  // namespace

void go_to_worst(EditorState& state) {
  const std::optional<int> frame = next_worst(state.worst, state.time.frame());
  jump(state, frame, "no frame flickers, as far as has been metered");
  if (frame)
    state.status =
        text("frame ", *frame, " flickers by ",
             std::round(state.flicker[static_cast<std::size_t>(*frame)].value_or(0) * 10000) / 100, " %");
}

void choose_next_label(EditorState& state) {
  std::string& subject = state.session.subject;
  if (state.labels.empty()) {
    state.status = "the take has no labels; write the name of one in the panel";
    return;
  }
  const auto here = std::find(state.labels.begin(), state.labels.end(), subject);
  const auto next = here == state.labels.end() ? state.labels.begin() : here + 1;
  subject = next == state.labels.end() ? "" : *next;
  state.status = subject.empty() ? "strokes are nobody's in particular" : text("strokes are '", subject, "'");
}

bool choose_label(EditorState& state, const std::string& name) {
  if (!is_usable_label(name)) {
    state.status = text("'", name, "' cannot be a label: letters, digits, '-' and '_', at most 64");
    return false;
  }
  if (std::find(state.labels.begin(), state.labels.end(), name) == state.labels.end())
    state.labels.push_back(name);
  state.session.subject = name;
  state.status = text("strokes are '", name, "'");
  return true;
}

EditorRequests take_input(const InputEvent& e, EditorState& state) {
  EditorRequests requests;
  switch (e.kind) {
    case InputEvent::Kind::Press:
      requests = press(e, state);
      break;
    case InputEvent::Kind::Move:
      if (state.held == kMiddle) state.fit.pan(e.x - state.pointer_x, e.y - state.pointer_y);
      if (state.held == kLeft || state.held == kRight) state.session.drag(state.fit.to_photograph(e.x, e.y));
      break;
    case InputEvent::Kind::Release:
      if (e.button != state.held) break;
      state.held = -1;
      requests.edited = state.session.release();
      break;
    case InputEvent::Kind::Wheel:
      if (state.fit.holds(e.x, e.y)) state.fit.zoom(e.x, e.y, std::pow(kNotch, e.wheel));
      break;
    case InputEvent::Kind::Key:
      requests = key(e, state);
      break;
  }
  state.pointer_x = e.kind == InputEvent::Kind::Key ? state.pointer_x : e.x;
  state.pointer_y = e.kind == InputEvent::Kind::Key ? state.pointer_y : e.y;
  return requests;
}

}  // namespace floatstage::apps
