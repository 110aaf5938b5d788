#include "studio/live/take_player.h"

#include <algorithm>
#include <cmath>
#include <future>

#include "capture/time_offsets.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/text.h"
#include "studio/messages/clock.h"
#include "studio/node/key_samples.h"

namespace floatstage::studio {
namespace {

constexpr Nanoseconds kSettling = milliseconds(50);  // between begin() and the first frame

std::uint64_t bytes_of(const TakeManifest& manifest, int rows) {
  std::uint64_t bytes = 0;
  for (const TakeManifest::Camera& c : manifest.cameras)
    bytes += packed_layout(c.format, c.width, c.height).size_bytes * static_cast<std::uint64_t>(rows);
  return bytes;
}

}  // namespace

Result<std::unique_ptr<TakePlayer>> TakePlayer::open(const std::filesystem::path& folder,
                                                     const TakePlayerOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder);
  if (!take) return forward(take);
  std::unique_ptr<TakePlayer> player(new TakePlayer(std::move(*take), options));
  const capture::TakeReader& reader = *player->take_;
  const double recorded = reader.manifest().frame_rate;
  if (options.rate < 0 || (options.rate == 0 && recorded <= 0))
    return fail(ErrorCode::InvalidArgument,
                text(folder.string(), " has no frame rate of its own; give one in instants a second"));
  if (reader.frame_count() == 0)
    return fail(ErrorCode::InvalidArgument, text(folder.string(), " has no frames to play"));
  player->rate_ = options.rate > 0 ? options.rate : recorded;
  player->speed_ = recorded > 0 ? player->rate_ / recorded : 1;
  const Result<capture::TimeOffsetFile> offsets = capture::load_time_offsets(reader.layout());
  if (!offsets) return forward(offsets);
  for (const Nanoseconds offset : capture::offsets_of(*offsets, reader.rig()))
    player->offsets_.push_back({std::llround(static_cast<double>(offset.count) / player->speed_)});
  for (int k = 0; k < reader.frame_count(); ++k) {
    std::optional<Timestamp> first;
    for (std::size_t c = 0; c < reader.rig().cameras.size(); ++c) {
      const std::vector<FrameRow>& rows = reader.rows(static_cast<int>(c));
      if (static_cast<std::size_t>(k) >= rows.size()) continue;
      const Timestamp time = rows[static_cast<std::size_t>(k)].info.exposure_start;
      first = first ? std::min(*first, time) : time;
    }
    player->times_.push_back(first.value_or(Timestamp{}));
  }
  if (Result<void> ok = player->load_samples(); !ok) return forward(ok);
  if (bytes_of(reader.manifest(), reader.frame_count()) <= options.preload_bytes)
    if (Result<void> ok = player->preload(); !ok) return forward(ok);
  return player;
}

Result<void> TakePlayer::load_samples() {
  constexpr int kPhotographs = 3;  // spread over the take, where there is no clean plate
  for (std::size_t c = 0; c < rig().cameras.size(); ++c) {
    const std::string& serial = rig().cameras[c].serial;
    Result<matting::KeySamples> samples = empty_stage_of(take_->layout().plate(serial).parent_path(), serial);
    if (!samples) return forward(samples);
    const int wanted = samples->empty_stage ? 0 : std::min(kPhotographs, rows());
    for (int i = 0; i < wanted; ++i) {
      const Result<Frame> frame =
          take_->frame(static_cast<int>(c), static_cast<int>(static_cast<long>(rows()) * i / wanted));
      if (!frame) return forward(frame);
      if (frame->empty()) continue;
      Result<Image> picture = to_rgb(*frame);
      if (!picture) return forward(picture);
      samples->pictures.push_back(std::move(*picture));
    }
    samples_.push_back(std::move(*samples));
  }
  return {};
}

Result<void> TakePlayer::preload() {
  const std::size_t cameras = rig().cameras.size();
  preloaded_.assign(static_cast<std::size_t>(rows()), std::vector<Frame>(cameras));
  std::vector<std::optional<Error>> failures(cameras);
  parallel_for(cameras, 0, [&](std::size_t c) {
    for (int k = 0; k < rows() && !failures[c]; ++k) {
      if (options_.stop && options_.stop()) {
        failures[c] = Error{ErrorCode::Cancelled, "interrupted while the take was decoded"};
        break;
      }
      Result<Frame> frame = take_->frame(static_cast<int>(c), k);
      if (frame)
        preloaded_[static_cast<std::size_t>(k)][c] = std::move(*frame);
      else
        failures[c] = frame.error();
    }
  });
  for (const std::optional<Error>& failure : failures)
    if (failure) return Unexpected{*failure};
  return {};
}

std::vector<Frame> TakePlayer::row(int index) {
  if (!preloaded_.empty()) return preloaded_[static_cast<std::size_t>(index)];
  std::vector<Frame> frames(rig().cameras.size());
  for (std::size_t c = 0; c < frames.size(); ++c) {
    Result<Frame> frame = take_->frame(static_cast<int>(c), index);
    if (frame)
      frames[c] = std::move(*frame);
    else
      log::warning(frame.error().message);
  }
  return frames;
}

std::string TakePlayer::description() const {
  return text(take_->layout().folder().string(), ": ", rows(), " instants of ", rig().cameras.size(),
              " cameras at ", rate_, " a second", options_.loop ? ", again and again, " : ", ",
              preloaded_.empty()
                  ? "decoded while it plays: decoding is part of the load and latency counts from its end"
                  : "decoded beforehand: latency counts from each frame's time of exposure");
}

void TakePlayer::begin(Tap tap) {
  thread_ = std::thread([this, tap = std::move(tap)] { run(tap); });
}

bool TakePlayer::sleep_until(Timestamp time) {
  std::unique_lock lock(mutex_);
  wake_.wait_until(lock, std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time.ns)),
                   [&] { return stopping_; });
  return !stopping_;
}

void TakePlayer::run(const Tap& tap) {
  const Timestamp start = now() + kSettling, first = times_.front();
  const auto scaled = [&](Nanoseconds d) {
    return Nanoseconds{std::llround(static_cast<double>(d.count) / speed_)};
  };
  const Nanoseconds once = scaled(times_.back() - first) + Nanoseconds{std::llround(1e9 / rate_)};
  std::future<std::vector<Frame>> next;  // decoded one instant ahead
  const auto fetch = [&](int k) { return std::async(std::launch::async, [this, k] { return row(k); }); };
  for (std::int64_t round = 0; round == 0 || options_.loop; ++round) {
    for (int k = 0; k < rows(); ++k) {
      const Timestamp begun = start + once * round;
      const Timestamp due = begun + scaled(times_[static_cast<std::size_t>(k)] - first);
      std::vector<Frame> frames;
      if (preloaded_.empty()) {
        frames = next.valid() ? next.get() : row(k);
        next = fetch((k + 1) % rows());
      } else {
        frames = row(k);
      }
      if (!sleep_until(due)) return;
      for (std::size_t c = 0; c < frames.size(); ++c) {
        Frame& frame = frames[c];
        if (frame.empty()) continue;
        frame.info.camera = static_cast<int>(c);
        frame.info.exposure_start = begun + scaled(frame.info.exposure_start - first);
        frame.info.sequence += static_cast<std::uint64_t>(round) * static_cast<std::uint64_t>(rows());
        tap(frame, preloaded_.empty() ? now() : due);
      }
    }
  }
  const std::lock_guard lock(mutex_);
  over_ = true;
}

bool TakePlayer::over() const {
  const std::lock_guard lock(mutex_);
  return over_;
}

void TakePlayer::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

}  // namespace floatstage::studio
