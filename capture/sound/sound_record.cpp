#include "capture/sound/sound_record.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <set>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr std::string_view kHeader = "sample,studio_time_ns,run\n";
// Sums and differences of times stay numbers: 73 years either way.
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 4;
constexpr std::int64_t kMostSamples = std::int64_t{1} << 40;

SoundTrack read_track(const nlohmann::json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  SoundTrack track;
  track.name = fields.string("name");
  track.rate = fields.integer("rate");
  track.channels = fields.integer("channels");
  track.bits = fields.integer("bits");
  track.from = fields.string("from");
  fields.refuse_others();
  if (const Result<void> ok = check(track); !ok) problem.note(where, ok.error().message);
  return track;
}

// What is wrong with a line, or nothing.
std::optional<std::string> read_row(std::string_view line, SoundStamp& stamp) {
  const std::array<std::pair<std::int64_t*, const char*>, 2> numbers = {
      {{&stamp.sample, "the sample"}, {&stamp.time.ns, "the time"}}};
  const char *at = line.data(), *const end = line.data() + line.size();
  for (const auto& [value, what] : numbers) {
    const auto [next, error] = std::from_chars(at, end, *value);
    if (error != std::errc() || next == end || *next != ',') return text(what, " is not a whole number");
    at = next + 1;
  }
  const auto [next, error] = std::from_chars(at, end, stamp.run);
  if (error != std::errc() || next != end) return "the run is not a whole number";
  if (stamp.sample < 0 || stamp.sample > kMostSamples) return "no recording has such a sample";
  if (stamp.time.ns > kLatest || stamp.time.ns < -kLatest) return "no clock shows such a time";
  return std::nullopt;
}

std::optional<std::string> order_fault(const std::vector<SoundStamp>& before, const SoundStamp& stamp) {
  if (before.empty())
    return stamp.run == 0 ? std::nullopt : std::optional<std::string>("the first run is not 0");
  const SoundStamp& last = before.back();
  if (stamp.sample <= last.sample) return "its sample does not follow the one before";
  if (stamp.run != last.run && stamp.run != last.run + 1) return "its run does not follow the one before";
  if (stamp.run == last.run && stamp.time <= last.time) return "its time does not follow the one before";
  return std::nullopt;
}

}  // namespace

Result<void> check(const SoundTrack& t) {
  auto refuse = [&](const auto&... what) {
    return fail(ErrorCode::InvalidArgument, text("sound '", t.name, "': ", what...));
  };
  if (!is_usable_serial(t.name)) return refuse("letters, digits, '.', '_' and '-' make a name");
  if (t.rate < kLowestSoundRate || t.rate > kHighestSoundRate)
    return refuse(t.rate, " samples a second; a take holds ", kLowestSoundRate, " to ", kHighestSoundRate);
  if (t.channels < 1 || t.channels > kMostSoundChannels)
    return refuse(t.channels, " channels; a take holds 1 to ", kMostSoundChannels);
  if (t.bits != 16 && t.bits != 24) return refuse("samples of ", t.bits, " bits; a take holds 16 or 24");
  return {};
}

Result<std::vector<SoundTrack>> parse_sound_tracks(std::string_view json, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(json, name);
  if (!document) return forward(document);
  JsonProblem problem;
  const std::string where(name);
  JsonFields fields(*document, where, problem);
  const int version = fields.integer("floatstage_sound");
  if (!problem.first && version != 1)
    return fail(ErrorCode::Unsupported, text(name, ": format ", version, " of sound is not known; 1 is"));
  std::vector<SoundTrack> tracks;
  std::set<std::string> names;
  if (const nlohmann::json* list = fields.list("tracks"))
    for (const nlohmann::json& track : *list) {
      tracks.push_back(read_track(track, text(name, ": track ", tracks.size()), problem));
      if (!names.insert(tracks.back().name).second)
        problem.note(where, text("track '", tracks.back().name, "' is listed twice"));
    }
  fields.refuse_others();
  if (!problem.first && tracks.empty()) problem.note(where, "the list of tracks is empty");
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return tracks;
}

std::string to_json(const std::vector<SoundTrack>& tracks) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SoundTrack& t : tracks)
    list.push_back(
        {{"name", t.name}, {"rate", t.rate}, {"channels", t.channels}, {"bits", t.bits}, {"from", t.from}});
  return print_json({{"floatstage_sound", 1}, {"tracks", std::move(list)}});
}

std::filesystem::path sound_file(const TakeLayout& take) { return take.folder() / "sound.json"; }

Result<std::vector<SoundTrack>> load_sound_tracks(const TakeLayout& take) {
  const std::filesystem::path file = sound_file(take);
  if (!is_there(file)) return std::vector<SoundTrack>();
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_sound_tracks(*bytes, file.string());
}

Result<void> save_sound_tracks(const std::vector<SoundTrack>& tracks, const TakeLayout& take) {
  return write_file(sound_file(take), to_json(tracks));
}

Result<SoundTrack> sound_track_named(const std::vector<SoundTrack>& tracks, const std::string& name) {
  std::string known;
  for (const SoundTrack& track : tracks) {
    if (name.empty() || track.name == name) return track;
    known += text(known.empty() ? "" : ", ", track.name);
  }
  return fail(ErrorCode::NotFound, known.empty()
                                       ? "the take has no sound"
                                       : text("the take has no sound '", name, "'; it has ", known));
}

std::string sound_csv_header() { return std::string(kHeader); }

std::string to_csv(const SoundStamp& stamp) {
  return text(stamp.sample, ',', stamp.time.ns, ',', stamp.run, '\n');
}

Result<std::vector<SoundStamp>> parse_sound_csv(std::string_view csv, std::string_view name) {
  std::vector<SoundStamp> stamps;
  // The recorder may have been killed before the header was out.
  if (csv.size() < kHeader.size() && kHeader.starts_with(csv)) return stamps;
  if (!csv.starts_with(kHeader))
    return fail(ErrorCode::BadData, text(name, ": line 1: not the header of a sound.csv (",
                                         kHeader.substr(0, kHeader.size() - 1), ")"));
  csv.remove_prefix(kHeader.size());
  for (std::size_t line = 2;; ++line) {
    const std::size_t end = csv.find('\n');
    if (end == std::string_view::npos) return stamps;  // the end, or a line cut off mid-write
    SoundStamp stamp;
    std::optional<std::string> wrong = read_row(csv.substr(0, end), stamp);
    if (!wrong) wrong = order_fault(stamps, stamp);
    if (wrong)
      return fail(ErrorCode::BadData,
                  text(name, ": line ", line, ": ", *wrong, "; the sound's times were damaged or edited"));
    stamps.push_back(stamp);
    csv.remove_prefix(end + 1);
  }
}

}  // namespace floatstage::capture
