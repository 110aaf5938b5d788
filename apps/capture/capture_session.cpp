#include "apps/capture/capture_session.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <thread>

#include "core/log.h"
#include "core/rig_io.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

SourceStats operator+(SourceStats a, const SourceStats& b) {
  return {a.delivered + b.delivered, a.lost + b.lost, a.corrupt + b.corrupt, a.starved + b.starved,
          a.failed + b.failed};
}

// One camera and its thread.
struct Lane {
  CaptureConfig::Camera camera;
  int index = 0;
  std::unique_ptr<FrameSource> source;
  StreamInfo info;
  std::thread thread;

  std::mutex mutex;    // over what follows
  SourceStats before;  // of the connections that ended
  std::uint64_t reconnects = 0, frames = 0;
  std::optional<Timestamp> first, last;
  std::string trouble;
  bool over = false;
};

class Session {
 public:
  Session(const CaptureConfig& config, const CaptureOptions& options) : config_(config), options_(options) {}
  ~Session() { end(); }

  Result<void> open();
  Result<void> begin_recording();
  void begin();
  void wait(const std::function<bool()>& stop, const std::function<void(const CaptureReport&)>& progress);
  void end();
  CaptureReport report() const;
  Result<CaptureReport> finish();

 private:
  void run(Lane& lane);
  bool reconnect(Lane& lane);
  void take(Lane& lane, Frame frame);
  bool all_over() const;
  Result<Rig> rig() const;

  const CaptureConfig& config_;
  const CaptureOptions& options_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::unique_ptr<Recorder> recorder_;
  fs::path take_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  std::condition_variable wake_;
};

Result<void> Session::open() {
  for (const CaptureConfig::Camera& camera : config_.cameras) {
    auto lane = std::make_unique<Lane>();
    lane->camera = camera;
    lane->index = static_cast<int>(lanes_.size());
    Result<std::unique_ptr<FrameSource>> source = open_source(camera.source);
    if (!source) return forward(source);
    lane->source = std::move(*source);
    Result<StreamInfo> info = lane->source->start();
    if (!info) return forward(info);
    lane->info = *info;
    lanes_.push_back(std::move(lane));
  }
  return {};
}

// Where nobody has calibrated yet, the cameras are put on a ring: a take must say where they stood.
Result<Rig> Session::rig() const {
  Rig known;
  if (!config_.rig.empty()) {
    Result<Rig> loaded = load_rig(config_.rig);
    if (!loaded) return loaded;
    known = std::move(*loaded);
  } else {
    log::warning(
        "no rig is given: the take is recorded with made-up camera positions; calibrate before processing "
        "it");
  }
  SyntheticRigOptions ring;
  ring.cameras = static_cast<int>(lanes_.size());
  Rig rig = synthetic_rig(ring);
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    RigCamera& camera = rig.cameras[i];
    const std::string& serial = lanes_[i]->camera.serial;
    const ImageLayout& layout = lanes_[i]->info.layout;
    const auto calibrated = std::find_if(known.cameras.begin(), known.cameras.end(),
                                         [&](const RigCamera& c) { return c.serial == serial; });
    if (calibrated != known.cameras.end()) {
      camera = *calibrated;
    } else if (!config_.rig.empty()) {
      return fail(ErrorCode::NotFound, text(config_.rig.string(), ": camera '", serial,
                                            "' is not in it; calibrate again or correct the serial"));
    } else {
      camera.serial = serial;
      camera.model = CameraModel{layout.width,
                                 layout.height,
                                 1.0 * layout.width,
                                 1.0 * layout.width,
                                 0.5 * layout.width,
                                 0.5 * layout.height,
                                 0,
                                 {}};
    }
    if (camera.model.width != layout.width || camera.model.height != layout.height)
      return fail(
          ErrorCode::InvalidArgument,
          text("camera '", serial, "': it streams ", layout.width, "x", layout.height,
               " and was calibrated at ", camera.model.width, "x", camera.model.height, "; set that size"));
  }
  return rig;
}

std::string take_name(const std::string& label) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc = {};
  gmtime_r(&now, &utc);
  char buffer[32];
  std::strftime(buffer, sizeof buffer, "%Y%m%dT%H%M%SZ-", &utc);
  return buffer + label;
}

Result<void> Session::begin_recording() {
  if (!options_.record) return {};
  Result<Rig> cameras = rig();
  if (!cameras) return forward(cameras);
  take_ = options_.take.empty() ? config_.folder / take_name(config_.recorder.take.label) : options_.take;
  std::error_code ignored;
  fs::create_directories(take_.parent_path(), ignored);
  Result<std::unique_ptr<Recorder>> recorder = Recorder::start(take_, *cameras, config_.recorder);
  if (!recorder) return forward(recorder);
  recorder_ = std::move(*recorder);
  return {};
}

void Session::begin() {
  for (const auto& lane : lanes_) lane->thread = std::thread([this, &lane] { run(*lane); });
}

void Session::take(Lane& lane, Frame frame) {
  frame.info.camera = lane.index;
  {
    std::lock_guard lock(lane.mutex);
    ++lane.frames;
    if (!lane.first) lane.first = frame.info.exposure_start;
    lane.last = frame.info.exposure_start;
    lane.trouble.clear();
  }
  if (!recorder_) return;
  if (Result<void> pushed = recorder_->push(frame); !pushed) stopping_ = true;  // finish() says why
}

bool Session::reconnect(Lane& lane) {
  constexpr auto kPause = std::chrono::milliseconds(500);
  const SourceStats ended = lane.source->stats();
  lane.source->stop();
  while (!stopping_) {
    const Result<StreamInfo> info = lane.source->start();
    if (info && info->layout == lane.info.layout) {
      if (recorder_) recorder_->restarted(lane.index);
      std::lock_guard lock(lane.mutex);
      lane.before = lane.before + ended;
      ++lane.reconnects;
      return true;
    }
    if (info) lane.source->stop();
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, kPause, [&] { return stopping_.load(); });
  }
  return false;
}

void Session::run(Lane& lane) {
  constexpr Nanoseconds kPatience = milliseconds(200);
  while (!stopping_) {
    Result<Frame> frame = lane.source->next(kPatience);
    if (frame) {
      take(lane, std::move(*frame));
      continue;
    }
    if (frame.error().code == ErrorCode::Timeout) continue;
    if (frame.error().code == ErrorCode::EndOfStream) break;
    log::warning(frame.error().message);
    {
      std::lock_guard lock(lane.mutex);
      lane.trouble = frame.error().message;
    }
    if (!reconnect(lane)) return;
    log::info(text("camera '", lane.camera.serial, "' is back"));
  }
  std::lock_guard lock(lane.mutex);
  lane.over = true;
}

bool Session::all_over() const {
  return std::all_of(lanes_.begin(), lanes_.end(), [](const auto& lane) {
    std::lock_guard lock(lane->mutex);
    return lane->over;
  });
}

void Session::wait(const std::function<bool()>& stop,
                   const std::function<void(const CaptureReport&)>& progress) {
  const auto begun = Clock::now();
  auto told = begun;
  while (!stopping_ && !all_over() && !stop()) {
    const auto now = Clock::now();
    if (options_.seconds > 0 && std::chrono::duration<double>(now - begun).count() >= options_.seconds) break;
    if (now - told >= std::chrono::seconds(1)) {
      told = now;
      progress(report());
    }
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, std::chrono::milliseconds(50));
  }
}

void Session::end() {
  stopping_ = true;
  wake_.notify_all();
  for (const auto& lane : lanes_) {
    if (lane->thread.joinable()) lane->thread.join();
    std::lock_guard lock(lane->mutex);
    lane->over = true;
  }
}

CaptureReport Session::report() const {
  CaptureReport report;
  report.take = take_;
  for (const auto& lane : lanes_) {
    std::lock_guard lock(lane->mutex);
    CapturedCamera camera;
    camera.serial = lane->camera.serial;
    camera.stats = lane->before + lane->source->stats();
    camera.reconnects = lane->reconnects;
    camera.trouble = lane->trouble;
    if (lane->frames > 1)
      camera.frame_rate = static_cast<double>(lane->frames - 1) / seconds(*lane->last - *lane->first);
    report.cameras.push_back(std::move(camera));
  }
  if (recorder_) report.recording = recorder_->quality();
  return report;
}

Result<CaptureReport> Session::finish() {
  end();
  CaptureReport done = report();
  for (const auto& lane : lanes_) lane->source->stop();
  if (!recorder_) return done;
  Result<RecordingQuality> recorded = recorder_->finish();
  if (!recorded) return forward(recorded);
  done.recording = std::move(*recorded);
  return done;
}

}  // namespace

Result<CaptureReport> run_capture(const CaptureConfig& config, const CaptureOptions& options,
                                  const std::function<bool()>& stop,
                                  const std::function<void(const CaptureReport&)>& progress) {
  Session session(config, options);
  if (Result<void> opened = session.open(); !opened) return forward(opened);
  if (Result<void> recording = session.begin_recording(); !recording) return forward(recording);
  session.begin();
  session.wait(stop, progress);
  return session.finish();
}

}  // namespace floatstage
