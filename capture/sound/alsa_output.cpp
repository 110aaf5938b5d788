// docs/adr/0279-pictures-follow-the-sound-device.md

#include "capture/sound/alsa_output.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <vector>

#include <alsa/asoundlib.h>

#include "capture/studio_clock.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr unsigned kPeriodMicroseconds = 10'000;
constexpr auto kBufferMicroseconds = static_cast<unsigned>(kOutputBuffer * 1e6);

struct Closes {
  void operator()(snd_pcm_t* pcm) const {
    snd_pcm_drop(pcm);
    snd_pcm_close(pcm);
  }
};

void say_nothing(const char*, int, const char*, int, const char*, ...) {}

class AlsaOutput final : public SoundOutput {
 public:
  explicit AlsaOutput(std::string uri) : uri_(std::move(uri)) {}

  Result<void> open(const std::string& device) {
    snd_lib_error_set_handler(&say_nothing);
    snd_pcm_t* opened = nullptr;
    if (const int error = snd_pcm_open(&opened, device.c_str(), SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK);
        error < 0)
      return fail(error == -ENOENT || error == -ENODEV ? ErrorCode::NotFound : ErrorCode::Io,
                  text("cannot play to ", uri_, ": ", snd_strerror(error),
                       "; `aplay -L` lists the devices, and a busy one belongs to another program"));
    pcm_.reset(opened);
    if (const int error = set_up(); error < 0)
      return fail(ErrorCode::Unsupported,
                  text(uri_, " cannot be set up for two channels of ", kPlayOutRate,
                       " samples a second: ", snd_strerror(error), "; plug:DEVICE converts"));
    return {};
  }

  Result<std::int64_t> room() override {
    snd_pcm_sframes_t free = snd_pcm_avail(pcm_.get());
    if (free < 0) {
      if (!recovered(static_cast<int>(free))) return gone(static_cast<int>(free));
      free = snd_pcm_avail(pcm_.get());
    }
    if (free < 0) return gone(static_cast<int>(free));
    return std::int64_t{free};
  }

  Result<void> write(std::span<const float> interleaved) override {
    while (!interleaved.empty()) {
      levels_.clear();
      for (const float level : interleaved)
        levels_.push_back(static_cast<std::int16_t>(
            std::lround(32767 * std::clamp(std::isfinite(level) ? level : 0.F, -1.F, 1.F))));
      const snd_pcm_sframes_t done =
          snd_pcm_writei(pcm_.get(), levels_.data(), interleaved.size() / kOutputChannels);
      if (done == -EAGAIN) {  // there was less room than it said
        snd_pcm_wait(pcm_.get(), 10);
        continue;
      }
      if (done < 0) {
        if (!recovered(static_cast<int>(done))) return gone(static_cast<int>(done));
        continue;
      }
      written_ += done;
      interleaved = interleaved.subspan(static_cast<std::size_t>(done) * kOutputChannels);
    }
    return {};
  }

  Result<std::int64_t> heard() override {
    snd_pcm_sframes_t waiting = 0;
    const int error = snd_pcm_delay(pcm_.get(), &waiting);
    // It ran dry: all of it was heard.
    if (error == -EPIPE) return written_;
    if (error == -ENODEV || error == -EBADFD) return gone(error);
    if (error < 0) waiting = 0;
    // Devices without a clock of their own count backwards now and then.
    heard_ = std::clamp<std::int64_t>(written_ - waiting, heard_, written_);
    return heard_;
  }

  void drop() override {
    snd_pcm_drop(pcm_.get());
    snd_pcm_prepare(pcm_.get());
    written_ = heard_ = 0;
  }

  double clock() override { return seconds(studio_now() - opened_); }

 private:
  int set_up() {
    snd_pcm_t* pcm = pcm_.get();
    snd_pcm_hw_params_t* hardware = nullptr;
    snd_pcm_hw_params_alloca(&hardware);
    unsigned rate = kPlayOutRate, period = kPeriodMicroseconds, buffer = kBufferMicroseconds;
    int error = snd_pcm_hw_params_any(pcm, hardware);
    if (error >= 0) error = snd_pcm_hw_params_set_access(pcm, hardware, SND_PCM_ACCESS_RW_INTERLEAVED);
    if (error >= 0) error = snd_pcm_hw_params_set_format(pcm, hardware, SND_PCM_FORMAT_S16);
    if (error >= 0) error = snd_pcm_hw_params_set_channels(pcm, hardware, kOutputChannels);
    if (error >= 0) error = snd_pcm_hw_params_set_rate_resample(pcm, hardware, 1);
    if (error >= 0) error = snd_pcm_hw_params_set_rate(pcm, hardware, rate, 0);
    if (error >= 0) error = snd_pcm_hw_params_set_period_time_near(pcm, hardware, &period, nullptr);
    if (error >= 0) error = snd_pcm_hw_params_set_buffer_time_near(pcm, hardware, &buffer, nullptr);
    if (error >= 0) error = snd_pcm_hw_params(pcm, hardware);
    return error;
  }

  // An output that ran dry, or a machine that slept, plays on.
  bool recovered(int error) {
    return (error == -EPIPE || error == -ESTRPIPE) && snd_pcm_recover(pcm_.get(), error, 1) >= 0;
  }
  Unexpected gone(int error) const {
    return fail(ErrorCode::Disconnected, text(uri_, ": ", snd_strerror(error)));
  }

  const std::string uri_;
  std::unique_ptr<snd_pcm_t, Closes> pcm_;
  std::int64_t written_ = 0, heard_ = 0;
  std::vector<std::int16_t> levels_;
  const Timestamp opened_ = studio_now();
};

}  // namespace

Result<std::unique_ptr<SoundOutput>> open_alsa_output(const std::string& device, const std::string& uri) {
  auto output = std::make_unique<AlsaOutput>(uri);
  if (Result<void> ok = output->open(device); !ok) return forward(ok);
  return std::unique_ptr<SoundOutput>(std::move(output));
}

}  // namespace floatstage::capture
