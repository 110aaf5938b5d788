#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <thread>

#include "capture/sound/alsa_source.h"
#include "capture/sound/media_sound.h"
#include "capture/studio_clock.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr double kMostPpm = 1000, kUsualTone = 440, kHighestTone = 20'000;
constexpr int kToneRate = 48'000;

std::optional<double> number(std::string_view s) {
  double value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || error != std::errc() || end != s.data() + s.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// "HEAD?ppm=50&live=off"
struct Simulated {
  std::string head;
  double ppm = 0;
  bool live = true;
};

std::optional<Simulated> simulated(std::string_view rest) {
  Simulated out;
  const std::size_t question = rest.rfind('?');
  out.head = rest.substr(0, question);
  if (question == std::string_view::npos) return out;
  rest.remove_prefix(question + 1);
  while (!rest.empty()) {
    const std::string_view option = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(option.size() + 1, rest.size()));
    if (option == "live=on" || option == "live=off") {
      out.live = option == "live=on";
      continue;
    }
    const std::optional<double> ppm = option.starts_with("ppm=") ? number(option.substr(4)) : std::nullopt;
    if (!ppm || std::abs(*ppm) > kMostPpm) return std::nullopt;
    out.ppm = *ppm;
  }
  return out;
}

/// A device made of samples that somebody else has: it delivers 10 ms when its own clock says that they have
/// passed.
class Device final : public SoundSource {
 public:
  Device(std::unique_ptr<MediaSound> file, double tone, const Simulated& how)
      : file_(std::move(file)), tone_(tone), how_(how), begin_(how.live ? studio_now() : Timestamp{}) {}

  int rate() const override { return file_ ? file_->rate() : kToneRate; }
  int channels() const override { return file_ ? file_->channels() : 1; }
  int bits() const override { return file_ ? file_->bits() : 16; }

  Result<SoundPeriod> next() override {
    const auto count = static_cast<std::size_t>(rate() / 100 * channels());
    while (file_ && !ended_ && ready_.size() < count) {
      Result<MediaSound::Block> block = file_->next();
      if (!block && block.error().code != ErrorCode::EndOfStream) return forward(block);
      ended_ = !block;
      if (block) ready_.insert(ready_.end(), block->samples.begin(), block->samples.end());
    }
    if (file_ && ready_.empty()) return fail(ErrorCode::EndOfStream, "the file has no more sound");
    SoundPeriod period;
    period.time = time_of(delivered_);
    if (file_) {
      const auto some = static_cast<std::ptrdiff_t>(std::min(count, ready_.size()));
      period.samples.assign(ready_.begin(), ready_.begin() + some);
      ready_.erase(ready_.begin(), ready_.begin() + some);
    } else {
      for (std::size_t i = 0; i < count; ++i) {
        const double t = static_cast<double>(delivered_ + static_cast<std::int64_t>(i)) / kToneRate;
        period.samples.push_back(
            static_cast<float>(0.25 * std::sin(2 * std::numbers::pi * std::fmod(tone_ * t, 1.0))));
      }
    }
    delivered_ += static_cast<std::int64_t>(period.samples.size()) / channels();
    if (how_.live)
      if (const std::int64_t left = (time_of(delivered_) - studio_now()).count; left > 0)
        std::this_thread::sleep_for(std::chrono::nanoseconds(left));
    return period;
  }

 private:
  Timestamp time_of(std::int64_t sample) const {
    return begin_ +
           Nanoseconds{std::llround(static_cast<double>(sample) / (rate() * (1 + how_.ppm * 1e-6)) * 1e9)};
  }

  const std::unique_ptr<MediaSound> file_;  // none: a tone
  const double tone_;
  const Simulated how_;
  const Timestamp begin_;
  std::vector<float> ready_;
  std::int64_t delivered_ = 0;
  bool ended_ = false;
};

}  // namespace

Result<std::unique_ptr<SoundSource>> open_sound(const std::string& uri) {
  const auto refuse = [&](const std::string& why) {
    return fail(ErrorCode::InvalidArgument,
                text("'", uri, "' is no source of sound: ", why, "; write ", kSoundUsage));
  };
  const std::size_t colon = std::min(uri.find(':'), uri.size());
  const std::string kind = uri.substr(0, colon), rest = uri.substr(std::min(colon + 1, uri.size()));
  if (colon == uri.size()) return refuse("it names no kind");
  if (kind == "alsa") return rest.empty() ? refuse("it names no device") : open_alsa(rest, uri);
  if (kind != "file" && kind != "tone") return refuse(text("'", kind, "' is not known"));
  const std::optional<Simulated> how = simulated(rest);
  if (!how) return refuse("what follows '?' is ppm, up to 1000, and live");
  if (kind == "tone") {
    const std::optional<double> hertz = how->head.empty() ? kUsualTone : number(how->head);
    if (!hertz || !(*hertz > 0 && *hertz <= kHighestTone)) return refuse("a tone has up to 20000 Hz");
    return std::unique_ptr<SoundSource>(std::make_unique<Device>(nullptr, *hertz, *how));
  }
  Result<std::unique_ptr<MediaSound>> file = MediaSound::open(how->head);
  if (!file) return forward(file);
  if (!*file) return fail(ErrorCode::BadData, text(how->head, " has no sound"));
  return std::unique_ptr<SoundSource>(std::make_unique<Device>(std::move(*file), 0, *how));
}

}  // namespace floatstage::capture
