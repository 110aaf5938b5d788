// docs/adr/0278-sound-of-another-recorder.md

#include "pipeline/derive/set_sound.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "capture/sound/sound_reader.h"
#include "capture/sound/time_code.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/derive/foreign_sound.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/derive/sound_claps.h"
#include "pipeline/onset_sync.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using capture::SoundStamp;

const OnsetMatch kClaps{
    .tolerance = 0.04, .separation = 0.08, .closure = 0, .event = "clap", .events = "claps"};
const OnsetMatch kFlashes{
    .tolerance = 0.07, .separation = 0.2, .closure = 0, .event = "flash", .events = "flashes"};
constexpr int kRounds = 8;                // of matching along a clock that the matches tell
constexpr std::int64_t kStampEvery = 10;  // s
constexpr std::size_t kMostStamps = 4000;

Timestamp at_seconds(double s) { return {std::llround(s * 1e9)}; }

/// The file's stem, of what a name may have.
std::string name_of(const fs::path& file) {
  std::string name;
  for (const char c : file.stem().string()) {
    const bool usable = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                        c == '_' || c == '-' || c == '.';
    if (usable)
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  return is_usable_serial(name) ? name : "recorder";
}

class Placing {
 public:
  Placing(const SetSoundOptions& options, capture::TakeReader& take, Timestamp begin,
          std::optional<capture::TimeCode> code)
      : options_(options), take_(take), begin_(begin), code_(std::move(code)) {}

  /// Before anything is decoded.
  Result<void> check() const {
    const bool coded = !std::holds_alternative<SoundAt>(options_.place) &&
                       !std::holds_alternative<SoundByClap>(options_.place);
    if (coded && !code_)
      return fail(ErrorCode::InvalidArgument,
                  text(folder(),
                       " has no time code to place sound by; give it one first (take set-time-code), or "
                       "place the sound by --at SECONDS or --clap"));
    if (const auto* at = std::get_if<SoundAtCode>(&options_.place))
      if (!capture::frames_of(at->code, code_->rate))
        return fail(ErrorCode::InvalidArgument,
                    text("'", at->code, "' is no time code of ", capture::name_of(code_->rate),
                         " frames a second; write hh:mm:ss:ff"));
    return {};
  }

  /// Samples of the foreign track with their times on the take's clock; one or more.
  Result<std::vector<SoundStamp>> stamps(const ForeignSound& sound, capture::SoundReader& track,
                                         const TakeLayout& staged, int& signs) {
    const auto first = [](Timestamp at) { return std::vector<SoundStamp>{{0, at, 0}}; };
    if (const auto* at = std::get_if<SoundAt>(&options_.place))
      return first(begin_ + Nanoseconds{at_seconds(at->seconds).ns});
    if (const auto* at = std::get_if<SoundAtCode>(&options_.place))
      return first(capture::time_of_code(*code_, *capture::frames_of(at->code, code_->rate)));
    if (const auto* at = std::get_if<SoundByClap>(&options_.place)) return by_claps(track, at->flash, signs);
    if (std::holds_alternative<SoundByStamp>(options_.place)) {
      const Result<Timestamp> at = by_stamp(sound);
      if (!at) return forward(at);
      return first(*at);
    }
    return by_ltc(sound, staged, signs);
  }

 private:
  std::string folder() const { return take_.layout().folder().string(); }
  std::string file() const { return options_.file.string(); }

  Result<Timestamp> by_stamp(const ForeignSound& sound) const {
    if (sound.since_midnight) {
      const auto frames = std::floor(*sound.since_midnight * code_->rate.hertz());
      const double within = *sound.since_midnight - frames / code_->rate.hertz();
      return capture::time_of_code(*code_, static_cast<std::int64_t>(frames)) +
             Nanoseconds{at_seconds(within).ns};
    }
    if (!sound.time_code)
      return fail(ErrorCode::NotFound,
                  text(file(),
                       ": does not say when it was recorded (no time_reference of a Broadcast Wave file, no "
                       "time code); place it by --at, --clap or --ltc"));
    const std::optional<std::int64_t> frames = capture::frames_of(*sound.time_code, code_->rate);
    if (!frames)
      return fail(ErrorCode::BadData, text(file(), ": its time code '", *sound.time_code, "' is none of ",
                                           capture::name_of(code_->rate),
                                           " frames a second as the take's; place it by --at or --clap"));
    return capture::time_of_code(*code_, *frames) + Nanoseconds{at_seconds(sound.first).ns};
  }

  Result<std::vector<SoundStamp>> by_ltc(const ForeignSound& sound, const TakeLayout& staged,
                                         int& signs) const {
    const Result<std::unique_ptr<capture::SoundReader>> ltc = capture::SoundReader::open(staged, *sound.ltc);
    if (!ltc) return forward(ltc);
    const Result<std::vector<SoundStamp>> all = capture::ltc_stamps(**ltc, 0, *code_);
    if (!all)
      return fail(all.error().code,
                  text(file(), ", channel ", std::get<SoundByLtc>(options_.place).channel, ": ",
                       all.error().message, "; name another channel, or place it by --clap"));
    signs = static_cast<int>(all->size());
    const std::size_t step = std::max<std::size_t>(1, all->size() / kMostStamps);
    std::vector<SoundStamp> some;
    for (std::size_t i = 0; i < all->size(); i += step) some.push_back((*all)[i]);
    return some;
  }

  /// Claps of the take's own sound, by the take's clock, in seconds after its first picture.
  Result<std::vector<Onset>> own_claps() {
    const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take_.layout());
    if (!tracks) return forward(tracks);
    if (tracks->empty())
      return fail(ErrorCode::InvalidArgument,
                  text(folder(),
                       " has no sound whose claps could be met; --clap flash looks for a flash in its "
                       "pictures"));
    const Result<std::unique_ptr<capture::SoundReader>> own =
        capture::SoundReader::open(take_.layout(), tracks->front());
    if (!own) return forward(own);
    const Result<std::vector<SoundClap>> claps = claps_in(**own, options_.progress);
    if (!claps) return forward(claps);
    std::vector<Onset> out;
    for (const SoundClap& clap : *claps)
      if (const std::optional<Timestamp> time = (*own)->clock().time_of(clap.sample))
        out.push_back({seconds(*time - begin_), clap.strength});
    if (out.empty())
      return fail(ErrorCode::NotFound,
                  text(folder(), ": there is no clap in its sound '", tracks->front().name,
                       "' (one comes out of a quarter of a second of quiet); place the other by "
                       "--clap flash, --at or time code"));
    return out;
  }

  /// Flashes in the pictures of its first camera.
  Result<std::vector<Onset>> own_flashes() {
    std::vector<double> brightness, times;
    const std::vector<FrameRow>& rows = take_.rows(0);
    ProgressPart part(options_.progress, "flashes", rows.size());
    for (std::size_t f = 0; f < rows.size(); ++f, part.advance()) {
      if (is_cancelled(options_.progress)) return cancelled();
      if (!rows[f].media_index) continue;
      const Result<Frame> frame = take_.frame(0, static_cast<int>(f));
      if (!frame) return forward(frame);
      if (frame->empty()) continue;
      const Result<Image> rgb = to_rgb(*frame);
      if (!rgb) return forward(rgb);
      brightness.push_back(
          static_cast<double>(std::accumulate(rgb->pixels.begin(), rgb->pixels.end(), std::uint64_t{0})) /
          static_cast<double>(std::max<std::size_t>(rgb->pixels.size(), 1)));
      times.push_back(seconds(rows[f].info.exposure_start - begin_));
    }
    std::vector<Onset> out = brightness_onsets(brightness, times);
    if (out.empty())
      return fail(ErrorCode::NotFound, text(folder(), ": there is no flash in the pictures of camera '",
                                            take_.rig().cameras.front().serial,
                                            "'; place the sound by --clap sound, --at or time code"));
    return out;
  }

  Result<std::vector<SoundStamp>> by_claps(capture::SoundReader& track, bool flash, int& signs) {
    const OnsetMatch& how = flash ? kFlashes : kClaps;
    const Result<std::vector<SoundClap>> claps = claps_in(track, options_.progress);
    if (!claps) return forward(claps);
    if (claps->empty())
      return fail(ErrorCode::NotFound,
                  text(file(),
                       ": there is no clap in it: a short sound out of a quarter of a second of quiet; place "
                       "it by --at or time code"));
    const Result<std::vector<Onset>> own = flash ? own_flashes() : own_claps();
    if (!own) return forward(own);
    const double rate = track.track().rate;
    std::vector<Onset> theirs;
    for (const SoundClap& c : *claps) theirs.push_back({static_cast<double>(c.sample) / rate, c.strength});
    const PairShift pair = pair_shift(*own, theirs, how);
    if (pair.is_ambiguous())
      return fail(
          ErrorCode::BadData,
          text(file(), ": could begin ", -pair.shift.seconds, " s or ", -pair.second_shift,
               " s after the first picture: its claps and the take's ", how.events,
               " are too few or too much alike. Cut it so that it holds one of them, or place it by --at"));
    // What met tells how fast its clock ran, and that which others are the same.
    std::vector<SoundStamp> stamps = stamps_of(pair.met, rate);
    for (int round = 0; round < kRounds; ++round) {
      const capture::SoundClock clock(stamps, track.track().rate, track.samples());
      std::vector<Onset> moved = theirs;
      for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i].seconds = seconds(*clock.time_of((*claps)[i].sample) - begin_);
      std::vector<SoundStamp> met = stamps_that_meet(*own, moved, *claps, how.tolerance);
      if (met.size() <= stamps.size()) break;
      stamps = std::move(met);
    }
    signs = static_cast<int>(stamps.size());
    return stamps;
  }

  std::vector<SoundStamp> stamps_of(const std::vector<std::pair<double, double>>& met, double rate) const {
    std::vector<SoundStamp> out;
    for (const auto& [own, theirs] : met)
      if (const std::int64_t sample = std::llround(theirs * rate); out.empty() || sample > out.back().sample)
        out.push_back({sample, begin_ + Nanoseconds{at_seconds(own).ns}, 0});
    return out;
  }

  // Each with the nearest of the take's; both trains are in order of time.
  std::vector<SoundStamp> stamps_that_meet(const std::vector<Onset>& own, const std::vector<Onset>& moved,
                                           const std::vector<SoundClap>& claps, double tolerance) const {
    std::vector<SoundStamp> out;
    std::size_t next = 0;
    for (std::size_t i = 0; i < moved.size() && next < own.size(); ++i) {
      while (next + 1 < own.size() && std::abs(own[next + 1].seconds - moved[i].seconds) <
                                          std::abs(own[next].seconds - moved[i].seconds))
        ++next;
      if (std::abs(own[next].seconds - moved[i].seconds) > tolerance) continue;
      out.push_back({claps[i].sample, begin_ + Nanoseconds{at_seconds(own[next].seconds).ns}, 0});
      ++next;
    }
    return out;
  }

  const SetSoundOptions& options_;
  capture::TakeReader& take_;
  const Timestamp begin_;
  const std::optional<capture::TimeCode> code_;
};

// The line that its samples lie on, as the side file has it: rows that any reader's fit returns it from.
std::string csv_of(const capture::SoundClock& clock, std::int64_t samples, int rate) {
  std::string csv = capture::sound_csv_header();
  for (std::int64_t at = 0; at < samples; at += kStampEvery * rate)
    csv += capture::to_csv({at, *clock.time_of(at), 0});
  if ((samples - 1) % (kStampEvery * rate) != 0)
    csv += capture::to_csv({samples - 1, *clock.time_of(samples - 1), 0});
  return csv;
}

double spread_of(const std::vector<SoundStamp>& stamps, const capture::SoundClock& clock) {
  std::vector<double> distances;
  for (const SoundStamp& s : stamps)
    distances.push_back(std::abs(seconds(*clock.time_of(s.sample) - s.time)));
  return median(std::move(distances));
}

/// A hidden folder beside the new take, in which the child that decodes writes: beside the take's own files
/// are links to the old one's.
class Staging {
 public:
  static Result<Staging> begin(const fs::path& out) {
    fs::path name = out.lexically_normal();
    if (!name.has_filename()) name = name.parent_path();
    name += ".sound";
    Result<Claim> claim = claim_temporary_folder(name, IfThere::Replace);
    if (!claim) return forward(claim);
    return Staging(temporary_name(name), std::move(*claim));
  }
  Staging(Staging&& other) noexcept
      : folder_(std::exchange(other.folder_, {})), claim_(std::move(other.claim_)) {}
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;
  Staging& operator=(Staging&&) = delete;
  ~Staging() {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
  }
  const fs::path& folder() const { return folder_; }

 private:
  Staging(fs::path folder, Claim claim) : folder_(std::move(folder)), claim_(std::move(claim)) {}

  fs::path folder_;
  Claim claim_;
};

std::optional<Timestamp> end_of(const capture::TakeReader& take) {
  std::optional<Timestamp> end;
  for (int c = 0; c < static_cast<int>(take.rig().cameras.size()); ++c)
    if (const std::vector<FrameRow>& rows = take.rows(c); !rows.empty()) {
      const Timestamp last = rows.back().info.exposure_start;
      end = end ? std::max(*end, last) : last;
    }
  return end;
}

}  // namespace

Result<SetSoundReport> set_sound(const SetSoundOptions& options) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  const std::optional<Timestamp> begin = begin_of(**take), end = end_of(**take);
  if (!begin)
    return fail(ErrorCode::InvalidArgument,
                text(options.take.string(), " has no picture that sound could be of"));
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks((*take)->layout());
  if (!tracks) return forward(tracks);
  const std::string name = options.name.empty() ? name_of(options.file) : options.name;
  if (!is_usable_serial(name))
    return fail(ErrorCode::InvalidArgument,
                text("'", name, "' is no name of a track: letters, digits, '.', '_' and '-' make one"));
  if (std::any_of(tracks->begin(), tracks->end(), [&](const auto& t) { return t.name == name; }) ||
      camera_index((*take)->rig(), name) >= 0)
    return fail(ErrorCode::InvalidArgument, text(options.take.string(), " has a track or a camera '", name,
                                                 "' already; choose another --name"));
  Result<std::optional<capture::TimeCode>> code = capture::load_time_code((*take)->layout());
  if (!code) return forward(code);
  Placing placing(options, **take, *begin, std::move(*code));
  if (Result<void> ok = placing.check(); !ok) return forward(ok);
  // Whether the new take can be there is said before an hour of sound is decoded.
  if (const Result<UnfinishedFolder> there = UnfinishedFolder::begin(options.out); !there)
    return forward(there);
  const Result<Staging> staging = Staging::begin(options.out);
  if (!staging) return forward(staging);
  const auto* by_ltc = std::get_if<SoundByLtc>(&options.place);
  const Result<ForeignSound> sound =
      copy_foreign_sound(options.file, name, by_ltc ? std::optional(by_ltc->channel) : std::nullopt,
                         staging->folder(), options.progress);
  if (!sound) return forward(sound);
  const TakeLayout staged(staging->folder());
  const Result<std::unique_ptr<capture::SoundReader>> track =
      capture::SoundReader::open(staged, sound->track);
  if (!track) return forward(track);
  const std::int64_t samples = (*track)->samples();
  SetSoundReport report;
  const Result<std::vector<SoundStamp>> stamps = placing.stamps(*sound, **track, staged, report.signs);
  if (!stamps) return forward(stamps);
  const capture::SoundClock clock(*stamps, sound->track.rate, samples);
  if (samples < 1 || clock.runs().empty())
    return fail(ErrorCode::BadData, text(options.file.string(), ": what decodes it made no sound of it"));
  report.track = sound->track;
  report.seconds = static_cast<double>(samples) / sound->track.rate;
  report.begins = seconds(*clock.time_of(0) - *begin);
  report.ppm = stamps->size() > 1 ? clock.runs().front().ppm : 0;
  report.spread = spread_of(*stamps, clock);
  const double length = seconds(*end - *begin);
  if (report.begins > length || report.begins + report.seconds < 0)
    return fail(ErrorCode::InvalidArgument,
                text(options.file.string(), ": would lie from ", report.begins, " to ",
                     report.begins + report.seconds, " s of a take that lasts from 0 to ", length,
                     " s: nothing of it is heard; place it otherwise"));
  if (Result<void> ok =
          write_file(staged.folder() / sound->track.side_file(), csv_of(clock, samples, sound->track.rate));
      !ok)
    return forward(ok);
  Result<DerivedReport> made = derive_take(**take,
                                           {.rig = std::nullopt,
                                            .how = text("set-sound ", options.file.filename().string()),
                                            .label = options.label,
                                            .sound = AddedSound{staged.folder(), sound->track}},
                                           options.out);
  if (!made) return forward(made);
  report.take = std::move(*made);
  return report;
}

}  // namespace floatstage::pipeline
