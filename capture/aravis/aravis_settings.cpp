#include "capture/aravis/aravis_settings.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "capture/aravis/gige_link.h"
#include "core/log.h"

namespace floatstage::capture {
namespace {

struct FormatName {
  PixelFormat format;
  ArvPixelFormat gige;
  const char* genicam;  // as the camera's own list has it
};

constexpr std::array kFormats = {
    FormatName{PixelFormat::Gray8, ARV_PIXEL_FORMAT_MONO_8, "Mono8"},
    FormatName{PixelFormat::Rgb8, ARV_PIXEL_FORMAT_RGB_8_PACKED, "RGB8"},
    FormatName{PixelFormat::BayerRggb8, ARV_PIXEL_FORMAT_BAYER_RG_8, "BayerRG8"},
    FormatName{PixelFormat::Yuyv, ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED, "YUV422_8"},
};

bool is_ptp_lock(const std::string& status) { return status == "Slave" || status == "Master"; }

class Writer {
 public:
  Writer(ArvCamera* camera, const AravisSettings& settings, const std::function<bool()>& stop)
      : camera_(camera), settings_(settings), stop_(stop) {}
  Result<AravisStream> run();

 private:
  Result<void> set_picture();
  Result<void> set_light();
  Result<void> set_trigger();
  Result<void> set_clock();
  Result<void> set_link();
  Result<void> read_back();
  std::string ptp_status() const;

  bool has(const char* feature) const { return arv_camera_is_feature_available(camera_, feature, nullptr); }
  auto refused(ErrorCode code, const std::string& what) const {
    return fail(code, text("camera '", settings_.serial, "': ", what));
  }

  ArvCamera* camera_;
  const AravisSettings& settings_;
  const std::function<bool()>& stop_;
  AravisStream stream_;
};

Result<AravisStream> Writer::run() {
  using Step = Result<void> (Writer::*)();
  for (const Step step : {&Writer::set_picture, &Writer::set_light, &Writer::set_trigger, &Writer::set_clock,
                          &Writer::read_back, &Writer::set_link}) {
    if (Result<void> done = (this->*step)(); !done) return forward(done);
  }
  return std::move(stream_);
}

Result<void> Writer::set_picture() {
  GlibError error;
  if (settings_.format) {
    const auto* known = std::find_if(kFormats.begin(), kFormats.end(),
                                     [&](const FormatName& f) { return f.format == *settings_.format; });
    if (known == kFormats.end())
      return refused(ErrorCode::Unsupported, text("no GigE camera sends ", name_of(*settings_.format)));
    arv_camera_set_pixel_format(camera_, known->gige, error.out());
    if (error)
      return refused(ErrorCode::Unsupported,
                     text("it does not offer the pixel format ", known->genicam, " (", error.message(), ")"));
  }
  if (settings_.width > 0) {
    arv_camera_set_region(camera_, settings_.x, settings_.y, settings_.width, settings_.height, error.out());
    if (error)
      return refused(ErrorCode::InvalidArgument,
                     text("it refuses the region ", settings_.width, "x", settings_.height, "+", settings_.x,
                          "+", settings_.y, " (", error.message(), ")"));
  }
  if (settings_.frame_rate) {
    arv_camera_set_frame_rate(camera_, *settings_.frame_rate, error.out());
    if (error)
      return refused(ErrorCode::InvalidArgument, text("it refuses ", *settings_.frame_rate,
                                                      " pictures a second (", error.message(), ")"));
  }
  return {};
}

Result<void> Writer::set_light() {
  GlibError error;
  if (settings_.exposure_us) {
    if (arv_camera_is_exposure_auto_available(camera_, nullptr))
      arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, nullptr);
    arv_camera_set_exposure_time(camera_, *settings_.exposure_us, error.out());
    if (error)
      return refused(ErrorCode::InvalidArgument, text("it refuses an exposure of ", *settings_.exposure_us,
                                                      " us (", error.message(), ")"));
  }
  if (settings_.gain) {
    if (arv_camera_is_gain_auto_available(camera_, nullptr))
      arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, nullptr);
    arv_camera_set_gain(camera_, *settings_.gain, error.out());
    if (error)
      return refused(ErrorCode::InvalidArgument,
                     text("it refuses a gain of ", *settings_.gain, " (", error.message(), ")"));
  }
  return {};
}

Result<void> Writer::set_trigger() {
  GlibError error;
  if (settings_.trigger == GigeTrigger::FreeRun) {
    if (has("TriggerMode")) arv_camera_set_string(camera_, "TriggerMode", "Off", error.out());
  } else {
    const bool software = settings_.trigger == GigeTrigger::Software;
    arv_camera_set_trigger(camera_, software ? "Software" : settings_.line.c_str(), error.out());
    if (error)
      return refused(
          ErrorCode::Unsupported,
          text("it has no trigger by ", software ? "software" : settings_.line, " (", error.message(), ")"));
  }
  return {};
}

// The camera's words for how its clock follows the network's; the data set is latched first where that is how
// it is read.
std::string Writer::ptp_status() const {
  if (has("PtpDataSetLatch")) arv_camera_execute_command(camera_, "PtpDataSetLatch", nullptr);
  const char* status = nullptr;
  for (const char* feature : {"PtpStatus", "GevIEEE1588Status"})
    if (!status && has(feature)) status = arv_camera_get_string(camera_, feature, nullptr);
  return status ? status : "";
}

// All cameras of a studio are on one clock or none is: one that does not lock is refused, never mixed in.
Result<void> Writer::set_clock() {
  if (!settings_.ptp) return {};
  GlibError error;
  const char* feature = has("PtpEnable") ? "PtpEnable" : has("GevIEEE1588") ? "GevIEEE1588" : nullptr;
  if (!feature)
    return refused(ErrorCode::Unsupported,
                   "it has neither PtpEnable nor GevIEEE1588; leave ptp off and its clock "
                   "will be fitted to the studio's");
  arv_camera_set_boolean(camera_, feature, TRUE, error.out());
  if (error) return refused(ErrorCode::Unsupported, text("it refuses ", feature, " (", error.message(), ")"));
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(settings_.ptp_wait_s);
  std::string status = ptp_status();
  while (!is_ptp_lock(status) && std::chrono::steady_clock::now() < end) {
    if (stop_ && stop_())
      return refused(ErrorCode::Cancelled, "interrupted before its clock was the network's");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    status = ptp_status();
  }
  if (!is_ptp_lock(status))
    return refused(ErrorCode::Timeout,
                   text("its clock does not follow the network's after ", settings_.ptp_wait_s,
                        " s (PTP: ", status.empty() ? "not reported" : status,
                        "); check that ptp4l runs and that the switch passes PTP, give it longer by "
                        "ptp-wait=, or set ptp=off for all cameras"));
  stream_.ptp_locked = true;
  std::string offset;
  if (has("PtpOffsetFromMaster"))
    offset =
        text(", ", arv_camera_get_integer(camera_, "PtpOffsetFromMaster", nullptr), " ns from its master");
  log::info(text("camera '", settings_.serial, "': PTP is ", status, offset));
  return {};
}

Result<void> Writer::read_back() {
  GlibError error;
  const ArvPixelFormat format = arv_camera_get_pixel_format(camera_, error.out());
  const auto* known =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const FormatName& f) { return f.gige == format; });
  if (known == kFormats.end()) {
    const char* name = arv_camera_get_pixel_format_as_string(camera_, nullptr);
    return refused(ErrorCode::Unsupported, text("it sends ", name ? name : "an unknown format",
                                                "; set one of Mono8, RGB8, BayerRG8, YUV422_8"));
  }
  gint x = 0, y = 0, width = 0, height = 0;
  arv_camera_get_region(camera_, &x, &y, &width, &height, error.out());
  if (error)
    return refused(ErrorCode::Disconnected, text("it does not tell its region (", error.message(), ")"));
  stream_.layout = packed_layout(known->format, width, height);
  stream_.payload_bytes = arv_camera_get_payload(camera_, error.out());
  if (error || stream_.payload_bytes < stream_.layout.size_bytes)
    return refused(ErrorCode::BadData, text("its payload of ", stream_.payload_bytes,
                                            " bytes is less than a ", width, "x", height, " picture"));
  if (arv_camera_is_frame_rate_available(camera_, nullptr) && settings_.trigger == GigeTrigger::FreeRun)
    stream_.frame_rate = arv_camera_get_frame_rate(camera_, nullptr);
  else if (settings_.frame_rate)
    stream_.frame_rate = *settings_.frame_rate;
  if (arv_camera_is_exposure_time_available(camera_, nullptr)) {
    const double us = arv_camera_get_exposure_time(camera_, error.out());
    if (!error && us > 0) stream_.exposure = Nanoseconds{std::llround(us * 1e3)};
  }
  return {};
}

Result<void> Writer::set_link() {
  if (!arv_camera_is_gv_device(camera_)) return {};
  GlibError error;
  if (settings_.packet_bytes > 0) {
    arv_camera_gv_set_packet_size(camera_, settings_.packet_bytes, error.out());
  } else {
    arv_camera_gv_auto_packet_size(camera_, error.out());
  }
  if (error) return refused(ErrorCode::InvalidArgument, text("no packet size fits (", error.message(), ")"));
  const guint packet = arv_camera_gv_get_packet_size(camera_, error.out());
  if (error || stream_.frame_rate <= 0) return {};
  const Result<GigeSchedule> schedule = gige_schedule({.payload_bytes = stream_.payload_bytes,
                                                       .frame_rate = stream_.frame_rate,
                                                       .cameras = settings_.cameras_on_link,
                                                       .link_mbit = settings_.link_mbit,
                                                       .packet_bytes = static_cast<int>(packet)});
  if (!schedule) return refused(schedule.error().code, schedule.error().message);
  if (settings_.cameras_on_link > 1 && has("GevSCPD")) {
    arv_camera_gv_set_packet_delay(camera_, schedule->packet_delay.count, error.out());
    if (error)
      stream_.warnings.push_back(text("camera '", settings_.serial, "': it refuses a delay of ",
                                      schedule->packet_delay.count, " ns between packets (", error.message(),
                                      "); cameras that send together may overrun the switch"));
  }
  return {};
}

}  // namespace

Result<AravisStream> apply_settings(ArvCamera* camera, const AravisSettings& settings,
                                    const std::function<bool()>& stop) {
  return Writer(camera, settings, stop).run();
}

}  // namespace floatstage::capture
