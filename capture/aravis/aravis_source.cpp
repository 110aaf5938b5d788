#include "capture/aravis/aravis_source.h"

#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <fstream>

#include "capture/aravis/aravis_settings.h"
#include "capture/aravis/block_id.h"
#include "capture/aravis/gvcp_knock.h"
#include "capture/clock_map.h"
#include "capture/source_meter.h"
#include "capture/source_uri.h"
#include "capture/studio_clock.h"
#include "core/log.h"

namespace floatstage::capture {
namespace {

constexpr std::size_t kPicturesInSocket = 16;  // half a second at 30: longer than busy machines stand still
constexpr std::size_t kSmallestSocketBuffer = 1 << 20;
constexpr Nanoseconds kPatience = milliseconds(2000);  // for a camera at an address to say that it is there

// When the picture's first packet came. Aravis stamps it with the wall clock, which is read against the
// studio's now: a wall clock that is set moves only the pictures under way.
Timestamp arrival_of(ArvBuffer* buffer) {
  const Nanoseconds since{g_get_real_time() * 1000 -
                          static_cast<std::int64_t>(arv_buffer_get_system_timestamp(buffer))};
  return studio_now() - since;
}

struct Receiver {
  GObjectPtr<ArvStream> stream;

  // Aravis writes a picture's number when its leader comes. A buffer that never saw one would keep the number
  // of the picture before: 0 is no picture's.
  void give(ArvBuffer* buffer) const {
    arv_buffer_set_frame_id(buffer, 0);
    arv_stream_push_buffer(stream.get(), buffer);
  }
};

// Lends the buffer's bytes; the last frame that holds them gives the buffer back, if its stream still runs.
std::shared_ptr<const std::byte[]> lend(ArvBuffer* buffer, const std::shared_ptr<Receiver>& receiver) {
  const auto* bytes = static_cast<const std::byte*>(arv_buffer_get_data(buffer, nullptr));
  const auto give_back = [buffer, from = std::weak_ptr<Receiver>(receiver)](const std::byte*) {
    if (const std::shared_ptr<Receiver> alive = from.lock()) {
      alive->give(buffer);
    } else {
      g_object_unref(buffer);
    }
  };
  return {bytes, give_back};
}

const char* words_for(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return "whole";
    case ARV_BUFFER_STATUS_CLEARED:
      return "cleared";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "incomplete when its time was up";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "missing packets";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "out of order";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "larger than announced";
    case ARV_BUFFER_STATUS_FILLING:
      return "still arriving";
    case ARV_BUFFER_STATUS_ABORTED:
      return "aborted";
    case ARV_BUFFER_STATUS_UNKNOWN:
      break;
  }
  return "in an unknown state";
}

std::size_t largest_socket_buffer() {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  std::size_t bytes = 0;
  return file >> bytes ? bytes : SIZE_MAX;
}

class AravisSource final : public FrameSource {
 public:
  AravisSource(AravisSettings settings, std::uint64_t frames)
      : settings_(std::move(settings)), frames_(frames) {}
  ~AravisSource() override { stop(); }

  Result<StreamInfo> start() override;
  Result<Frame> next(Nanoseconds timeout) override;
  void stop() override;
  SourceStats stats() const override { return meter_.read(); }
  DeviceHealth health() override;
  std::vector<CameraControl> controls() override {
    return camera_ ? light_controls(camera_.get()) : std::vector<CameraControl>();
  }
  Result<void> set_control(const std::string& name, double value) override;

 private:
  auto failed(ErrorCode code, const std::string& what) const {
    return fail(code, text("camera '", settings_.serial, "': ", what));
  }
  Result<void> find_camera();
  Result<void> open_stream();
  Result<std::optional<Frame>> take(ArvBuffer* buffer);
  Frame frame_of(ArvBuffer* buffer, std::uint64_t sequence);
  void count_underruns();
  static void control_lost(ArvDevice*, AravisSource* self) { self->lost_control_ = true; }

  const AravisSettings settings_;
  const std::uint64_t frames_;
  GObjectPtr<ArvCamera> camera_;
  gulong signal_ = 0;
  std::shared_ptr<Receiver> receiver_;  // while started
  AravisStream stream_;
  ClockMap clock_;
  BlockIdUnwrapper ids_;
  std::uint64_t expected_ = 0;  // the next picture's number
  std::uint64_t underruns_ = 0;
  std::atomic<bool> lost_control_{false};
  SourceMeter meter_;
};

Result<void> AravisSource::find_camera() {
  GlibError error;
  std::string name = settings_.address;
  if (name.empty()) {
    arv_update_device_list();
    std::string seen;
    for (guint i = 0; i < arv_get_n_devices(); ++i) {
      const char* serial = arv_get_device_serial_nbr(i);
      if (serial && settings_.serial == serial) name = arv_get_device_id(i);
      seen += text(seen.empty() ? "" : ", ", serial ? serial : "?");
    }
    if (name.empty())
      return failed(ErrorCode::NotFound,
                    text("no camera of this serial answers (answering: ", seen.empty() ? "none" : seen,
                         "); check its cable and power, or give address=<IP>"));
  }
  const Knock knocked = knock(settings_.address, kPatience, [this] { return stopped(); });
  if (knocked == Knock::Stopped) return failed(ErrorCode::Cancelled, "interrupted before it answered");
  if (knocked == Knock::Silence)
    return failed(ErrorCode::NotFound, text("nothing answers at ", name,
                                            "; check its cable, its power and the "
                                            "address"));
  camera_.reset(arv_camera_new(name.c_str(), error.out()));
  if (!camera_)
    return failed(ErrorCode::NotFound, text("nothing answers at ", name, " (", error.message(),
                                            "); check its cable, "
                                            "its power and that no other program controls it"));
  const char* serial = arv_camera_get_device_serial_number(camera_.get(), nullptr);
  if (!serial || settings_.serial != serial)
    return failed(ErrorCode::NotFound, text("at ", name, " is camera '", serial ? serial : "?",
                                            "' instead; correct the address or the serial"));
  return {};
}

Result<void> AravisSource::open_stream() {
  GlibError error;
  const bool gige = arv_camera_is_gv_device(camera_.get());
  if (gige && !settings_.packet_socket)
    arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  GObjectPtr<ArvStream> stream(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error.out()));
  if (!stream)
    return failed(ErrorCode::Disconnected,
                  text("it opens no stream (", error.message(), "); is another program receiving from it?"));
  if (gige) {
    // Room for what comes while the reader does not run; never less than the system's own default.
    const std::size_t most = largest_socket_buffer();
    const std::size_t wanted = std::max(kPicturesInSocket * stream_.payload_bytes, kSmallestSocketBuffer);
    g_object_set(stream.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                 static_cast<gint>(std::min({wanted, most, std::size_t{INT_MAX}})), "packet-resend",
                 settings_.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                 nullptr);
    if (most < stream_.payload_bytes)
      stream_.warnings.push_back(
          text("camera '", settings_.serial, "': one picture has ", stream_.payload_bytes,
               " bytes and net.core.rmem_max allows a socket ", most,
               "; pictures will be lost until it is raised: sysctl -w net.core.rmem_max=",
               2 * stream_.payload_bytes));
  }
  for (int i = 0; i < settings_.buffers; ++i)
    arv_stream_push_buffer(stream.get(), arv_buffer_new_allocate(stream_.payload_bytes));
  receiver_ = std::make_shared<Receiver>(Receiver{std::move(stream)});
  return {};
}

Result<StreamInfo> AravisSource::start() {
  if (receiver_) return failed(ErrorCode::InvalidArgument, "it is started already; stop it first");
  stop();  // what an attempt that failed left open
  lost_control_ = false;
  if (Result<void> found = find_camera(); !found) return forward(found);
  Result<AravisStream> applied = apply_settings(camera_.get(), settings_, [this] { return stopped(); });
  if (!applied) return forward(applied);
  stream_ = std::move(*applied);
  if (Result<void> opened = open_stream(); !opened) return forward(opened);
  for (const std::string& warning : stream_.warnings) log::warning(warning);
  signal_ =
      g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(&control_lost), this);
  clock_ = ClockMap();
  ids_ = BlockIdUnwrapper(static_cast<std::uint64_t>(settings_.buffers));
  expected_ = underruns_ = 0;
  meter_.reset();
  GlibError error;
  arv_camera_start_acquisition(camera_.get(), error.out());
  if (error) {
    stop();
    return failed(ErrorCode::Disconnected, text("it does not start (", error.message(), ")"));
  }
  StreamInfo info;
  info.name = settings_.serial;
  info.layout = stream_.layout;
  info.frame_rate = stream_.frame_rate;
  info.ptp = stream_.ptp_locked;
  if (frames_ != UINT64_MAX) info.frame_count = static_cast<std::int64_t>(frames_);
  return info;
}

void AravisSource::stop() {
  if (camera_ && receiver_) arv_camera_stop_acquisition(camera_.get(), nullptr);
  if (signal_) g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), signal_);
  signal_ = 0;
  receiver_.reset();
  camera_.reset();
}

void AravisSource::count_underruns() {
  guint64 completed = 0, failures = 0, underruns = 0;
  arv_stream_get_statistics(receiver_->stream.get(), &completed, &failures, &underruns);
  for (; underruns_ < underruns; ++underruns_) meter_.count_starved();
}

DeviceHealth AravisSource::health() {
  DeviceHealth health;
  if (!camera_ || !arv_camera_is_feature_available(camera_.get(), "DeviceTemperature", nullptr))
    return health;
  GlibError error;
  const double celsius = arv_camera_get_float(camera_.get(), "DeviceTemperature", error.out());
  if (!error) health.temperature_c = celsius;
  return health;
}

Result<void> AravisSource::set_control(const std::string& name, double value) {
  if (!camera_) return failed(ErrorCode::InvalidArgument, "it is not started; start it first");
  if (Result<void> set = set_light_control(camera_.get(), settings_.serial, name, value); !set) return set;
  GlibError error;
  const double us = name == kExposureControl ? arv_camera_get_exposure_time(camera_.get(), error.out()) : 0;
  if (!error && us > 0) stream_.exposure = Nanoseconds{std::llround(us * 1e3)};
  return {};
}

Frame AravisSource::frame_of(ArvBuffer* buffer, std::uint64_t sequence) {
  Frame frame;
  frame.info.sequence = sequence;
  frame.info.exposure = stream_.exposure;
  frame.layout = stream_.layout;
  const Timestamp arrival = arrival_of(buffer);
  const Nanoseconds device{static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer))};
  frame.info.exposure_start = arrival;
  if (device.count > 0) {  // 0 is a camera without a clock
    frame.info.device_time = device;
    frame.info.exposure_start =
        stream_.ptp_locked ? Timestamp{device.count} : clock_.observe(device, arrival);
  }
  frame.pixels = lend(buffer, receiver_);
  return frame;
}

// The buffer's frame, or nothing when it did not arrive whole and has gone back to the stream.
Result<std::optional<Frame>> AravisSource::take(ArvBuffer* buffer) {
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  const std::uint64_t id = arv_buffer_get_frame_id(buffer);
  std::size_t bytes = 0;
  arv_buffer_get_data(buffer, &bytes);
  const bool whole = status == ARV_BUFFER_STATUS_SUCCESS && bytes >= stream_.layout.size_bytes &&
                     arv_buffer_get_image_width(buffer) == stream_.layout.width &&
                     arv_buffer_get_image_height(buffer) == stream_.layout.height;
  if (!whole && expected_ < frames_) {
    meter_.count_failed();
    log::debug(text("camera '", settings_.serial, "': picture ", id, " is lost: ", words_for(status)));
  }
  const std::optional<std::uint64_t> sequence = id == 0 ? std::nullopt : ids_.unwrap(id);
  if (!sequence) {
    receiver_->give(buffer);
    // Without a number, or overtaken: it is counted as lost when a later picture comes, or was.
    if (id == 0 || ids_.why_not(id) == BlockIdUnwrapper::Late::Overtaken) return std::optional<Frame>();
    return failed(ErrorCode::Disconnected,
                  text("its picture numbers began again at ", id, ": it was restarted; stop and start it"));
  }
  const std::uint64_t skipped = std::min(*sequence, frames_) - std::min(expected_, frames_);
  expected_ = *sequence + 1;
  meter_.count_lost(skipped);
  if (*sequence >= frames_ || !whole) {
    if (*sequence < frames_) meter_.count_lost(1);
    receiver_->give(buffer);
    return std::optional<Frame>();
  }
  Frame frame = frame_of(buffer, *sequence);
  meter_.count_delivered(frame);
  return std::optional<Frame>(std::move(frame));
}

Result<Frame> AravisSource::next(Nanoseconds timeout) {
  if (!receiver_) return failed(ErrorCode::InvalidArgument, "it is not started; start it first");
  if (settings_.trigger == GigeTrigger::Software && expected_ < frames_) {
    GlibError error;
    arv_camera_execute_command(camera_.get(), "TriggerSoftware", error.out());
    if (error)
      return failed(ErrorCode::Disconnected, text("it does not take a trigger (", error.message(), ")"));
  }
  // Short waits, so that a control channel that is lost meanwhile is noticed.
  constexpr std::int64_t kSlice = 50'000'000;
  const Timestamp end = studio_now() + timeout;
  for (;;) {
    if (expected_ >= frames_)
      return failed(ErrorCode::EndOfStream, text("its ", frames_, " pictures are over"));
    const std::int64_t left = std::max<std::int64_t>(0, (end - studio_now()).count);
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(receiver_->stream.get(),
                                                      static_cast<guint64>(std::min(left, kSlice)) / 1000);
    count_underruns();
    if (buffer) {
      Result<std::optional<Frame>> taken = take(buffer);
      if (!taken) return forward(taken);
      if (*taken) return std::move(**taken);
      continue;
    }
    if (lost_control_)
      return failed(ErrorCode::Disconnected, "it no longer answers; check its cable and power");
    if (left == 0) return failed(ErrorCode::Timeout, text("no picture within ", seconds(timeout), " s"));
  }
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_aravis(const std::string& address, const std::string& uri) {
  DeviceUri given(address, uri);
  UriOptions& options = given.options;
  AravisSettings s;
  s.serial = given.device;
  given.read_pictures(s, 10'000);
  s.address = options.word("address", "");
  s.x = options.integer("x", 0, 0, 65535);
  s.y = options.integer("y", 0, 0, 65535);
  if (const double us = options.number("exposure-us", 0, 0.001, 1e9); us > 0) s.exposure_us = us;
  if (const double gain = options.number("gain", -1, 0, 1e6); gain >= 0) s.gain = gain;
  s.packet_bytes = options.integer("packet", 0, 0, 65535);
  s.cameras_on_link = options.integer("cameras", 1, 1, 1000);
  s.link_mbit = options.number("link-mbit", s.link_mbit, 1, 1e6);
  const std::string trigger = options.word("trigger", "free-run");
  if (trigger == "software")
    s.trigger = GigeTrigger::Software;
  else if (trigger != "free-run")
    s.trigger = GigeTrigger::Line, s.line = trigger;
  s.ptp = options.flag("ptp", s.ptp);
  s.ptp_wait_s = options.number("ptp-wait", s.ptp_wait_s, 0, 600);
  s.resend = options.flag("resend", s.resend);
  const std::string packet_socket = options.word("packet-socket", "auto");
  // On loopback the packet socket delivers nothing.
  s.packet_socket = packet_socket == "on" || (packet_socket == "auto" && !s.address.starts_with("127."));
  if (packet_socket != "auto" && packet_socket != "on" && packet_socket != "off")
    options.note(text("packet-socket=", packet_socket, " is not auto, on or off"));
  const std::uint64_t frames = given.frames();
  if (Result<void> ok = options.finish(kAravisUsage); !ok) return forward(ok);
  return {std::make_unique<AravisSource>(std::move(s), frames)};
}

}  // namespace floatstage::capture
