#include "studio/node/capture_node.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <thread>

#include "core/file_presence.h"
#include "core/log.h"
#include "core/rig.h"
#include "core/text.h"
#include "studio/node/take_list.h"
#include "studio/node/take_rig.h"

namespace floatstage::studio {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Besides the pre-roll, so that a take can begin with an instant that all cameras have seen, and for how long
// its end is looked for: a camera pair that loses every fifth picture has such an instant among so many, but
// once in 200,000 takes.
constexpr int kInstantsTried = 12;
constexpr auto kDiskPeriod = std::chrono::milliseconds(250);
constexpr auto kVerdictPeriod = std::chrono::seconds(2);
constexpr auto kLongestEndWithTrouble = std::chrono::milliseconds(300);
constexpr auto kDead = std::chrono::seconds(30);
constexpr std::size_t kMostTakes = 200;

std::string take_name(const std::string& label) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc = {};
  gmtime_r(&now, &utc);
  char buffer[32];
  std::strftime(buffer, sizeof buffer, "%Y%m%dT%H%M%SZ-", &utc);
  return buffer + label;
}

std::uint64_t free_bytes(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const fs::space_info space = fs::space(there, error);
  return error ? 0 : space.available;
}

// Of what is captured, roughly: lossless pictures of a studio shrink by a third, films by much more.
double share_on_disk(capture::TakeCodec codec) {
  return codec == capture::TakeCodec::Raw ? 1 : codec == capture::TakeCodec::Ffv1 ? 0.65 : 0.05;
}

double seconds_kept(const CaptureConfig& config) {
  return config.preroll_seconds + kInstantsTried / config.frame_rate;
}

std::size_t frames_kept(const CaptureConfig& config) {
  return static_cast<std::size_t>(std::ceil(seconds_kept(config) * config.frame_rate * 1.1)) + 2;
}

}  // namespace

Result<std::unique_ptr<CaptureNode>> CaptureNode::open(CaptureConfig config,
                                                       const std::function<bool()>& stop) {
  Result<capture::TimeOffsetFile> times = load_times(config);
  if (!times) return forward(times);
  config.recorder.times = *std::move(times);
  std::unique_ptr<CaptureNode> node(new CaptureNode(std::move(config)));
  const CaptureConfig& c = node->config_;
  const Nanoseconds kept{std::llround(seconds_kept(c) * 1e9)};
  std::vector<std::string> serials;
  for (const CaptureConfig::Camera& camera : c.cameras) {
    if (stop && stop()) return fail(ErrorCode::Cancelled, "interrupted while the cameras were started");
    Result<std::unique_ptr<CameraLane>> lane =
        CameraLane::open(camera, static_cast<int>(node->lanes_.size()), stop);
    if (!lane) return forward(lane);
    node->lanes_.push_back(std::move(*lane));
    node->routes_.push_back(std::make_unique<Route>());
    node->routes_.back()->pre_roll.emplace(kept, frames_kept(c));
    serials.push_back(camera.serial);
    const CameraLane &first = *node->lanes_.front(), &here = *node->lanes_.back();
    if (here.info().ptp != first.info().ptp)
      return fail(
          ErrorCode::InvalidArgument,
          text("camera '", (here.info().ptp ? here : first).serial(), "' follows the network's clock and '",
               (here.info().ptp ? first : here).serial(), "' does not; set ptp=on for all cameras or none"));
  }
  Result<std::unique_ptr<SyncWatch>> watch =
      SyncWatch::make(serials, c.frame_rate, {c.recorder.limits.spread_ms, c.recorder.limits.skips},
                      capture::offsets_of(c.recorder.times, serials));
  if (!watch) return forward(watch);
  node->watch_ = std::move(*watch);
  return node;
}

CaptureNode::~CaptureNode() { (void)finish(); }

void CaptureNode::begin() {
  for (std::size_t i = 0; i < lanes_.size(); ++i)
    lanes_[i]->begin({[this, i](const Frame& frame, std::uint64_t failed) { arrived(i, frame, failed); },
                      [this, i] { restarted(i); }});
}

void CaptureNode::arrived(std::size_t camera, const Frame& frame, std::uint64_t failed) {
  watch_->push(frame.info);
  for (const Tap& tap : taps_) tap(frame);
  Route& route = *routes_[camera];
  std::lock_guard lock(route.mutex);
  if (!route.recorder)
    route.pre_roll->push(frame, failed);
  else if (Result<void> pushed = route.recorder->push(frame, failed); !pushed)
    take_failed_ = true;  // finish() says why
}

void CaptureNode::restarted(std::size_t camera) {
  Route& route = *routes_[camera];
  std::lock_guard lock(route.mutex);
  if (route.recorder) route.recorder->restarted(static_cast<int>(camera));
  route.pre_roll->clear();
}

bool CaptureNode::over() const {
  return std::all_of(lanes_.begin(), lanes_.end(), [](const auto& lane) { return lane->over(); });
}

bool CaptureNode::alive() const {
  return std::all_of(lanes_.begin(), lanes_.end(),
                     [](const auto& lane) { return Clock::now() - lane->alive() < kDead; });
}

bool CaptureNode::plays_recordings() const {
  return std::any_of(lanes_.begin(), lanes_.end(),
                     [](const auto& lane) { return lane->info().frame_count.has_value(); });
}

Timestamp CaptureNode::now() const {
  Timestamp now;
  for (const auto& lane : lanes_) now = std::max(now, lane->now().value_or(Timestamp{}));
  return now;
}

Timestamp CaptureNode::newest() const {
  Timestamp newest;
  for (const auto& lane : lanes_) newest = std::max(newest, lane->newest().value_or(Timestamp{}));
  return newest;
}

std::optional<Timestamp> CaptureNode::origin_of_take() const {
  std::vector<std::vector<Timestamp>> times;
  for (const auto& route : routes_) {
    std::lock_guard lock(route->mutex);
    times.push_back(route->pre_roll->times());
  }
  const Nanoseconds wanted{std::llround(config_.preroll_seconds * 1e9)};
  return complete_instant(times, newest() - wanted, Nanoseconds{std::llround(1e9 / config_.frame_rate)});
}

Result<fs::path> CaptureNode::new_folder(const std::string& label) const {
  if (!is_usable_serial(label))
    return fail(ErrorCode::InvalidArgument,
                text("'", label, "' is no label of a take: use letters, digits, '.', '_' and '-'"));
  const fs::path named = config_.folder / take_name(label);
  fs::path folder = named;
  for (int again = 2; is_there(folder); ++again) folder = text(named.string(), "-", again);
  return folder;
}

Result<std::string> CaptureNode::record_into(fs::path folder, const std::string& label) {
  std::lock_guard command(control_);
  if (recording())
    return fail(ErrorCode::AlreadyExists,
                text("'", take().filename().string(), "' is being recorded; stop it first"));
  const std::vector<std::string> complaints = watch_->last().complaints;
  for (const std::string& complaint : complaints) log::warning(complaint);
  if (config_.refuse_disagreement && !complaints.empty())
    return fail(ErrorCode::InvalidArgument,
                text("no take is begun while the cameras disagree: ", complaints.front()));
  capture::RecorderOptions options = config_.recorder;
  if (!label.empty()) options.take.label = label;
  if (folder.empty()) {
    Result<fs::path> named = new_folder(options.take.label);
    if (!named) return forward(named);
    folder = *named;
  }
  folder = fs::absolute(folder);  // "take" lies on a disk, too
  if (free_bytes(folder.parent_path()) < config_.keep_free_bytes)
    return fail(ErrorCode::Io,
                text("the disk of ", folder.parent_path().string(), " is full but for the ",
                     config_.keep_free_bytes / 1'000'000, " MB that are kept free; make room"));
  std::vector<LaneFacts> facts;
  for (const auto& lane : lanes_) facts.push_back({lane->serial(), lane->info().layout});
  Result<Rig> rig = rig_of_take(config_.rig, facts);
  if (!rig) return forward(rig);
  options.origin = origin_of_take();
  options.queue_frames += frames_kept(config_);
  std::error_code ignored;
  fs::create_directories(folder.parent_path(), ignored);
  std::vector<std::unique_ptr<capture::SoundSource>> sources;
  for (const std::string& uri : config_.sounds) {
    Result<std::unique_ptr<capture::SoundSource>> source = capture::open_sound(uri);
    if (!source) return forward(source);
    sources.push_back(std::move(*source));
  }
  Result<std::unique_ptr<capture::Recorder>> recorder = capture::Recorder::start(folder, *rig, options);
  if (!recorder) return forward(recorder);
  std::shared_ptr<capture::SoundRecording> sounds;
  if (!sources.empty()) {
    Result<std::unique_ptr<capture::SoundRecording>> sound =
        capture::SoundRecording::start(TakeLayout(folder), config_.sounds, std::move(sources));
    if (!sound) return forward(sound);
    sounds = std::move(*sound);
  }
  const std::shared_ptr<capture::Recorder> shared = std::move(*recorder);
  take_failed_ = false;
  hand_over(shared);
  std::lock_guard lock(mutex_);
  const double before = options.origin ? std::max(0.0, seconds(newest() - *options.origin)) : 0;
  take_ = {shared, folder, Clock::now(), before, std::nullopt, std::move(sounds)};
  last_recording_.clear();
  return folder.filename().string();
}

// The queues have room for the pre-roll, so this waits for no disk.
void CaptureNode::hand_over(const std::shared_ptr<capture::Recorder>& recorder) {
  for (const auto& route : routes_) {
    std::lock_guard lock(route->mutex);
    for (const PreRoll::Kept& kept : route->pre_roll->take())
      if (!recorder->push(kept.frame, kept.failed)) take_failed_ = true;
    route->recorder = recorder;
  }
}

void CaptureNode::wait_for_the_end(const capture::Recorder& recorder) const {
  const auto begun = Clock::now();
  const std::chrono::duration<double> longest(std::max(1.5, kInstantsTried / config_.frame_rate));
  while (!recorder.ended() && !over() && !take_failed_) {
    const bool trouble = std::any_of(lanes_.begin(), lanes_.end(),
                                     [](const auto& lane) { return !lane->newest().has_value(); });
    if (Clock::now() - begun > (trouble ? kLongestEndWithTrouble : longest)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

Result<void> CaptureNode::end_take() {
  std::shared_ptr<capture::Recorder> recorder;
  {
    std::lock_guard lock(mutex_);
    recorder = take_.recorder;
  }
  if (!recorder) return fail(ErrorCode::NotFound, "no take is being recorded");
  if (!over()) {
    recorder->end_at(newest());
    wait_for_the_end(*recorder);
  }
  for (const auto& route : routes_) {
    std::lock_guard lock(route->mutex);
    route->recorder.reset();
  }
  // Before the take is complete, and so before it is sealed.
  std::shared_ptr<capture::SoundRecording> sound;
  {
    std::lock_guard lock(mutex_);
    sound = std::move(take_.sound);
  }
  if (sound)
    if (Result<void> ended = sound->finish(); !ended) log::error(ended.error().message);
  Result<capture::RecordingQuality> finished = recorder->finish();
  std::lock_guard lock(mutex_);
  take_.quality = finished ? *finished : recorder->quality();
  take_.recorder.reset();
  if (!finished) return forward(finished);
  sealer_.add(take_.folder);
  return {};
}

Result<void> CaptureNode::stop_recording() {
  std::lock_guard command(control_);
  return end_take();
}

void CaptureNode::poll() {
  watch_->look(now());
  std::shared_ptr<capture::Recorder> recorder;
  fs::path folder;
  {
    std::lock_guard lock(mutex_);
    recorder = take_.recorder;
    folder = take_.folder;
  }
  if (!recorder) return;
  const auto now = Clock::now();
  std::string why;
  if (take_failed_) why = text("the take '", folder.filename().string(), "' could not be written further");
  if (now - looked_at_disk_ > kDiskPeriod) {
    looked_at_disk_ = now;
    if (free_bytes(folder) < config_.keep_free_bytes)
      why = text("the disk is full: '", folder.filename().string(),
                 "' was ended while there was room to end it well; make room");
  }
  if (why.empty()) {
    if (now - saved_quality_ < kVerdictPeriod) return;
    saved_quality_ = now;
    if (Result<void> saved = recorder->save_quality(); !saved) log::warning(saved.error().message);
    return;
  }
  log::error(why);
  std::lock_guard command(control_);
  if (Result<void> ended = end_take(); !ended) why += ": " + ended.error().message;
  std::lock_guard lock(mutex_);
  last_recording_ = why;
}

Result<void> CaptureNode::finish() {
  Result<void> ended;
  {
    std::lock_guard command(control_);
    if (recording()) ended = end_take();
  }
  for (const auto& lane : lanes_) lane->stop();
  return ended;
}

NodeStatus CaptureNode::status() const {
  NodeStatus status;
  status.node = config_.name;
  status.frame_rate = config_.frame_rate;
  status.preroll_seconds = config_.preroll_seconds;
  double bytes_per_second = 0;
  for (const auto& lane : lanes_) {
    status.cameras.push_back(lane->status());
    bytes_per_second += status.cameras.back().bandwidth_mbit.value_or(0) * 1e6 / 8;
  }
  const SyncWatch::Seen seen = watch_->last();
  status.spread_p50_ms = seen.spread_p50_ms;
  status.spread_max_ms = seen.spread_max_ms;
  status.complaints = seen.complaints;
  status.disk_free_bytes = free_bytes(config_.folder);
  const std::uint64_t usable =
      status.disk_free_bytes - std::min(status.disk_free_bytes, config_.keep_free_bytes);
  if (bytes_per_second > 0)
    status.disk_minutes =
        static_cast<double>(usable) / (bytes_per_second * share_on_disk(config_.recorder.take.codec) * 60);
  std::lock_guard lock(mutex_);
  status.last_recording = last_recording_;
  if (!take_.recorder) return status;
  NodeRecording recording;
  recording.take = take_.folder.filename().string();
  recording.seconds = take_.before + std::chrono::duration<double>(Clock::now() - take_.begun).count();
  const capture::RecordingQuality quality = take_.recorder->quality();
  for (const capture::RecordedCamera& camera : quality.cameras) {
    recording.frames += camera.recorded;
    recording.gaps += camera.skips;
    recording.duplicates += camera.duplicates;
  }
  recording.complaints = quality.complaints;
  if (take_.sound)
    for (const capture::SoundLevel& level : take_.sound->levels())
      recording.sounds.push_back({level.name, level.seconds, level.peak, level.ended});
  status.recording = std::move(recording);
  return status;
}

Result<std::vector<NodeTake>> CaptureNode::takes() const { return list_takes(config_.folder, kMostTakes); }

std::optional<capture::RecordingQuality> CaptureNode::quality() const {
  std::lock_guard lock(mutex_);
  if (take_.recorder) return take_.recorder->quality();
  return take_.quality;
}

bool CaptureNode::recording() const {
  std::lock_guard lock(mutex_);
  return take_.recorder != nullptr;
}

fs::path CaptureNode::take() const {
  std::lock_guard lock(mutex_);
  return take_.folder;
}

}  // namespace floatstage::studio
