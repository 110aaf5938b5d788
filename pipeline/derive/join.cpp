#include "pipeline/derive/join.h"

#include <algorithm>
#include <cmath>

#include "capture/derivation.h"
#include "capture/sound/time_code.h"
#include "capture/take.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/derive/carried_files.h"
#include "pipeline/derive/join_sound.h"
#include "pipeline/recorded_take.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using Readers = std::vector<std::unique_ptr<capture::TakeReader>>;

Unexpected differ(const capture::TakeReader& a, const capture::TakeReader& b, const std::string& what) {
  return fail(ErrorCode::InvalidArgument, text(b.layout().folder().string(), " cannot follow ",
                                               a.layout().folder().string(), ": ", what));
}

Result<void> fit(const capture::TakeReader& a, const capture::TakeReader& b) {
  const auto &ours = a.manifest().cameras, &theirs = b.manifest().cameras;
  if (ours.size() != theirs.size())
    return differ(a, b, text("it has ", theirs.size(), " cameras, not ", ours.size()));
  for (std::size_t c = 0; c < ours.size(); ++c)
    if (ours[c].serial != theirs[c].serial || ours[c].format != theirs[c].format ||
        ours[c].width != theirs[c].width || ours[c].height != theirs[c].height)
      return differ(a, b,
                    text("camera '", theirs[c].serial, "' is not camera '", ours[c].serial,
                         "' with pictures of the same size and format"));
  if (to_json(a.rig()) != to_json(b.rig()))
    return differ(a, b, "they have different rigs; give both one with `floatstage take set-rig`");
  constexpr double kSameRate = 1e-3;
  if (std::abs(a.manifest().frame_rate - b.manifest().frame_rate) > kSameRate * a.manifest().frame_rate)
    return differ(
        a, b, text("it has ", b.manifest().frame_rate, " frames a second, not ", a.manifest().frame_rate));
  return {};
}

// From where to where a take goes, and by how much its times move.
struct Stretch {
  Nanoseconds shift{0};
  std::uint64_t first_row = 0;
};

// Its first exposure and its last one.
std::pair<std::optional<Timestamp>, std::optional<Timestamp>> span_of(const capture::TakeReader& take) {
  std::optional<Timestamp> first, last;
  for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
    const std::vector<FrameRow>& rows = take.rows(static_cast<int>(c));
    if (rows.empty()) continue;
    const Timestamp a = rows.front().info.exposure_start, b = rows.back().info.exposure_start;
    first = first ? std::min(*first, a) : a;
    last = last ? std::max(*last, b) : b;
  }
  return {first, last};
}

std::vector<Stretch> stretches(const Readers& takes, Nanoseconds period, std::vector<std::string>& notes) {
  std::vector<Stretch> out;
  std::uint64_t row = 0;
  std::optional<Timestamp> ended;
  for (const auto& take : takes) {
    const auto [first, last] = span_of(*take);
    Stretch s{{0}, row};
    if (ended && first && *first < *ended + period) {
      s.shift = (*ended + period) - *first;
      notes.push_back(text(take->layout().folder().string(),
                           " began before the one before it ended: it now begins one frame later"));
    }
    if (last) ended = *last + s.shift;
    row += static_cast<std::uint64_t>(take->frame_count());
    out.push_back(s);
  }
  return out;
}

// One camera of all takes. Rows that a camera lacks at a take's end become gaps, so that instants stay
// together.
Result<void> copy_camera(const Readers& takes, const std::vector<Stretch>& stretches, Nanoseconds period,
                         int camera, capture::TakeWriter& writer, ProgressPart& progress,
                         const Progress* watch) {
  for (std::size_t t = 0; t < takes.size(); ++t) {
    Timestamp time{};
    const int rows = static_cast<int>(takes[t]->rows(camera).size());
    for (int f = 0; f < takes[t]->frame_count(); ++f) {
      if (is_cancelled(watch)) return cancelled();
      Frame frame;
      if (f < rows) {
        Result<Frame> read = takes[t]->frame(camera, f);
        if (!read) return forward(read);
        frame = std::move(*read);
        frame.info.exposure_start = frame.info.exposure_start + stretches[t].shift;
      } else {
        frame.info.exposure_start = time + period;
      }
      time = frame.info.exposure_start;
      frame.info.camera = camera;
      frame.info.sequence = stretches[t].first_row + static_cast<std::uint64_t>(f);
      if (frame.empty()) frame.info.status = FrameStatus::Lost;
      if (Result<void> ok = writer.write(frame); !ok) return ok;
      progress.advance();
    }
  }
  return {};
}

}  // namespace

Result<JoinReport> join_takes(const std::vector<fs::path>& folders, const fs::path& out, Progress* progress) {
  if (folders.size() < 2)
    return fail(ErrorCode::InvalidArgument, "name two takes or more, in the order in which they follow");
  Readers takes;
  std::string from;
  for (const fs::path& folder : folders) {
    Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder);
    if (!take) return forward(take);
    takes.push_back(std::move(*take));
    if (Result<void> ok = fit(*takes.front(), *takes.back()); !ok) return forward(ok);
    from += text(from.empty() ? "" : ", ", folder.string());
  }
  const TakeManifest& first = takes.front()->manifest();
  JoinReport report;
  const double rate = first.frame_rate > 0 ? first.frame_rate : 25;
  const Nanoseconds period{std::llround(1e9 / rate)};
  const std::vector<Stretch> moved = stretches(takes, period, report.notes);
  capture::TakeWriterOptions options;
  options.codec = lossless_codec(takes, report.notes);
  options.frame_rate = rate;
  options.label = first.label;
  options.created = first.created;
  options.is_claimed = true;
  Result<UnfinishedFolder> take = UnfinishedFolder::begin(out);
  if (!take) return forward(take);
  Result<std::unique_ptr<capture::TakeWriter>> writer =
      capture::TakeWriter::create(take->folder(), takes.front()->rig(), options);
  if (!writer) return forward(writer);
  for (const auto& t : takes) report.frames += t->frame_count();
  const std::size_t cameras = first.cameras.size();
  ProgressPart part(progress, "join", cameras * static_cast<std::size_t>(report.frames));
  std::vector<Result<void>> done(cameras);
  parallel_for(cameras, 0, [&](std::size_t c) {
    done[c] = copy_camera(takes, moved, period, static_cast<int>(c), **writer, part, progress);
  });
  for (const Result<void>& of : done)
    if (!of) return forward(of);
  std::vector<SoundPart> sounds;
  for (std::size_t t = 0; t < takes.size(); ++t)
    if (const auto& [first_shown, last_shown] = span_of(*takes[t]); first_shown && last_shown)
      sounds.push_back({takes[t].get(), *first_shown, *last_shown + period, moved[t].shift});
  if (Result<void> ok = join_sound(sounds, TakeLayout(take->folder()), report.notes, progress); !ok)
    return forward(ok);
  for (const auto& t : takes)
    if (is_there(capture::time_code_file(t->layout())))
      report.notes.push_back(text("the time code of ", t->layout().folder().string(),
                                  " is left out: a joined take has no code that runs through"));
  if (Result<void> ok = (*writer)->finish(); !ok) return forward(ok);
  if (Result<void> ok = seal_take(take->folder(), progress); !ok) return forward(ok);
  if (Result<void> ok = capture::save_derivation({from, "join"}, take->folder()); !ok) return forward(ok);
  if (Result<void> ok = take->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
