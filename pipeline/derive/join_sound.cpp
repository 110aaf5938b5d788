#include "pipeline/derive/join_sound.h"

#include <algorithm>
#include <cmath>

#include "capture/sound/sound_reader.h"
#include "capture/sound/sound_writer.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using capture::SoundRun;
using capture::SoundTrack;

constexpr std::int64_t kStampSeconds = 10;

// A part's samples of one run, with the times of its line.
Result<void> copy_run(capture::SoundReader& from, const SoundRun& run, const SoundPart& part,
                      capture::SoundWriter& to, const Progress* watch) {
  const capture::SoundClock& clock = from.clock();
  const auto inside = [&](double sample) {
    return static_cast<std::int64_t>(
        std::clamp(std::ceil(sample), static_cast<double>(run.first), static_cast<double>(run.end)));
  };
  const std::int64_t first = inside(clock.sample_at(run, part.first)),
                     end = inside(clock.sample_at(run, part.end));
  const std::int64_t step = kStampSeconds * from.track().rate;
  std::vector<float> samples;
  for (std::int64_t at = first; at < end; at += step) {
    if (is_cancelled(watch)) return cancelled();
    const std::int64_t count = std::min(step, end - at);
    const Timestamp time = *clock.time_of(at) + part.shift;
    if (Result<void> ok = to.stamp(to.samples(), time, at == first && to.samples() > 0); !ok) return ok;
    if (count > 1 && at + count == end)
      if (Result<void> ok = to.stamp(to.samples() + count - 1, *clock.time_of(end - 1) + part.shift); !ok)
        return ok;
    samples.resize(static_cast<std::size_t>(count * from.track().channels));
    if (Result<void> ok = from.read(at, samples); !ok) return ok;
    if (Result<void> ok = to.write(samples); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<void> join_sound(const std::vector<SoundPart>& parts, const TakeLayout& out,
                        std::vector<std::string>& notes, Progress* progress) {
  std::vector<std::vector<SoundTrack>> of_parts;
  std::vector<SoundTrack> joined;
  for (const SoundPart& part : parts) {
    Result<std::vector<SoundTrack>> tracks = capture::load_sound_tracks(part.take->layout());
    if (!tracks) return forward(tracks);
    for (const SoundTrack& track : *tracks) {
      const auto known = std::find_if(joined.begin(), joined.end(),
                                      [&](const SoundTrack& t) { return t.name == track.name; });
      if (known == joined.end())
        joined.push_back(track);
      else
        known->bits = std::max(known->bits, track.bits);
    }
    of_parts.push_back(std::move(*tracks));
  }
  if (joined.empty()) return {};
  if (Result<void> ok = capture::save_sound_tracks(joined, out); !ok) return ok;
  ProgressPart progressing(progress, "sound", joined.size());
  for (const SoundTrack& track : joined) {
    const Result<std::unique_ptr<capture::SoundWriter>> writer = capture::SoundWriter::create(out, track);
    if (!writer) return forward(writer);
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (const SoundTrack& own : of_parts[p]) {
        if (own.name != track.name) continue;
        if (own.rate != track.rate || own.channels != track.channels) {
          notes.push_back(text("sound '", own.name, "' of ", parts[p].take->layout().folder().string(),
                               " is left out: it has another rate or other channels than that before it"));
          continue;
        }
        const Result<std::unique_ptr<capture::SoundReader>> reader =
            capture::SoundReader::open(parts[p].take->layout(), own);
        if (!reader) return forward(reader);
        for (const SoundRun& run : (*reader)->clock().runs())
          if (Result<void> ok = copy_run(**reader, run, parts[p], **writer, progress); !ok) return ok;
      }
    if (Result<void> ok = (*writer)->finish(); !ok) return ok;
    progressing.advance();
  }
  return {};
}

}  // namespace floatstage::pipeline
