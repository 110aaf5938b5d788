#include "apps/viewer/window/window.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#define GLFW_INCLUDE_NONE  // epoxy brings OpenGL
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include "apps/viewer/window/layout.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

std::string glfw_error() {
  const char* what = nullptr;
  glfwGetError(&what);
  return what ? what : "no reason given";
}

static_assert(GLFW_KEY_ESCAPE == kKeyEscape && GLFW_KEY_ENTER == kKeyEnter && GLFW_KEY_TAB == kKeyTab &&
              GLFW_KEY_DELETE == kKeyDelete && GLFW_KEY_RIGHT == kKeyRight && GLFW_KEY_LEFT == kKeyLeft &&
              GLFW_KEY_HOME == kKeyHome && GLFW_KEY_END == kKeyEnd && GLFW_KEY_F3 == kKeyF3 &&
              GLFW_KEY_F12 == kKeyF12);
static_assert(GLFW_MOUSE_BUTTON_LEFT == 0 && GLFW_MOUSE_BUTTON_RIGHT == 1 && GLFW_MOUSE_BUTTON_MIDDLE == 2);

Window::Input& input_of(GLFWwindow* window) {
  return *static_cast<Window::Input*>(glfwGetWindowUserPointer(window));
}

// Where the pointer is by now is another matter: a hand may have moved on before its button was heard of.
InputEvent event_of(GLFWwindow* window, InputEvent::Kind kind, int mods) {
  InputEvent e;
  e.kind = kind;
  e.x = input_of(window).x, e.y = input_of(window).y;
  e.control = mods & GLFW_MOD_CONTROL;
  e.shift = mods & GLFW_MOD_SHIFT;
  return e;
}

}  // namespace

// The display says how many of its pixels a drawn one is: letters keep their size in the hand.
void Window::scale_fonts(GLFWwindow* window) {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window, &x, &y);
  const float scale = std::clamp(std::max(x, y), 1.F, 4.F);
  ImFontConfig font;
  font.SizePixels = std::round(kFontPixels * scale);
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::GetStyle().ScaleAllSizes(scale);
}

// Before ImGui listens: it calls on what was there before.
void Window::listen() {
  glfwSetWindowUserPointer(window_, &input_);
  glfwGetCursorPos(window_, &input_.x, &input_.y);
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    input_of(w).x = x, input_of(w).y = y;
    input_of(w).events.push_back(event_of(w, InputEvent::Kind::Move, 0));
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int mods) {
    if (action == GLFW_PRESS &&
        ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel))
      return;
    InputEvent e =
        event_of(w, action == GLFW_PRESS ? InputEvent::Kind::Press : InputEvent::Kind::Release, mods);
    e.button = button;
    input_of(w).events.push_back(e);
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double notches) {
    InputEvent e = event_of(w, InputEvent::Kind::Wheel, 0);
    e.wheel = notches;
    input_of(w).events.push_back(e);
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int mods) {
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    InputEvent e = event_of(w, InputEvent::Kind::Key, mods);
    e.key = key;
    e.repeated = action == GLFW_REPEAT;
    input_of(w).events.push_back(e);
  });
}

bool Window::hand_waits() {
  glfwPollEvents();
  bool held = false;
  for (int button = GLFW_MOUSE_BUTTON_LEFT; button <= GLFW_MOUSE_BUTTON_MIDDLE; ++button)
    held = held || glfwGetMouseButton(window_, button) == GLFW_PRESS;
  return std::any_of(input_.events.begin(), input_.events.end(),
                     [&](const InputEvent& e) { return held || e.kind != InputEvent::Kind::Move; });
}

std::vector<InputEvent> Window::take_input() { return std::exchange(input_.events, {}); }

Result<std::unique_ptr<Window>> Window::open(const std::string& title, int width, int height) {
  if (!glfwInit())
    return fail(ErrorCode::Unsupported, text("no window can be opened (", glfw_error(),
                                             "); run on a desktop, or `floatstage render` for a video"));
  std::unique_ptr<Window> window(new Window);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  window->window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window->window_)
    return fail(ErrorCode::Unsupported,
                text("no window with OpenGL 4.5 (", glfw_error(), "); see `floatstage check`"));
  glfwMakeContextCurrent(window->window_);
  glfwSwapInterval(1);
  Result<std::unique_ptr<render::GlContext>> gl = render::GlContext::adopt_current();
  if (!gl) return forward(gl);
  window->gl_ = std::move(*gl);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // the layout is ours; leave no file in the user's folder
  ImGui::StyleColorsDark();
  scale_fonts(window->window_);
  window->listen();
  ImGui_ImplGlfw_InitForOpenGL(window->window_, true);
  ImGui_ImplOpenGL3_Init("#version 450");
  return window;
}

Window::~Window() {
  if (ImGui::GetCurrentContext()) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  gl_.reset();
  if (window_) glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::should_close() const { return glfwWindowShouldClose(window_); }

void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }

void Window::begin_frame(double patience) {
  if (patience > 0)
    glfwWaitEventsTimeout(patience);
  else
    glfwPollEvents();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void Window::drop_frame() { ImGui::EndFrame(); }

void Window::end_frame(Image* picture) {
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);
  glClearColor(0.10f, 0.105f, 0.115f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  // The window's rows run bottom up, as ImGui expects; our own pictures run top down everywhere else.
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  if (picture) *picture = grab(width, height);  // before the swap: afterwards the back buffer is undefined
  glfwSwapBuffers(window_);
}

Image Window::grab(int width, int height) const {
  Image upside_down(width, height, 3), image(width, height, 3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glReadBuffer(GL_BACK);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.pixels.data());
  for (int y = 0; y < height; ++y)
    std::memcpy(image.at(0, y), upside_down.at(0, height - 1 - y), static_cast<std::size_t>(width) * 3);
  return image;
}

}  // namespace floatstage::apps
