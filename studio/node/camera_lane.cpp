#include "studio/node/camera_lane.h"

#include <chrono>
#include <cmath>

#include "core/log.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Nanoseconds kPatience = milliseconds(200);
constexpr auto kPauseBetweenTries = std::chrono::milliseconds(500);
constexpr auto kSilence = std::chrono::seconds(1);  // that is said to be trouble
constexpr auto kHealthPeriod = std::chrono::seconds(5);
constexpr auto kKnobPatience = std::chrono::seconds(3);
constexpr auto kControlsPeriod = std::chrono::milliseconds(500);
constexpr Nanoseconds kRateWindow = milliseconds(2000);

capture::SourceStats operator+(capture::SourceStats a, const capture::SourceStats& b) {
  return {a.delivered + b.delivered, a.lost + b.lost, a.corrupt + b.corrupt, a.starved + b.starved,
          a.failed + b.failed};
}

}  // namespace

Result<std::unique_ptr<CameraLane>> CameraLane::open(const CaptureConfig::Camera& camera, int index,
                                                     const std::function<bool()>& stop) {
  std::unique_ptr<CameraLane> lane(new CameraLane(camera, index));
  Result<std::unique_ptr<capture::FrameSource>> source = capture::open_source(camera.source);
  if (!source) return forward(source);
  lane->source_ = std::move(*source);
  lane->source_->stop_when(stop);
  Result<capture::StreamInfo> info = lane->source_->start();
  if (!info) return forward(info);
  lane->source_->stop_when([raw = lane.get()] { return raw->stopping_.load(); });
  lane->info_ = *info;
  lane->controls_ = lane->source_->controls();
  lane->alive_ = lane->last_frame_ = Clock::now();
  return lane;
}

void CameraLane::begin(Sink sink) {
  sink_ = std::move(sink);
  {
    std::lock_guard lock(mutex_);
    last_frame_ = Clock::now();
  }
  thread_ = std::thread([this] { run(); });
}

void CameraLane::stop() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) {
    thread_.join();
    source_->stop();
  }
  std::lock_guard lock(mutex_);
  over_ = true;
}

capture::SourceStats CameraLane::stats() const { return before_ + source_->stats(); }

void CameraLane::take(Frame frame) {
  frame.info.camera = index_;
  std::uint64_t failed = 0;
  {
    std::lock_guard lock(mutex_);
    ++frames_;
    const Timestamp time = frame.info.exposure_start;
    if (!first_) first_ = time;
    last_ = time;
    recent_.push_back(time);
    while (time - recent_.front() > kRateWindow) recent_.pop_front();
    if (!trouble_.empty()) log::info(text("camera '", camera_.serial, "' is back"));
    trouble_.clear();
    last_frame_ = alive_ = Clock::now();
    failed = stats().failed;
  }
  sink_.frame(frame, failed);
}

void CameraLane::nothing_came() {
  std::lock_guard lock(mutex_);
  alive_ = Clock::now();
  const double silent = std::chrono::duration<double>(alive_ - last_frame_).count();
  if (alive_ - last_frame_ < kSilence) return;
  recent_.clear();
  if (trouble_.empty()) log::warning(text("camera '", camera_.serial, "': no picture comes any more"));
  trouble_ = text("no picture for ", std::lround(silent), " s; check its trigger and its cable");
}

void CameraLane::ask_health() {
  const auto now = Clock::now();
  if (now - asked_ < kHealthPeriod) return;
  asked_ = now;
  const capture::DeviceHealth health = source_->health();
  std::lock_guard lock(mutex_);
  temperature_c_ = health.temperature_c;
}

void CameraLane::turn_knobs() {
  std::unique_lock lock(mutex_);
  const bool asked = controls_asked_ && Clock::now() - controls_read_ >= kControlsPeriod;
  if (knobs_.empty() && !asked) return;
  while (!knobs_.empty()) {
    const std::shared_ptr<Knob> knob = knobs_.front();
    knobs_.pop_front();
    lock.unlock();
    const Result<void> done = source_->set_control(knob->name, knob->value);
    lock.lock();
    if (done) turned_[knob->name] = knob->value;
    knob->done = done;
  }
  lock.unlock();
  std::vector<capture::CameraControl> controls = source_->controls();
  lock.lock();
  controls_ = std::move(controls);
  controls_read_ = Clock::now();
  controls_asked_ = false;
  wake_.notify_all();
}

std::vector<capture::CameraControl> CameraLane::controls() const {
  std::lock_guard lock(mutex_);
  controls_asked_ = true;
  return controls_;
}

Result<void> CameraLane::set_control(const std::string& name, double value) {
  const auto knob = std::make_shared<Knob>(Knob{name, value, std::nullopt});
  std::unique_lock lock(mutex_);
  knobs_.push_back(knob);
  wake_.wait_for(lock, kKnobPatience, [&] { return knob->done || over_ || stopping_; });
  if (knob->done) return *knob->done;
  std::erase(knobs_, knob);
  return fail(ErrorCode::Timeout, text("camera '", camera_.serial, "' did not take ", name, " = ", value,
                                       " within 3 s", trouble_.empty() ? "" : "; ", trouble_));
}

bool CameraLane::reconnect() {
  {
    std::lock_guard lock(mutex_);
    before_ = stats();
    recent_.clear();
    source_->stop();
  }
  std::unique_lock lock(mutex_);
  for (bool first = true; !stopping_; first = false) {
    if (!first) wake_.wait_for(lock, kPauseBetweenTries, [&] { return stopping_.load(); });
    if (stopping_) return false;
    alive_ = Clock::now();
    lock.unlock();
    const Result<capture::StreamInfo> info = source_->start();
    const bool same = info && info->layout == info_.layout;
    if (same)  // turned_ is written by this thread alone
      for (const auto& [name, value] : turned_) (void)source_->set_control(name, value);
    if (info && !same) source_->stop();
    lock.lock();
    if (!same) continue;
    ++reconnects_;
    lock.unlock();
    sink_.restarted();
    return true;
  }
  return false;
}

void CameraLane::run() {
  while (!stopping_) {
    turn_knobs();
    Result<Frame> frame = source_->next(kPatience);
    if (frame) {
      take(std::move(*frame));
      ask_health();
      continue;
    }
    if (frame.error().code == ErrorCode::Timeout) {
      nothing_came();
      continue;
    }
    if (frame.error().code == ErrorCode::EndOfStream || frame.error().code == ErrorCode::Cancelled) break;
    log::warning(frame.error().message);
    {
      std::lock_guard lock(mutex_);
      trouble_ = frame.error().message;
    }
    if (!reconnect()) break;
  }
  std::lock_guard lock(mutex_);
  over_ = true;
  wake_.notify_all();
}

bool CameraLane::over() const {
  std::lock_guard lock(mutex_);
  return over_;
}

std::optional<Timestamp> CameraLane::newest() const {
  std::lock_guard lock(mutex_);
  return recent_.empty() ? std::nullopt : std::optional(recent_.back());
}

std::optional<Timestamp> CameraLane::now() const {
  std::lock_guard lock(mutex_);
  if (!last_) return std::nullopt;
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - last_frame_);
  return *last_ + Nanoseconds{since.count()};
}

std::chrono::steady_clock::time_point CameraLane::alive() const {
  std::lock_guard lock(mutex_);
  return over_ ? Clock::now() : alive_;
}

double CameraLane::mean_frame_rate() const {
  std::lock_guard lock(mutex_);
  if (frames_ < 2 || *last_ <= *first_) return 0;
  return static_cast<double>(frames_ - 1) / seconds(*last_ - *first_);
}

NodeCamera CameraLane::status() const {
  std::lock_guard lock(mutex_);
  const capture::SourceStats sum = stats();
  NodeCamera camera;
  camera.serial = camera_.serial;
  camera.delivered = sum.delivered;
  camera.lost = sum.lost;
  camera.corrupt = sum.corrupt;
  camera.failed = sum.failed;
  camera.starved = sum.starved;
  camera.reconnects = reconnects_;
  camera.temperature_c = temperature_c_;
  camera.trouble = trouble_;
  camera.width = info_.layout.width;
  camera.height = info_.layout.height;
  if (recent_.size() > 1) {
    camera.frame_rate = static_cast<double>(recent_.size() - 1) / seconds(recent_.back() - recent_.front());
    camera.bandwidth_mbit = camera.frame_rate * static_cast<double>(info_.layout.size_bytes) * 8e-6;
  }
  return camera;
}

}  // namespace floatstage::studio
