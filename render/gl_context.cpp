#include "render/gl_context.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "core/log.h"
#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr int kMajor = 4, kMinor = 5;
constexpr const char* kSoftware[] = {"llvmpipe", "softpipe", "swrast", "SWR", "Software"};  // GL_RENDERER

bool has_extension(const char* list, const char* name) {
  if (list == nullptr) return false;
  const std::size_t length = std::strlen(name);
  for (const char* at = std::strstr(list, name); at != nullptr; at = std::strstr(at + length, name))
    if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
  return false;
}

std::string gl_string(GLenum name) {
  const GLubyte* s = glGetString(name);
  return s == nullptr ? std::string("?") : std::string(reinterpret_cast<const char*>(s));
}

/// FLOATSTAGE_GL_DEBUG=1: what the driver has to say (errors, undefined behaviour, slow paths) goes to the
/// log.
bool listens_to_driver() {
  const char* wanted = std::getenv("FLOATSTAGE_GL_DEBUG");
  return wanted != nullptr && std::string_view(wanted) == "1";
}

void log_driver(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* message,
                const void*) {
  const std::string said = text("OpenGL: ", std::string_view(message, static_cast<std::size_t>(length)));
  if (type == GL_DEBUG_TYPE_ERROR || severity == GL_DEBUG_SEVERITY_HIGH)
    log::warning(said);
  else
    log::debug(said);
}

Result<void> set_conventions() {
  if (epoxy_gl_version() < kMajor * 10 + kMinor || !epoxy_is_desktop_gl())
    return fail(ErrorCode::Unsupported, text("this machine offers OpenGL ", gl_string(GL_VERSION),
                                             "; 4.5 core is needed: install a newer "
                                             "driver, or libgl1-mesa-dri for software rendering"));
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glDisable(GL_DITHER);
  if (listens_to_driver()) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(log_driver, nullptr);
  }
  return {};
}

class AdoptedContext : public GlContext {
 public:
  std::string description() const override {
    return text(gl_string(GL_VENDOR), ", ", gl_string(GL_RENDERER), ", OpenGL ", gl_string(GL_VERSION));
  }
  bool is_software() const override { return is_software_gl(); }
};

class EglContext : public AdoptedContext {
 public:
  EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  ~EglContext() override {
    // The display stays initialised: EGL hands every caller of this process the same one.
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

 private:
  EGLDisplay display_;
  EGLContext context_;
};

/// A 4.5 core context without surface on this display, made current; null and a reason in `tried` otherwise.
std::unique_ptr<GlContext> context_on(EGLDisplay display, const std::string& name, std::string& tried) {
  auto give_up = [&](const char* why) {
    tried += text(tried.empty() ? "" : "; ", name, ": ", why);
    return nullptr;
  };
  if (display == EGL_NO_DISPLAY) return give_up("no display");
  if (!eglInitialize(display, nullptr, nullptr)) return give_up("cannot be initialised");
  if (!has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    return give_up("cannot render without a surface");
  if (!eglBindAPI(EGL_OPENGL_API)) return give_up("no desktop OpenGL");
  const EGLint config_attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  EGLConfig config = EGL_NO_CONFIG_KHR;
  EGLint configs = 0;
  if (!eglChooseConfig(display, config_attributes, &config, 1, &configs) || configs == 0)
    config = EGL_NO_CONFIG_KHR;
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               kMajor,
                               EGL_CONTEXT_MINOR_VERSION,
                               kMinor,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_CONTEXT_OPENGL_DEBUG,
                               listens_to_driver() ? EGL_TRUE : EGL_FALSE,
                               EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) return give_up("no OpenGL 4.5 core context");
  auto owner = std::make_unique<EglContext>(display, context);
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    return give_up("cannot be made current");
  if (!set_conventions()) return give_up("OpenGL is older than 4.5");
  return owner;
}

/// Whether EGL can list devices: EGL_EXT_device_base is what became two extensions later; NVIDIA names that
/// alone.
bool lists_devices() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool both =
      has_extension(client, "EGL_EXT_device_enumeration") && has_extension(client, "EGL_EXT_device_query");
  return has_extension(client, "EGL_EXT_platform_device") &&
         (both || has_extension(client, "EGL_EXT_device_base"));
}

/// The devices EGL lists, hardware or software ones.
std::vector<EGLDeviceEXT> devices(bool software) {
  if (!lists_devices()) return {};
  EGLint count = 0;
  if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0) return {};
  std::vector<EGLDeviceEXT> all(static_cast<std::size_t>(count));
  if (!eglQueryDevicesEXT(count, all.data(), &count)) return {};
  all.resize(static_cast<std::size_t>(count));
  std::vector<EGLDeviceEXT> chosen;
  for (EGLDeviceEXT device : all)
    if (has_extension(eglQueryDeviceStringEXT(device, EGL_EXTENSIONS), "EGL_MESA_device_software") ==
        software)
      chosen.push_back(device);
  return chosen;
}

std::unique_ptr<GlContext> on_devices(bool software, std::string& tried) {
  int number = 0;
  for (EGLDeviceEXT device : devices(software)) {
    const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
    const std::string name = text(software ? "EGL software device " : "EGL device ", number++);
    if (auto context = context_on(display, name, tried)) return context;
  }
  return nullptr;
}

std::unique_ptr<GlContext> on_surfaceless_mesa(std::string& tried) {
  if (!has_extension(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless"))
    return nullptr;
  const EGLDisplay display =
      eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  return context_on(display, "surfaceless Mesa", tried);
}

}  // namespace

bool is_software_gl() {
  const std::string name = gl_string(GL_RENDERER);
  return std::any_of(std::begin(kSoftware), std::end(kSoftware),
                     [&](const char* s) { return name.find(s) != std::string::npos; });
}

Result<std::unique_ptr<GlContext>> GlContext::headless() {
  const char* wanted = std::getenv("FLOATSTAGE_GL");
  const std::string kind = wanted == nullptr ? "" : wanted;
  if (!kind.empty() && kind != "software" && kind != "device")
    return fail(ErrorCode::InvalidArgument,
                text("FLOATSTAGE_GL is '", kind, "'; it may be 'software' or 'device'"));
  std::string tried;
  std::unique_ptr<GlContext> context;
  if (kind != "software") context = on_devices(false, tried);
  if (!context && kind != "device") context = on_devices(true, tried);
  if (!context && kind != "device") context = on_surfaceless_mesa(tried);
  if (!context)
    return fail(
        ErrorCode::Unsupported,
        text("no OpenGL 4.5 without a window (", tried.empty() ? "EGL lists no device that has it" : tried,
             "): install libegl-mesa0 and libgl1-mesa-dri, or the GPU's driver"));
  return context;
}

Result<std::unique_ptr<GlContext>> GlContext::adopt_current() {
  if (Result<void> set = set_conventions(); !set) return forward(set);
  return std::unique_ptr<GlContext>(std::make_unique<AdoptedContext>());
}

}  // namespace floatstage::render
