// docs/adr/0271-alsa-for-sound.md

#include "capture/sound/alsa_source.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include <alsa/asoundlib.h>

#include "capture/studio_clock.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr unsigned kPeriodMicroseconds = 10'000, kBufferMicroseconds = 1'000'000;
constexpr int kWaitMilliseconds = 250;

struct Closes {
  void operator()(snd_pcm_t* pcm) const { snd_pcm_close(pcm); }
};

void say_nothing(const char*, int, const char*, int, const char*, ...) {}

struct Form {
  snd_pcm_format_t format;
  int bytes, bits;
};
// The finest first.
constexpr std::array<Form, 3> kForms = {
    {{SND_PCM_FORMAT_S32_LE, 4, 24}, {SND_PCM_FORMAT_S24_3LE, 3, 24}, {SND_PCM_FORMAT_S16_LE, 2, 16}}};

class AlsaSource final : public SoundSource {
 public:
  explicit AlsaSource(std::string uri) : uri_(std::move(uri)) {}

  Result<void> open(const std::string& device) {
    snd_lib_error_set_handler(&say_nothing);
    snd_pcm_t* opened = nullptr;
    if (const int error = snd_pcm_open(&opened, device.c_str(), SND_PCM_STREAM_CAPTURE, 0); error < 0)
      return fail(error == -ENOENT || error == -ENODEV ? ErrorCode::NotFound : ErrorCode::Io,
                  text("cannot record from ", uri_, ": ", snd_strerror(error),
                       "; `arecord -L` lists the devices, and a busy one belongs to another program"));
    pcm_.reset(opened);
    if (const int error = set_up(); error < 0)
      return fail(ErrorCode::Unsupported, text(uri_, " cannot be set up: ", snd_strerror(error)));
    if (const int error = snd_pcm_start(opened); error < 0)
      return fail(ErrorCode::Io, text(uri_, " does not start: ", snd_strerror(error)));
    return {};
  }

  int rate() const override { return static_cast<int>(rate_); }
  int channels() const override { return static_cast<int>(channels_); }
  int bits() const override { return form_.bits; }

  Result<SoundPeriod> next() override {
    snd_pcm_t* pcm = pcm_.get();
    if (const int ready = snd_pcm_wait(pcm, kWaitMilliseconds); ready == 0)
      return fail(ErrorCode::Timeout, text(uri_, " delivers nothing"));
    else if (ready < 0)
      return lost(ready);
    // The time at which the newest sample that waits was there.
    snd_pcm_uframes_t waiting = 0;
    snd_htimestamp_t at = {};
    if (const int error = snd_pcm_htimestamp(pcm, &waiting, &at); error < 0) return lost(error);
    Timestamp newest{static_cast<std::int64_t>(at.tv_sec) * 1'000'000'000 + at.tv_nsec};
    if (newest.ns == 0) newest = studio_now();  // plugins without hardware behind them know none
    const auto most = static_cast<snd_pcm_uframes_t>(rate_);
    const snd_pcm_uframes_t wanted = std::clamp<snd_pcm_uframes_t>(waiting, 1, most);
    bytes_.resize(wanted * channels_ * static_cast<std::size_t>(form_.bytes));
    const snd_pcm_sframes_t got = snd_pcm_readi(pcm, bytes_.data(), wanted);
    if (got < 0) return lost(static_cast<int>(got));
    if (got == 0) return fail(ErrorCode::Timeout, text(uri_, " delivers nothing"));
    SoundPeriod period;
    period.time =
        newest - Nanoseconds{std::llround(static_cast<double>(waiting) / static_cast<double>(rate_) * 1e9)};
    period.new_run = std::exchange(broken_, false);
    const std::size_t values = static_cast<std::size_t>(got) * channels_;
    period.samples.reserve(values);
    for (std::size_t i = 0; i < values; ++i) {
      // Little endian, moved to the top of 32 bits.
      std::uint32_t level = 0;
      std::memcpy(&level, bytes_.data() + i * static_cast<std::size_t>(form_.bytes),
                  static_cast<std::size_t>(form_.bytes));
      level <<= 32 - 8 * form_.bytes;
      period.samples.push_back(
          static_cast<float>(std::ldexp(static_cast<double>(static_cast<std::int32_t>(level)), -31)));
    }
    return period;
  }

 private:
  int set_up() {
    snd_pcm_t* pcm = pcm_.get();
    snd_pcm_hw_params_t* hardware = nullptr;
    snd_pcm_hw_params_alloca(&hardware);
    int error = snd_pcm_hw_params_any(pcm, hardware);
    if (error >= 0) error = snd_pcm_hw_params_set_access(pcm, hardware, SND_PCM_ACCESS_RW_INTERLEAVED);
    if (error < 0) return error;
    error = -EINVAL;
    for (std::size_t i = 0; i < kForms.size() && error < 0; ++i) {
      form_ = kForms[i];
      error = snd_pcm_hw_params_set_format(pcm, hardware, form_.format);
    }
    unsigned period = kPeriodMicroseconds, buffer = kBufferMicroseconds;
    if (error >= 0) error = snd_pcm_hw_params_set_channels_near(pcm, hardware, &channels_);
    if (error >= 0) error = snd_pcm_hw_params_set_rate_near(pcm, hardware, &rate_, nullptr);
    if (error >= 0) error = snd_pcm_hw_params_set_period_time_near(pcm, hardware, &period, nullptr);
    if (error >= 0) error = snd_pcm_hw_params_set_buffer_time_near(pcm, hardware, &buffer, nullptr);
    if (error >= 0) error = snd_pcm_hw_params(pcm, hardware);
    if (error < 0) return error;
    snd_pcm_sw_params_t* software = nullptr;
    snd_pcm_sw_params_alloca(&software);
    error = snd_pcm_sw_params_current(pcm, software);
    if (error >= 0) error = snd_pcm_sw_params_set_tstamp_mode(pcm, software, SND_PCM_TSTAMP_ENABLE);
    if (error >= 0) error = snd_pcm_sw_params_set_tstamp_type(pcm, software, SND_PCM_TSTAMP_TYPE_MONOTONIC);
    if (error >= 0) error = snd_pcm_sw_params(pcm, software);
    return error;
  }

  // Samples that nobody fetched in time are gone: the next ones are another run.
  Unexpected lost(int error) {
    if (error == -EPIPE || error == -ESTRPIPE) {
      broken_ = true;
      if (snd_pcm_recover(pcm_.get(), error, 1) >= 0 && snd_pcm_start(pcm_.get()) >= 0)
        return fail(ErrorCode::Timeout, text(uri_, ": sound was lost"));
    }
    return fail(ErrorCode::Disconnected, text(uri_, ": ", snd_strerror(error)));
  }

  const std::string uri_;
  std::unique_ptr<snd_pcm_t, Closes> pcm_;
  Form form_ = kForms.back();
  unsigned rate_ = 48'000, channels_ = 2;
  bool broken_ = false;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

Result<std::unique_ptr<SoundSource>> open_alsa(const std::string& device, const std::string& uri) {
  auto source = std::make_unique<AlsaSource>(uri);
  if (Result<void> ok = source->open(device); !ok) return forward(ok);
  return std::unique_ptr<SoundSource>(std::move(source));
}

}  // namespace floatstage::capture
