#include "capture/sound/play_out.h"

extern "C" {
#include <libavutil/opt.h>
#include <libswresample/swresample.h>
}

#include <algorithm>
#include <cmath>

#include "capture/libav.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct SwrDeleter {
  void operator()(SwrContext* swr) const { swr_free(&swr); }
};

// Of a hertz: rates are stated to libswresample in whole numbers, and two clocks that differ by 0.02 parts in
// a million are told apart.
constexpr double kRateUnits = 1000;
constexpr std::int64_t kChunk = 4096;  // samples that are read at once

class Resampled final : public PlayOut {
 public:
  Resampled(SoundReader& reader, std::vector<int> channels)
      : reader_(reader), channels_(std::move(channels)) {}

  void seek(Timestamp time, double speed) override {
    begin_ = time;
    speed_ = speed;
    played_ = 0;
    run_ = nullptr;
    swr_.reset();
  }

  Result<void> read(std::span<float> out) override {
    std::fill(out.begin(), out.end(), 0.f);
    const auto width = static_cast<std::int64_t>(channels_.size());
    std::int64_t wanted = static_cast<std::int64_t>(out.size()) / width;
    float* at = out.data();
    while (wanted > 0) {
      if (!run_) enter(wanted);
      // Silence up to the next run, or the sound of this one.
      const std::int64_t until = (run_ ? run_end_ : silent_until_) - played_;
      const std::int64_t now = std::min(wanted, std::max<std::int64_t>(until, 0));
      if (run_)
        if (Result<void> ok = fetch(at, now); !ok) return ok;
      if (until <= wanted) leave();
      at += now * width;
      wanted -= now;
      played_ += now;
    }
    return {};
  }

 private:
  // When the next sample is heard, in samples from the seek.
  std::int64_t position_of(Timestamp time) const {
    return static_cast<std::int64_t>(
        std::ceil(static_cast<double>((time - begin_).count) * 1e-9 / speed_ * kPlayOutRate));
  }

  void leave() {
    run_ = nullptr;
    swr_.reset();
  }

  // The run that is heard at this position, or how long there is none.
  void enter(std::int64_t wanted) {
    silent_until_ = played_ + wanted;
    for (const SoundRun& run : reader_.clock().runs()) {
      const std::int64_t first = position_of(reader_.clock().start_of(run)),
                         end = position_of(reader_.clock().end_of(run));
      if (end <= played_) continue;
      if (first > played_) {
        silent_until_ = std::min(silent_until_, first);
        continue;
      }
      run_ = &run;
      run_end_ = end;
      const Timestamp now =
          begin_ + Nanoseconds{std::llround(static_cast<double>(played_) / kPlayOutRate * speed_ * 1e9)};
      next_ = std::max<std::int64_t>(run.first, std::llround(reader_.clock().sample_at(run, now)));
      AVChannelLayout layout = {};
      av_channel_layout_default(&layout, static_cast<int>(channels_.size()));
      SwrContext* swr = nullptr;
      const int given = static_cast<int>(std::llround(run.rate * speed_ * kRateUnits));
      FLOATSTAGE_CHECK(
          swr_alloc_set_opts2(&swr, &layout, AV_SAMPLE_FMT_FLT, static_cast<int>(kPlayOutRate * kRateUnits),
                              &layout, AV_SAMPLE_FMT_FLT, given, 0, nullptr) >= 0,
          "out of memory");
      swr_.reset(swr);
      av_opt_set_int(swr, "linear_interp", 1, 0);
      FLOATSTAGE_CHECK(swr_init(swr) >= 0, text("libswresample refuses a clock of ", run.rate, " Hz"));
      return;
    }
  }

  Result<void> fetch(float* out, std::int64_t wanted) {
    const auto width = static_cast<std::int64_t>(channels_.size());
    while (wanted > 0) {
      auto* to = reinterpret_cast<std::uint8_t*>(out);
      int got = swr_convert(swr_.get(), &to, static_cast<int>(wanted), nullptr, 0);
      FLOATSTAGE_CHECK(got >= 0, "libswresample failed");
      out += got * width;
      wanted -= got;
      if (wanted == 0) return {};
      // A little beyond the run is silent: it pushes the last samples out.
      if (Result<void> ok = load(); !ok) return ok;
      const auto* from = reinterpret_cast<const std::uint8_t*>(heard_.data());
      to = reinterpret_cast<std::uint8_t*>(out);
      got = swr_convert(swr_.get(), &to, static_cast<int>(wanted), &from, static_cast<int>(kChunk));
      FLOATSTAGE_CHECK(got >= 0, "libswresample failed");
      out += got * width;
      wanted -= got;
    }
    return {};
  }

  // The next samples of the run, of the channels that are heard.
  Result<void> load() {
    const auto all = static_cast<std::size_t>(reader_.track().channels);
    recorded_.assign(static_cast<std::size_t>(kChunk) * all, 0.f);
    const std::int64_t there = std::clamp<std::int64_t>(run_->end - next_, 0, kChunk);
    if (there > 0)
      if (Result<void> ok =
              reader_.read(next_, std::span(recorded_).first(static_cast<std::size_t>(there) * all));
          !ok)
        return ok;
    next_ += kChunk;
    heard_.clear();
    for (std::size_t i = 0; i < static_cast<std::size_t>(kChunk); ++i)
      for (const int c : channels_) heard_.push_back(recorded_[i * all + static_cast<std::size_t>(c)]);
    return {};
  }

  SoundReader& reader_;
  const std::vector<int> channels_;
  Timestamp begin_;
  double speed_ = 1;
  std::int64_t played_ = 0;                      // samples since the seek
  const SoundRun* run_ = nullptr;                // that is heard
  std::int64_t run_end_ = 0, silent_until_ = 0;  // positions
  std::int64_t next_ = 0;                        // sample that is loaded next
  std::unique_ptr<SwrContext, SwrDeleter> swr_;
  std::vector<float> recorded_, heard_;
};

}  // namespace

Result<std::unique_ptr<PlayOut>> PlayOut::create(SoundReader& reader, const std::vector<int>& channels) {
  if (channels.empty() || channels.size() > kMostSoundChannels)
    return fail(ErrorCode::InvalidArgument, "sound is heard of one channel or several");
  for (const int c : channels)
    if (c < 0 || c >= reader.track().channels)
      return fail(ErrorCode::InvalidArgument, text("sound '", reader.track().name, "' has no channel ", c));
  return std::unique_ptr<PlayOut>(std::make_unique<Resampled>(reader, channels));
}

}  // namespace floatstage::capture
