#include "tests/soak/gige_stage.h"

#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <arv.h>

#include "core/text.h"

namespace floatstage {

struct GigeStage::Camera {
  std::string address;
  double rate = 0;
  std::vector<Frame> pictures;
  ArvGvFakeCamera* device = nullptr;

  ~Camera() {
    if (device != nullptr) g_object_unref(device);
  }
  // Aravis has the cameras of one rate wake together, on whole periods of the wall clock.
  static void fill(ArvBuffer* buffer, void* camera, guint32, guint32, ArvPixelFormat) {
    const auto* self = static_cast<const Camera*>(camera);
    const double now =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    const auto period = static_cast<std::size_t>(std::llround(now * self->rate));
    const Frame& picture = self->pictures[period % self->pictures.size()];
    // The buffer holds a picture of this size, though it does not say so before it is filled.
    if (arv_buffer_get_image_width(buffer) != picture.layout.width ||
        arv_buffer_get_image_height(buffer) != picture.layout.height)
      return;
    void* data = const_cast<void*>(arv_buffer_get_data(buffer, nullptr));
    std::memcpy(data, picture.pixels.get(), picture.layout.size_bytes);
  }
};

GigeStage::GigeStage(const SyntheticRigOptions& options, double rate, int loop,
                     const std::vector<double>& lost)
    : rig_(synthetic_rig(options)), rate_(rate) {
  SyntheticStudioOptions studio;
  studio.frame_rate = rate;
  studio.samples = 1;
  const Result<SyntheticStudio> stage = SyntheticStudio::create(rig_, studio);
  if (!stage) throw std::runtime_error(stage.error().message);
  for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
    auto camera = std::make_unique<Camera>();
    camera->address = text("127.0.0.", i + 1);
    camera->rate = rate;
    for (int k = 0; k < loop; ++k) camera->pictures.push_back(stage->shoot(static_cast<int>(i), k).frame);
    camera->device = arv_gv_fake_camera_new(camera->address.c_str(), rig_.cameras[i].serial.c_str());
    if (camera->device == nullptr || !arv_gv_fake_camera_is_running(camera->device))
      throw std::runtime_error(text("no fake camera at ", camera->address));
    g_object_set(camera->device, "gvsp-lost-ratio", lost[i], nullptr);
    arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(camera->device), &Camera::fill,
                                     camera.get());
    cameras_.push_back(std::move(camera));
  }
}

GigeStage::~GigeStage() = default;

std::string GigeStage::toml() const {
  std::string tables;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const RigCamera& camera = rig_.cameras[i];
    tables += text("[[camera]]\nserial = '", camera.serial, "'\nsource = 'gige:", camera.serial,
                   "?address=", cameras_[i]->address, "&format=rgb8&width=", camera.model.width,
                   "&height=", camera.model.height, "&rate=", rate_, "&resend=off&packet-socket=off'\n");
  }
  return tables;
}

}  // namespace floatstage
