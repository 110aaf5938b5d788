#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/viewer/window/input_event.h"
#include "core/image.h"
#include "core/result.h"
#include "render/gl_context.h"

struct GLFWwindow;

namespace floatstage::apps {

/// One GLFW window with an OpenGL 4.5 context and Dear ImGui in it. Main thread only; one at a time.
class Window {
 public:
  /// Unsupported when there is no display or no OpenGL 4.5, and says what to do.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  const render::GlContext& gl() const { return *gl_; }
  bool should_close() const;
  void close();  ///< as if somebody had closed it
  /// Takes events and begins a frame of the user interface; waits up to `patience` seconds for an event
  /// first.
  void begin_frame(double patience);
  /// What hands did since the last call, in order; keys only while no text is being typed, and presses only
  /// where no menu is open. Panels below still get all of it.
  std::vector<InputEvent> take_input();
  /// Whether hands are waiting for take_input(): a key, a button, the wheel, or a move with a button held.
  /// Listens for events, also between begin_frame() and end_frame().
  bool hand_waits();
  /// Whether anything waits for take_input().
  bool input_waits() const { return !input_.events.empty(); }
  /// Ends the frame without showing it: the window keeps what it shows.
  void drop_frame();
  /// Draws the user interface and shows it. `picture`, when not null, receives the whole window: RGB, top row
  /// first.
  void end_frame(Image* picture = nullptr);

  /// What was heard and not taken yet, and where the pointer was when it was heard.
  struct Input {
    std::vector<InputEvent> events;
    double x = 0, y = 0;
  };

 private:
  Window() = default;
  Image grab(int width, int height) const;
  void listen();
  static void scale_fonts(GLFWwindow* window);

  GLFWwindow* window_ = nullptr;
  Input input_;
  std::unique_ptr<render::GlContext> gl_;
};

}  // namespace floatstage::apps
