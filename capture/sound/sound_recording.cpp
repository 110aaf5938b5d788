#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <thread>

#include "capture/sound/sound_source.h"
#include "capture/sound/sound_writer.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct Lane {
  SoundTrack track;
  std::unique_ptr<SoundSource> source;
  std::unique_ptr<SoundWriter> writer;
  Result<void> result = {};
  std::atomic<std::int64_t> samples = 0;
  std::atomic<float> peak = 0;
  std::atomic<bool> ended = false;
  std::thread thread = {};
};

class OnThreads final : public SoundRecording {
 public:
  ~OnThreads() override { stop(); }

  Result<void> start(const TakeLayout& take, const std::vector<std::string>& uris,
                     std::vector<std::unique_ptr<SoundSource>> sources) {
    std::vector<SoundTrack> tracks;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const SoundSource& source = *sources[i];
      tracks.push_back({.name = i == 0 ? "sound" : text("sound", i + 1),
                        .rate = source.rate(),
                        .channels = source.channels(),
                        .bits = source.bits(),
                        .from = uris[i]});
    }
    if (Result<void> ok = save_sound_tracks(tracks, take); !ok) return ok;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      Result<std::unique_ptr<SoundWriter>> writer = SoundWriter::create(take, tracks[i]);
      if (!writer) return forward(writer);
      lanes_.emplace_back();
      lanes_.back().track = tracks[i];
      lanes_.back().source = std::move(sources[i]);
      lanes_.back().writer = std::move(*writer);
    }
    for (Lane& lane : lanes_)
      lane.thread = std::thread([this, &lane] {
        run(lane);
        lane.ended = true;
      });
    return {};
  }

  std::vector<SoundLevel> levels() const override {
    std::vector<SoundLevel> out;
    for (const Lane& lane : lanes_)
      out.push_back(
          {lane.track.name, static_cast<double>(lane.samples) / lane.track.rate, lane.peak, lane.ended});
    return out;
  }

  void wait() override {
    for (Lane& lane : lanes_)
      if (lane.thread.joinable()) lane.thread.join();
  }

  Result<void> finish() override {
    stop();
    for (Lane& lane : lanes_) {
      if (lane.result) lane.result = lane.writer->finish();
      if (!lane.result) return lane.result;
    }
    return {};
  }

 private:
  void stop() {
    stopping_ = true;
    wait();
  }

  void run(Lane& lane) {
    while (!stopping_) {
      const Result<SoundPeriod> period = lane.source->next();
      if (!period && period.error().code == ErrorCode::Timeout) continue;
      if (!period) {
        log::warning(text("sound '", lane.track.name, "' ends after ",
                          static_cast<double>(lane.writer->samples()) / lane.track.rate,
                          " s: ", period.error().message));
        return;
      }
      lane.result = lane.writer->stamp(lane.writer->samples(), period->time, period->new_run);
      if (lane.result) lane.result = lane.writer->write(period->samples);
      note_level(lane, *period);
      if (lane.result) continue;
      log::error(lane.result.error().message);
      return;
    }
  }

  static void note_level(Lane& lane, const SoundPeriod& period) {
    constexpr double kHalf = 1.0 / 6;  // s
    const double length =
        static_cast<double>(period.samples.size()) / (lane.track.rate * lane.track.channels);
    auto peak = static_cast<float>(lane.peak * std::exp2(-length / kHalf));
    for (const float level : period.samples) peak = std::max(peak, std::min(1.F, std::abs(level)));
    lane.peak = peak;
    lane.samples = lane.writer->samples();
  }

  std::atomic<bool> stopping_ = false;
  std::deque<Lane> lanes_;
};

}  // namespace

Result<std::unique_ptr<SoundRecording>> SoundRecording::start(
    const TakeLayout& take, const std::vector<std::string>& uris,
    std::vector<std::unique_ptr<SoundSource>> sources) {
  FLOATSTAGE_CHECK(uris.size() == sources.size(), "a source without a name");
  auto recording = std::make_unique<OnThreads>();
  if (Result<void> ok = recording->start(take, uris, std::move(sources)); !ok) return forward(ok);
  return std::unique_ptr<SoundRecording>(std::move(recording));
}

}  // namespace floatstage::capture
