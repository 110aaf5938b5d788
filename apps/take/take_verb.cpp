#include <cstdio>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "capture/derivation.h"
#include "capture/sound/time_code.h"
#include "capture/take.h"
#include "core/text.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/json_report.h"
#include "pipeline/recorded_take.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct TakeArguments {
  fs::path take, json;
};

int lost_rows(const std::vector<FrameRow>& rows) {
  int lost = 0;
  for (const FrameRow& row : rows) lost += row.media_index ? 0 : 1;
  return lost;
}

// One line a sound track; and what of it stands in the report.
json say(const std::vector<pipeline::SoundFacts>& sounds) {
  json list = json::array();
  for (const pipeline::SoundFacts& s : sounds) {
    std::printf("  sound %-10s %d x %d Hz, %d bits, %.1f s from %+.3f s on, clock %+.1f ppm%s, from %s%s%s\n",
                s.track.name.c_str(), s.track.channels, s.track.rate, s.track.bits, s.seconds, s.begins,
                s.ppm, s.runs > 1 ? text(" (", s.runs, " runs)").c_str() : "", s.track.from.c_str(),
                s.problem.empty() ? "" : "; ", s.problem.c_str());
    list.push_back({{"name", s.track.name},
                    {"rate", s.track.rate},
                    {"channels", s.track.channels},
                    {"bits", s.track.bits},
                    {"from", s.track.from},
                    {"seconds", s.seconds},
                    {"begins", s.begins},
                    {"ppm", s.ppm},
                    {"jitter_ms", s.jitter_ms},
                    {"runs", s.runs},
                    {"problem", s.problem}});
  }
  return list;
}

Result<void> info(const TakeArguments& given) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(given.take);
  if (!opened) return forward(opened);
  const capture::TakeReader& take = **opened;
  const TakeManifest& m = take.manifest();
  const pipeline::TakeFacts facts = pipeline::facts_of(take);
  json cameras = json::array();
  for (std::size_t c = 0; c < m.cameras.size(); ++c) {
    const std::vector<FrameRow>& rows = take.rows(static_cast<int>(c));
    cameras.push_back({{"serial", m.cameras[c].serial},
                       {"codec", m.cameras[c].codec},
                       {"format", name_of(m.cameras[c].format)},
                       {"size", {m.cameras[c].width, m.cameras[c].height}},
                       {"rows", rows.size()},
                       {"lost", lost_rows(rows)}});
  }
  std::printf("%s: %d frames of %zu cameras at %g Hz, %.1f s, %.1f MB; %s, %s\n", given.take.c_str(),
              take.frame_count(), m.cameras.size(), m.frame_rate, facts.seconds,
              static_cast<double>(facts.bytes) / 1e6, m.complete ? "complete" : "cut off",
              m.files.empty() ? "not sealed" : "sealed");
  std::printf("recorded %s by %s%s%s\n", m.created.c_str(), m.writer.c_str(), m.label.empty() ? "" : ": ",
              m.label.c_str());
  for (const json& c : cameras)
    std::printf("  %-16s %dx%d %s %s, %d rows, %d lost\n", c["serial"].get<std::string>().c_str(),
                c["size"][0].get<int>(), c["size"][1].get<int>(), c["format"].get<std::string>().c_str(),
                c["codec"].get<std::string>().c_str(), c["rows"].get<int>(), c["lost"].get<int>());
  const Result<std::vector<pipeline::SoundFacts>> sounds = pipeline::sounds_of(take);
  if (!sounds) return forward(sounds);
  const json sound = say(*sounds);
  const Result<std::optional<capture::TimeCode>> code = capture::load_time_code(take.layout());
  if (!code) return forward(code);
  const std::optional<Timestamp> begin = pipeline::begin_of(take);
  const std::string begins = *code && begin ? (*code)->code_at(*begin) : "";
  if (!begins.empty())
    std::printf("time code: begins at %s, %s frames a second, from %s\n", begins.c_str(),
                capture::name_of((*code)->rate).c_str(), (*code)->from.c_str());
  const Result<std::optional<capture::Derivation>> from = capture::load_derivation(given.take);
  if (!from) return forward(from);
  if (*from) std::printf("made from %s by %s\n", (*from)->from.c_str(), (*from)->how.c_str());
  std::printf("derived: %d mattes, %d meshes\n", facts.mattes, facts.meshes);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", given.take.string()},
                              {"label", m.label},
                              {"created", m.created},
                              {"writer", m.writer},
                              {"frame_rate", m.frame_rate},
                              {"frames", take.frame_count()},
                              {"seconds", facts.seconds},
                              {"bytes", facts.bytes},
                              {"complete", m.complete},
                              {"sealed", !m.files.empty()},
                              {"cameras", std::move(cameras)},
                              {"sound", sound},
                              {"time_code", begins},
                              {"derived", {{"mattes", facts.mattes}, {"meshes", facts.meshes}}},
                              {"warnings", take.warnings()}},
                             given.json);
}

Result<void> verify(const TakeArguments& given) {
  ProgressBar progress;
  const Result<capture::TakeCheck> check = pipeline::check_take(given.take, &progress);
  if (!check) return forward(check);
  for (const std::string& remark : check->remarks) std::printf("%s\n", remark.c_str());
  for (const std::string& problem : check->problems) std::printf("DAMAGED: %s\n", problem.c_str());
  if (!given.json.empty()) {
    const json report = {{"take", given.take.string()}, {"sealed", check->sealed},
                         {"files", check->files},       {"bytes", check->bytes},
                         {"pictures", check->pictures}, {"intact", check->problems.empty()},
                         {"problems", check->problems}, {"remarks", check->remarks}};
    if (Result<void> ok = pipeline::save_json(report, given.json); !ok) return ok;
  }
  if (!check->problems.empty())
    return fail(ErrorCode::BadData,
                text(given.take.string(), " is not as it was recorded: ", check->problems.size(),
                     check->problems.size() == 1 ? " complaint" : " complaints",
                     ", above; bring its files back from a copy"));
  std::printf("%s: %d files as they were recorded, by %s\n", given.take.c_str(), check->files,
              check->sealed ? "their SHA-256" : text("decoding ", check->pictures, " pictures").c_str());
  return {};
}

Result<void> seal(const TakeArguments& given) {
  ProgressBar progress;
  const Result<capture::TakeCheck> check = pipeline::check_take(given.take, &progress);
  if (!check) return forward(check);
  if (!check->problems.empty())
    return fail(ErrorCode::BadData, text(check->problems.front(), "; what is damaged is not sealed"));
  if (Result<void> ok = pipeline::seal_take(given.take, &progress); !ok) return ok;
  std::printf("%s: sealed\n", given.take.c_str());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", given.take.string()}, {"sealed", true}}, given.json);
}

using Run = Result<void> (*)(const TakeArguments&);

void add_one(CLI::App& take, Chosen& chosen, const char* name, const char* help, Run run,
             const std::vector<std::string>& examples) {
  auto options = std::make_shared<TakeArguments>();
  CLI::App* verb = add_verb(take, chosen, name, help, examples);
  add_take(*verb, options->take);
  add_json(*verb, options->json);
  verb->callback([options, run, &chosen] { chosen.run = [options, run] { return run(*options); }; });
}

}  // namespace

void add_take_verb(CLI::App& app, Chosen& chosen) {
  CLI::App* take = add_verb(app, chosen, "take", "What takes hold, whether they are whole; new takes of them",
                            {"floatstage take info T", "floatstage take verify T --json V.json"});
  take->require_subcommand(1);
  add_one(*take, chosen, "info", "What was recorded and what was derived from it", &info,
          {"floatstage take info T", "floatstage take info T --json I.json"});
  add_one(*take, chosen, "verify",
          "Whether every recorded file is as it was written; by hash, or by decoding", &verify,
          {"floatstage take verify T", "floatstage take verify T --json V.json"});
  add_one(*take, chosen, "seal",
          "Notes the SHA-256 of every recorded file; recordings and imports do it alone", &seal,
          {"floatstage take seal T", "floatstage take seal T --json S.json"});
  add_take_derivations(*take, chosen);
  add_take_set_world(*take, chosen);
  add_take_set_time_code(*take, chosen);
  add_take_set_sound(*take, chosen);
  add_take_undistort(*take, chosen);
  add_take_add_detail(*take, chosen);
  add_take_list(*take, chosen);
}

}  // namespace floatstage::apps
