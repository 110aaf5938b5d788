#include <array>
#include <cmath>
#include <utility>

#include "capture/aravis/aravis_settings.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr const char* kGain = "gain";
constexpr std::array<std::pair<const char*, const char*>, 3> kRatios = {
    {{"white-balance-red", "Red"}, {"white-balance-green", "Green"}, {"white-balance-blue", "Blue"}}};

bool has(ArvCamera* camera, const char* feature) {
  return arv_camera_is_feature_available(camera, feature, nullptr);
}

// A camera that does not answer takes seconds for each question.
class Reader {
 public:
  explicit Reader(ArvCamera* camera) : camera_(camera) {}

  template <typename Bounds, typename Value>
  void read(const char* name, Bounds bounds, Value value) {
    if (silent_) return;
    GlibError error;
    CameraControl control;
    control.name = name;
    bounds(camera_, &control.least, &control.most, error.out());
    if (!error) control.value = value(camera_, error.out());
    silent_ = error.is(ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TIMEOUT);
    const bool finite =
        std::isfinite(control.value) && std::isfinite(control.least) && std::isfinite(control.most);
    if (!error && finite && control.most > control.least) found.push_back(control);
  }

  std::vector<CameraControl> found;

 private:
  ArvCamera* camera_;
  bool silent_ = false;
};

void write(ArvCamera* camera, const std::string& name, double value, GError** error) {
  if (name == kExposureControl) {
    if (arv_camera_is_exposure_auto_available(camera, nullptr))
      arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, nullptr);
    return arv_camera_set_exposure_time(camera, value, error);
  }
  if (name == kGain) {
    if (arv_camera_is_gain_auto_available(camera, nullptr))
      arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, nullptr);
    return arv_camera_set_gain(camera, value, error);
  }
  if (has(camera, "BalanceWhiteAuto")) arv_camera_set_string(camera, "BalanceWhiteAuto", "Off", nullptr);
  for (const auto& [ratio, channel] : kRatios) {
    if (name != ratio) continue;
    arv_camera_set_string(camera, "BalanceRatioSelector", channel, error);
    if (!*error) arv_camera_set_float(camera, "BalanceRatio", value, error);
  }
}

}  // namespace

std::vector<CameraControl> light_controls(ArvCamera* camera) {
  Reader reader(camera);
  if (arv_camera_is_exposure_time_available(camera, nullptr))
    reader.read(kExposureControl, arv_camera_get_exposure_time_bounds, arv_camera_get_exposure_time);
  if (arv_camera_is_gain_available(camera, nullptr))
    reader.read(kGain, arv_camera_get_gain_bounds, arv_camera_get_gain);
  if (!has(camera, "BalanceRatioSelector") || !has(camera, "BalanceRatio")) return reader.found;
  for (const auto& ratio : kRatios) {
    const auto bounds = [&](ArvCamera* of, double* least, double* most, GError** error) {
      arv_camera_set_string(of, "BalanceRatioSelector", ratio.second, error);
      if (!*error) arv_camera_get_float_bounds(of, "BalanceRatio", least, most, error);
    };
    const auto value = [](ArvCamera* of, GError** error) {
      return arv_camera_get_float(of, "BalanceRatio", error);
    };
    reader.read(ratio.first, bounds, value);
  }
  return reader.found;
}

Result<void> set_light_control(ArvCamera* camera, const std::string& serial, const std::string& name,
                               double value) {
  const std::string who = text("camera '", serial, "'");
  const Result<void> fits = check_control(light_controls(camera), who, name, value);
  if (!fits) return fits;
  GlibError error;
  write(camera, name, value, error.out());
  if (!error) return {};
  return fail(ErrorCode::InvalidArgument,
              text(who, ": it refuses ", name, " = ", value, " (", error.message(), ")"));
}

}  // namespace floatstage::capture
