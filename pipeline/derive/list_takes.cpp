#include "pipeline/derive/list_takes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/sound/sound_reader.h"
#include "capture/take_check.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

double seconds_of(const std::vector<FrameRow>& rows) {
  if (rows.size() < 2) return 0;
  return static_cast<double>((rows.back().info.exposure_start - rows.front().info.exposure_start).count) /
         1e9;
}

// The recorder's word, where it left one: "PASS", or "FAIL" and its first complaint.
std::string recorded_verdict(const TakeLayout& layout) {
  if (!is_there(layout.quality())) return "";
  const Result<std::string> bytes = read_file(layout.quality());
  if (!bytes) return bytes.error().message;
  const Result<nlohmann::json> j = parse_json(*bytes, layout.quality().string());
  if (!j) return j.error().message;
  if (!j->is_object() || !j->contains("verdict") || !(*j)["verdict"].is_string()) return "";
  std::string verdict = (*j)["verdict"].get<std::string>();
  if (verdict != "PASS" && j->contains("complaints") && (*j)["complaints"].is_array() &&
      !(*j)["complaints"].empty() && (*j)["complaints"][0].is_string())
    verdict += ": " + (*j)["complaints"][0].get<std::string>();
  return verdict;
}

ListedTake listed(const fs::path& folder) {
  ListedTake take;
  take.name = folder.filename().string();
  const Result<std::unique_ptr<capture::TakeReader>> reader = capture::TakeReader::open(folder);
  if (!reader) {
    take.verdict = text("does not open: ", reader.error().message);
    return take;
  }
  take.opens = true;
  take.manifest = (*reader)->manifest();
  take.facts = facts_of(**reader);
  const std::string said = recorded_verdict((*reader)->layout());
  take.verdict = !said.empty() && said != "PASS"  ? said
                 : !take.manifest.complete        ? "cut off"
                 : !(*reader)->warnings().empty() ? (*reader)->warnings().front()
                 : take.manifest.files.empty()    ? "not sealed"
                 : said.empty()                   ? "whole"
                                                  : said;
  return take;
}

}  // namespace

std::optional<Timestamp> begin_of(const capture::TakeReader& take) {
  std::optional<Timestamp> begins;
  for (int c = 0; c < static_cast<int>(take.rig().cameras.size()); ++c)
    if (const std::vector<FrameRow>& rows = take.rows(c); !rows.empty()) {
      const Timestamp first = rows.front().info.exposure_start;
      begins = begins ? std::min(*begins, first) : first;
    }
  return begins;
}

Result<std::vector<SoundFacts>> sounds_of(const capture::TakeReader& take) {
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take.layout());
  if (!tracks) return forward(tracks);
  const std::optional<Timestamp> begins = begin_of(take);
  std::vector<SoundFacts> out;
  for (const capture::SoundTrack& track : *tracks) {
    SoundFacts& facts = out.emplace_back();
    facts.track = track;
    const Result<std::unique_ptr<capture::SoundReader>> sound =
        capture::SoundReader::open(take.layout(), track);
    if (!sound) {
      facts.problem = sound.error().message;
      continue;
    }
    const capture::SoundClock& clock = (*sound)->clock();
    facts.seconds = static_cast<double>((*sound)->samples()) / track.rate;
    facts.runs = static_cast<int>(clock.runs().size());
    if (!(*sound)->warnings().empty()) facts.problem = (*sound)->warnings().front();
    if (clock.runs().empty()) continue;
    const auto longest =
        std::max_element(clock.runs().begin(), clock.runs().end(),
                         [](const auto& a, const auto& b) { return a.end - a.first < b.end - b.first; });
    constexpr double kSeen = 0.01;  // below is what rounding leaves
    facts.ppm = std::abs(longest->ppm) < kSeen ? 0 : longest->ppm;
    facts.jitter_ms = longest->jitter_ns * 1e-6;
    if (begins) facts.begins = seconds(clock.start_of(clock.runs().front()) - *begins);
  }
  return out;
}

TakeFacts facts_of(const capture::TakeReader& take) {
  TakeFacts facts;
  facts.frames = take.frame_count();
  facts.cameras = static_cast<int>(take.rig().cameras.size());
  facts.bytes = capture::recorded_bytes(take.layout().folder());
  for (int c = 0; c < facts.cameras; ++c) facts.seconds = std::max(facts.seconds, seconds_of(take.rows(c)));
  const auto within = [&](const std::vector<int>& frames) {
    return static_cast<int>(std::lower_bound(frames.begin(), frames.end(), facts.frames) - frames.begin());
  };
  facts.meshes = within(take.layout().frames_with_meshes());
  for (const RigCamera& camera : take.rig().cameras)
    facts.mattes += within(take.layout().frames_with_mattes(camera.serial));
  return facts;
}

Result<std::vector<ListedTake>> list_takes(const fs::path& folder) {
  std::vector<ListedTake> takes;
  if (is_there(TakeLayout(folder).manifest())) {
    takes.push_back(listed(fs::absolute(folder).lexically_normal()));
    takes.back().name = folder.string();
    return takes;
  }
  std::error_code error;
  std::vector<fs::path> folders;
  fs::directory_iterator entries(folder, error);
  if (error)
    return fail(error == std::errc::no_such_file_or_directory ? ErrorCode::NotFound : ErrorCode::Io,
                text("cannot list ", folder.string(), ": ", error.message()));
  for (const fs::directory_entry& entry : entries)
    if (!is_temporary(entry.path()) && is_there(TakeLayout(entry.path()).manifest()))
      folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& f : folders) takes.push_back(listed(f));
  return takes;
}

Result<Image> thumbnail(capture::TakeReader& take, int width) {
  const int frames = take.frame_count();
  for (int c = 0; c < static_cast<int>(take.rig().cameras.size()); ++c) {
    const Result<Frame> frame = take.frame(c, frames / 2);
    if (!frame) return forward(frame);
    if (frame->empty()) continue;
    const Result<Image> rgb = to_rgb(*frame);
    if (!rgb) return forward(rgb);
    const int factor = std::max(1, (rgb->width + width - 1) / width);
    Image small(std::max(1, rgb->width / factor), std::max(1, rgb->height / factor), 3);
    const int w = std::min(factor, rgb->width), h = std::min(factor, rgb->height);
    for (int y = 0; y < small.height; ++y)
      for (int x = 0; x < small.width; ++x)
        for (int channel = 0; channel < 3; ++channel) {
          int sum = 0;
          for (int j = 0; j < h; ++j)
            for (int i = 0; i < w; ++i) sum += rgb->at(x * factor + i, y * factor + j)[channel];
          small.at(x, y)[channel] = static_cast<std::uint8_t>((sum + w * h / 2) / (w * h));
        }
    return small;
  }
  return fail(ErrorCode::NotFound,
              text(take.layout().folder().string(), ": frame ", frames / 2, " has no picture"));
}

}  // namespace floatstage::pipeline
