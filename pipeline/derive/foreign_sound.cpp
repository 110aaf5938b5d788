#include "pipeline/derive/foreign_sound.h"

#include <algorithm>
#include <cmath>

#include "capture/sound/media_sound.h"
#include "capture/sound/sound_writer.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/confined_job.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr Nanoseconds kUnbroken = milliseconds(40);  // of what containers with coarse times say
constexpr float kSilence = 1.F / 32768;              // one step of 16 bits
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

// What the child reports.
struct Copied {
  int rate = 0, channels = 0, bits = 0;
  std::int64_t samples = 0;
  double peak = 0, first = 0;
  std::vector<double> since_midnight;  // one or none
  std::vector<std::string> time_code;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Copied, rate, channels, bits, samples, peak, first, since_midnight,
                                   time_code)

std::string ltc_name(const std::string& name) { return name + "-ltc"; }

class Copying {
 public:
  Copying(fs::path file, std::string name, std::optional<int> ltc, const fs::path& folder)
      : file_(std::move(file)), name_(std::move(name)), ltc_(ltc), take_(folder) {}

  Result<Copied> run(Progress* progress) {
    Result<std::unique_ptr<capture::MediaSound>> sound = capture::MediaSound::open(file_);
    if (!sound) return forward(sound);
    if (!*sound)
      return fail(ErrorCode::BadData,
                  text(file_.string(), ": has no sound track; name a recording of sound"));
    if (Result<void> ok = open(**sound); !ok) return forward(ok);
    ProgressPart part(progress, "minutes of sound", 0);
    std::int64_t minutes = 0;
    std::optional<Nanoseconds> expected;
    for (;;) {
      if (is_cancelled(progress)) return cancelled();
      const Result<capture::MediaSound::Block> block = (*sound)->next();
      if (!block && block.error().code == ErrorCode::EndOfStream) break;
      if (!block) return forward(block);
      if (expected && std::abs((block->time - *expected).count) > kUnbroken.count)
        return fail(ErrorCode::BadData,
                    text(file_.string(), ": its sound stops ", seconds_at(copied_.samples),
                         " s after its beginning and goes on ", seconds(block->time - *expected),
                         " s later; fill the hole (ffmpeg -i IN -af aresample=async=1 OUT.wav)"));
      if (!expected) copied_.first = seconds(block->time);
      if (Result<void> ok = write(block->samples); !ok) return forward(ok);
      const auto count = static_cast<std::int64_t>(block->samples.size()) / channels_;
      expected = block->time + Nanoseconds{count * 1'000'000'000 / copied_.rate};
      copied_.samples += count;
      if (const std::int64_t now = copied_.samples / copied_.rate / 60; now > minutes)
        part.advance(static_cast<std::size_t>(now - minutes)), minutes = now;
    }
    for (capture::SoundWriter* w : {writer_.get(), ltc_writer_.get()})
      if (w)
        if (Result<void> ok = w->finish(); !ok) return forward(ok);
    return copied_;
  }

 private:
  double seconds_at(std::int64_t sample) const { return static_cast<double>(sample) / copied_.rate; }

  Result<void> open(const capture::MediaSound& sound) {
    channels_ = sound.channels();
    copied_.rate = sound.rate();
    copied_.bits = sound.bits();
    copied_.channels = channels_ - (ltc_ ? 1 : 0);
    if (const std::optional<double> at = sound.since_midnight()) copied_.since_midnight.push_back(*at);
    if (const std::optional<std::string> code = sound.time_code()) copied_.time_code.push_back(*code);
    if (ltc_ && (*ltc_ < 0 || *ltc_ >= channels_))
      return fail(ErrorCode::InvalidArgument, text(file_.string(), ": has no channel ", *ltc_, "; it has ",
                                                   channels_, ", counted from 0"));
    if (copied_.channels < 1)
      return fail(ErrorCode::InvalidArgument,
                  text(file_.string(),
                       ": its only channel is to be time code, so nothing is left to hear; "
                       "place it by --at, --clap or --stamp"));
    Result<std::unique_ptr<capture::SoundWriter>> writer = create(name_, copied_.channels);
    if (!writer) return forward(writer);
    writer_ = std::move(*writer);
    if (!ltc_) return {};
    writer = create(ltc_name(name_), 1);
    if (!writer) return forward(writer);
    ltc_writer_ = std::move(*writer);
    return {};
  }

  Result<std::unique_ptr<capture::SoundWriter>> create(const std::string& name, int channels) const {
    Result<std::unique_ptr<capture::SoundWriter>> writer = capture::SoundWriter::create(
        take_, {.name = name, .rate = copied_.rate, .channels = channels, .bits = copied_.bits, .from = ""});
    if (!writer) return writer;
    if (Result<void> ok = (*writer)->stamp(0, Timestamp{}); !ok) return forward(ok);
    return writer;
  }

  Result<void> write(const std::vector<float>& samples) {
    heard_.clear(), code_.clear();
    const auto width = static_cast<std::size_t>(channels_);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const bool code = ltc_ && static_cast<int>(i % width) == *ltc_;
      (code ? code_ : heard_).push_back(samples[i]);
      if (!code) copied_.peak = std::max(copied_.peak, static_cast<double>(std::abs(samples[i])));
    }
    Result<void> ok = writer_->write(heard_);
    if (ok && ltc_writer_) ok = ltc_writer_->write(code_);
    return ok;
  }

  const fs::path file_;
  const std::string name_;
  const std::optional<int> ltc_;
  const TakeLayout take_;
  int channels_ = 1;
  Copied copied_;
  std::unique_ptr<capture::SoundWriter> writer_, ltc_writer_;
  std::vector<float> heard_, code_;
};

}  // namespace

Result<ForeignSound> copy_foreign_sound(const fs::path& file, const std::string& name, std::optional<int> ltc,
                                        const fs::path& folder, Progress* progress) {
  const Result<Copied> copied =
      run_confined_job<Copied>({.what = file.string(), .writable = {folder}, .memory = kMemory}, progress,
                               [&](Progress* told) { return Copying(file, name, ltc, folder).run(told); });
  if (!copied) return forward(copied);
  ForeignSound out;
  out.track = {.name = name,
               .rate = copied->rate,
               .channels = copied->channels,
               .bits = copied->bits,
               .from = file.filename().string()};
  // A child's word is a stranger's.
  if (Result<void> ok = capture::check(out.track); !ok)
    return fail(ErrorCode::BadData, text(file.string(), ": ", ok.error().message));
  if (!(copied->peak > kSilence))
    return fail(ErrorCode::BadData,
                text(file.string(), ": holds silence only, all ", copied->samples,
                     " samples of it; name another file, or another channel of time code"));
  out.samples = copied->samples;
  if (ltc)
    out.ltc = {
        .name = ltc_name(name), .rate = out.track.rate, .channels = 1, .bits = out.track.bits, .from = ""};
  if (!copied->since_midnight.empty() && std::isfinite(copied->since_midnight.front()))
    out.since_midnight = copied->since_midnight.front();
  if (std::abs(copied->first) < 1e6) out.first = copied->first;
  if (!copied->time_code.empty()) out.time_code = copied->time_code.front();
  for (const capture::SoundTrack* track : {&out.track, out.ltc ? &*out.ltc : nullptr})
    if (track)
      for (const std::string& made : {track->media(), track->side_file()})
        if (std::error_code error; !fs::is_regular_file(fs::symlink_status(folder / made, error)))
          return fail(ErrorCode::BadData, text(file.string(), ": what decodes it made no sound of it"));
  return out;
}

}  // namespace floatstage::pipeline
