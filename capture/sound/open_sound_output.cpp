#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <deque>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "capture/sound/alsa_output.h"
#include "capture/studio_clock.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr double kMostPpm = 1000;
constexpr std::size_t kHeader = 44;  // bytes of a WAV file before its samples

template <class T>
void put(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// What a loudspeaker gave from when it was opened on, as a WAV file of 16 bits: samples, and silence where
/// there were none. Its header is right whenever it is written.
class WavFile {
 public:
  Result<void> open(const std::string& path) {
    path_ = path;
    fd_ = FileDescriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (fd_.get() < 0) return fail(ErrorCode::Io, text("cannot write ", path, ": ", std::strerror(errno)));
    return write({});
  }

  Result<void> write(std::span<const std::int16_t> levels) {
    samples_ += levels.size_bytes();
    std::string header = "RIFF";
    put(header, static_cast<std::uint32_t>(kHeader - 8 + samples_));
    header += "WAVEfmt ";
    put(header, std::uint32_t{16}), put(header, std::uint16_t{1}),
        put(header, std::uint16_t{kOutputChannels});
    put(header, std::uint32_t{kPlayOutRate}), put(header, std::uint32_t{kPlayOutRate * kOutputChannels * 2});
    put(header, std::uint16_t{kOutputChannels * 2}), put(header, std::uint16_t{16});
    header += "data";
    put(header, static_cast<std::uint32_t>(samples_));
    const auto at = static_cast<off_t>(kHeader + samples_ - levels.size_bytes());
    if (::pwrite(fd_.get(), levels.data(), levels.size_bytes(), at) !=
            static_cast<ssize_t>(levels.size_bytes()) ||
        ::pwrite(fd_.get(), header.data(), header.size(), 0) != static_cast<ssize_t>(header.size()))
      return fail(ErrorCode::Io, text("cannot write ", path_, ": ", std::strerror(errno)));
    return {};
  }

 private:
  std::string path_;
  FileDescriptor fd_;
  std::uint64_t samples_ = 0;  // bytes
};

/// A device made of a clock: what was written is heard when its time comes.
class ByClock final : public SoundOutput {
 public:
  ByClock(std::function<Timestamp()> now, double ppm)
      : now_(std::move(now)), rate_(kPlayOutRate * (1 + ppm * 1e-6)), opened_(now_()) {}
  ~ByClock() override { static_cast<void>(play()); }
  ByClock(const ByClock&) = delete;
  ByClock& operator=(const ByClock&) = delete;

  Result<void> open(const std::string& path) {
    file_ = std::make_unique<WavFile>();
    return file_->open(path);
  }

  Result<std::int64_t> room() override {
    if (Result<void> ok = play(); !ok) return forward(ok);
    constexpr auto kMost = static_cast<std::int64_t>(kOutputBuffer * kPlayOutRate);
    return std::max<std::int64_t>(0, kMost - static_cast<std::int64_t>(waiting_.size()) / kOutputChannels);
  }
  Result<void> write(std::span<const float> interleaved) override {
    if (Result<void> ok = play(); !ok) return ok;
    waiting_.insert(waiting_.end(), interleaved.begin(), interleaved.end());
    return {};
  }
  Result<std::int64_t> heard() override {
    if (Result<void> ok = play(); !ok) return forward(ok);
    return heard_;
  }
  void drop() override {
    static_cast<void>(play());
    waiting_.clear();
    heard_ = 0;
  }
  double clock() override { return seconds(now_() - opened_); }

 private:
  // What has been due since the last look.
  Result<void> play() {
    const auto due = static_cast<std::int64_t>(seconds(now_() - opened_) * rate_);
    std::vector<std::int16_t> levels;
    for (; played_ < due; ++played_) {
      const bool any = waiting_.size() >= kOutputChannels;
      if (any) ++heard_;
      if (!any && !file_) {
        played_ = due;
        break;
      }
      for (int c = 0; c < kOutputChannels; ++c) {
        const float level = any ? waiting_.front() : 0.F;
        if (any) waiting_.pop_front();
        if (file_)
          levels.push_back(static_cast<std::int16_t>(
              std::lround(32767 * std::clamp(std::isfinite(level) ? level : 0.F, -1.F, 1.F))));
      }
    }
    return file_ && !levels.empty() ? file_->write(levels) : Result<void>();
  }

  const std::function<Timestamp()> now_;
  const double rate_;
  const Timestamp opened_;
  std::unique_ptr<WavFile> file_;  // none: nobody hears it
  std::deque<float> waiting_;
  std::int64_t played_ = 0, heard_ = 0;
};

}  // namespace

std::unique_ptr<SoundOutput> silent_output(std::function<Timestamp()> now) {
  return std::make_unique<ByClock>(std::move(now), 0);
}

Result<std::unique_ptr<SoundOutput>> open_sound_output(const std::string& uri) {
  const auto refuse = [&](const std::string& why) {
    return fail(ErrorCode::InvalidArgument,
                text("'", uri, "' is no output of sound: ", why, "; write ", kSoundOutputUsage));
  };
  const std::size_t colon = uri.find(':');
  if (colon == std::string::npos) return refuse("it names no kind");
  const std::string kind = uri.substr(0, colon);
  std::string rest = uri.substr(colon + 1);
  if (kind == "alsa") return rest.empty() ? refuse("it names no device") : open_alsa_output(rest, uri);
  if (kind == "none") {
    if (!rest.empty()) return refuse("nothing follows none:");
    return silent_output(studio_now);
  }
  if (kind != "file") return refuse(text("'", kind, "' is not known"));
  double ppm = 0;
  if (const std::size_t question = rest.rfind("?ppm="); question != std::string::npos) {
    const char *begin = rest.data() + question + 5, *end = rest.data() + rest.size();
    const auto [next, error] = std::from_chars(begin, end, ppm);
    if (error != std::errc() || next != end || !(std::abs(ppm) <= kMostPpm))
      return refuse("ppm is up to 1000");
    rest.resize(question);
  }
  if (rest.empty()) return refuse("it names no file");
  auto output = std::make_unique<ByClock>(studio_now, ppm);
  if (Result<void> ok = output->open(rest); !ok) return forward(ok);
  return std::unique_ptr<SoundOutput>(std::move(output));
}

}  // namespace floatstage::capture
