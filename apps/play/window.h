#pragma once

#include <memory>
#include <string>

#include "core/image.h"
#include "core/result.h"
#include "render/gl_context.h"

struct GLFWwindow;

namespace floatstage {

/// One GLFW window with an OpenGL 4.5 context and Dear ImGui in it. Main thread only; one at a time.
class Window {
 public:
  /// Unsupported when there is no display or no OpenGL 4.5, and says what to do.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool should_close() const;
  /// Takes events and begins a frame of the user interface; waits up to `patience` seconds for an event first.
  void begin_frame(double patience);
  /// Draws the user interface and shows it. `picture`, when not null, receives the whole window: RGB, top row first.
  void end_frame(Image* picture = nullptr);

 private:
  Window() = default;
  Image grab(int width, int height) const;

  GLFWwindow* window_ = nullptr;
  std::unique_ptr<GlContext> gl_;
};

}  // namespace floatstage
