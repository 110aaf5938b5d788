#include "apps/matte/matte_clip.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/matte/label_words.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/matte/matte_clip.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json to_json(const pipeline::MatteClipReport& report) {
  json labels = json::object();
  for (const pipeline::ClipLabel& l : report.labels)
    labels[l.name] = {{"keyframes", l.keyframes},
                      {"strokes", l.strokes},
                      {"subject", l.subject},
                      {"jump", l.jump},
                      {"jumps_at", l.jumps_at < 0 ? json() : json(l.jumps_at)},
                      {"first_absent", l.first_absent < 0 ? json() : json(l.first_absent)},
                      {"border", l.border},
                      {"lost", l.lost ? json(l.lost->share) : json()},
                      {"lost_at", l.lost ? json(l.lost->end) : json()},
                      {"unfound", l.lost ? json(l.lost->jump) : json()},
                      {"unfound_at", l.lost ? json(l.lost->jumps_at) : json()}};
  return {{"frames", report.frames}, {"width", report.width}, {"height", report.height},  {"labels", labels},
          {"doubts", report.doubts}, {"idle", report.idle},   {"seconds", report.seconds}};
}

Result<std::vector<pipeline::ClipGuide>> guides_of(const fs::path& guide, const ClipFlags& flags) {
  std::vector<pipeline::ClipGuide> guides;
  if (!guide.empty()) guides.push_back({"subject", guide});
  const Result<std::vector<NamedPath>> named = named_paths(flags.labels);
  if (!named) return forward(named);
  for (const NamedPath& n : *named) guides.push_back({n.name, n.path});
  return guides;
}

}  // namespace

void add_clip_flags(CLI::App& verb, ClipFlags& clip) {
  verb.add_option(
          "--label", clip.labels,
          "A subject and its masks; may be given again. Of a clip: a PNG of the first frame or a folder "
          "of PNGs; of a take: a folder of <serial>/<frame>.png, of a few cameras and frames")
      ->type_name("NAME=PATH");
  verb.add_option("--label-click", clip.clicks,
                  "A subject and a place on it, in pixels of a photograph; may be given again, and adds to "
                  "strokes that name a subject. Of a clip: NAME@FRAME:X,Y")
      ->type_name("NAME@SERIAL:FRAME:X,Y");
  verb.add_option("--edits", clip.edits,
                  "Of a clip: strokes that correct its labels, in a file as mattes/edits.json of a take, of "
                  "one camera")
      ->type_name("FILE");
  add_out(verb, clip.out, "Of a clip: a new folder for <label>/<frame>.png");
}

Result<bool> is_clip(const fs::path& media, const fs::path& guide, const ClipFlags& flags) {
  std::error_code error;
  const bool take = fs::exists(TakeLayout(media).manifest(), error),
             asked =
                 !flags.out.empty() || !flags.labels.empty() || !flags.clicks.empty() || !flags.edits.empty();
  if (take && !flags.out.empty())
    return fail(ErrorCode::InvalidArgument,
                text(media.string(),
                     " is a take, whose mattes lie in it; --out is for a video or a folder of "
                     "pictures"));
  if (take && !flags.edits.empty())
    return fail(ErrorCode::InvalidArgument,
                text(media.string(), " is a take, whose strokes lie in ", TakeLayout(media).edits().string(),
                     "; --edits is for a video or a folder of pictures"));
  const bool clip =
      !take && (asked || fs::is_regular_file(media, error) || fs::is_regular_file(guide, error));
  if (clip && flags.out.empty())
    return fail(ErrorCode::InvalidArgument,
                text("say where the mattes of ", media.string(), " go: --out FOLDER"));
  return clip;
}

Result<void> matte_clip(const fs::path& media, const fs::path& guide, const ClipFlags& flags,
                        const fs::path& json_file) {
  Result<std::vector<pipeline::ClipGuide>> guides = guides_of(guide, flags);
  if (!guides) return forward(guides);
  Result<std::vector<pipeline::ClipClick>> clicks = clip_clicks(flags.clicks);
  if (!clicks) return forward(clicks);
  ProgressBar bar;
  Result<pipeline::MatteClipReport> report = pipeline::matte_clip({.media = media,
                                                                   .guides = std::move(*guides),
                                                                   .edits = flags.edits,
                                                                   .clicks = std::move(*clicks),
                                                                   .out = flags.out,
                                                                   .progress = &bar});
  if (!report) return forward(report);
  for (const pipeline::ClipLabel& l : report->labels)
    std::printf(
        "%s: %d frames from %d and %d strokes; %.1f %% of the picture, area changes by at most %.0f %%\n",
        l.name.c_str(), report->frames, l.keyframes, l.strokes, 100 * l.subject, 100 * l.jump);
  std::printf("%s: %d frames in %.1f s\n", flags.out.c_str(), report->frames, report->seconds);
  for (const std::string& i : report->idle) std::fprintf(stderr, "floatstage: %s\n", i.c_str());
  for (const std::string& d : report->doubts) std::fprintf(stderr, "floatstage: %s\n", d.c_str());
  if (!json_file.empty())
    if (Result<void> ok = pipeline::save_json(to_json(*report), json_file); !ok) return ok;
  if (!report->doubts.empty())
    return fail(ErrorCode::BadData,
                text(report->doubts.size(), " of ", report->labels.size(),
                     " labels cannot be trusted; the mattes are in ", flags.out.string()));
  return {};
}

}  // namespace floatstage::apps
