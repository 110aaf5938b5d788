#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/text_options.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/stills/detailed_take.h"

namespace floatstage::apps {
namespace {

struct TakeAddDetailArguments {
  pipeline::DetailedTakeOptions detail;
  std::string frame;
  std::filesystem::path json;
};

double percent(double share) { return std::round(1000 * share) / 10; }

std::string sentence(const pipeline::StillInPhoto& still) {
  const std::string how = text(still.direct ? "found here" : "carried over by the hull", ", ",
                               std::round(10 * still.zoom) / 10, " x");
  return still.why_not.empty() ? text(how, ", ", percent(still.used), " % of the subject, bent by ",
                                      std::round(100 * still.moved) / 100, " px")
                               : text(how, ", not used: ", still.why_not);
}

// The instant that is meant: the only one, or the one that is named.
Result<int> instant_of(const TakeAddDetailArguments& given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.detail.take);
  if (!take) return forward(take);
  if (given.frame.empty() && (*take)->frame_count() == 1) return 0;
  if (given.frame.empty())
    return fail(ErrorCode::InvalidArgument,
                text(given.detail.take.string(), " has ", (*take)->frame_count(),
                     " frames; name the one that the stills show with --frames N"));
  const Result<std::vector<int>> frames = parse_frames(given.frame, (*take)->frame_count());
  if (!frames) return forward(frames);
  if (frames->size() != 1)
    return fail(ErrorCode::InvalidArgument,
                text("--frames ", given.frame, ": stills show one instant; name one frame"));
  return frames->front();
}

nlohmann::json to_json(const TakeAddDetailArguments& given, int frame,
                       const pipeline::DetailedTakeReport& report) {
  nlohmann::json cameras = nlohmann::json::array(), refused = nlohmann::json::array();
  for (const pipeline::DetailedCamera& c : report.cameras) {
    nlohmann::json stills = nlohmann::json::array();
    for (const pipeline::StillInPhoto& s : c.stills)
      stills.push_back({{"still", s.still},
                        {"direct", s.direct},
                        {"zoom", s.zoom},
                        {"used", s.used},
                        {"moved", s.moved},
                        {"why_not", s.why_not}});
    cameras.push_back({{"serial", c.serial}, {"zoom", c.zoom}, {"stills", stills}});
  }
  for (const pipeline::RefusedStill& r : report.refused)
    refused.push_back({{"still", r.name}, {"why", r.why}});
  return {{"take", given.detail.out.string()},
          {"from", given.detail.take.string()},
          {"frame", frame},
          {"cameras", cameras},
          {"refused", refused},
          {"notes", report.notes}};
}

Result<void> run_take_add_detail(const TakeAddDetailArguments& given) {
  pipeline::DetailedTakeOptions options = given.detail;
  const Result<int> frame = instant_of(given);
  if (!frame) return forward(frame);
  options.frame = *frame;
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::DetailedTakeReport> report = pipeline::add_detail(options);
  if (!report) return forward(report);
  for (const std::string& note : report->notes) log::info(note);
  for (const pipeline::RefusedStill& r : report->refused) log::warning(text(r.name, " is not used: ", r.why));
  int detailed = 0;
  for (const pipeline::DetailedCamera& c : report->cameras) {
    detailed += c.zoom > 1 ? 1 : 0;
    for (const pipeline::StillInPhoto& s : c.stills)
      std::printf("  %-16s %-24s %s\n", c.serial.c_str(), s.still.c_str(), sentence(s).c_str());
  }
  std::printf("%s: frame %d, %d of %zu cameras' photographs have details\n", options.out.c_str(), *frame,
              detailed, report->cameras.size());
  return given.json.empty() ? Result<void>()
                            : pipeline::save_json(to_json(given, *frame, *report), given.json);
}

}  // namespace

void add_take_add_detail(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeAddDetailArguments>();
  CLI::App* verb = add_verb(take, chosen, "add-detail",
                            "One instant whose photographs have the details of close stills, as a new take",
                            {"floatstage take add-detail T --stills stills/ --frames 12 -o close",
                             "floatstage take add-detail T --stills stills/ -o origins --paint-provenance"});
  add_take(*verb, options->detail.take);
  verb->add_option("--stills", options->detail.stills,
                   "A folder of close photographs of the performer at that instant: face, hands, a print")
      ->required()
      ->type_name("FOLDER");
  add_frames(*verb, options->frame, "the only one");
  add_out(*verb, options->detail.out, "The new take's folder")->required();
  verb->add_option(
          "--zoom", options->detail.zoom,
          "How many times photographs with details are enlarged (default: as the closest still, at most 4)")
      ->type_name("N")
      ->check(CLI::Range(1, 16));
  verb->add_flag(
      "--paint-provenance", options->detail.paint_provenance,
      "Paint pictures by where they come from: blue stills, green stills by way of the hull, grey the "
      "photograph alone");
  verb->add_option("--label", options->detail.label, "The new take's label (default: as it was)");
  add_threads(*verb, options->detail.threads);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_add_detail(*options); }; });
}

}  // namespace floatstage::apps
