#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/renderer_options.h"
#include "apps/verbs.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/reproduce/reproduce.h"

namespace floatstage::apps {
namespace {

struct ReproduceArguments {
  pipeline::ReproduceOptions reproduce;
  std::string back_end = "auto";
  std::filesystem::path json;
};

nlohmann::json to_json(const ReproduceArguments& given, const pipeline::ReproduceReport& report) {
  nlohmann::json json = {{"out", given.reproduce.out.string()},
                         {"made", report.made},
                         {"kept", report.kept},
                         {"left_out", nlohmann::json::array()}};
  for (const auto& left : report.left_out)
    json["left_out"].push_back({{"name", left.name}, {"why", left.why}});
  return json;
}

Result<void> run_reproduce(const ReproduceArguments& given) {
  pipeline::ReproduceOptions options = given.reproduce;
  const Result<render::BackEnd> back_end = render::parse_back_end(given.back_end);
  if (!back_end) return forward(back_end);
  options.back_end = *back_end;
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ReproduceReport> report = pipeline::reproduce(options);
  if (!report) return forward(report);
  for (const auto& left : report->left_out) log::warning(text(left.name, " is left out: ", left.why));
  std::printf("%s: %zu experiments made, %zu kept, %zu left out; see report.md there\n", options.out.c_str(),
              report->made.size(), report->kept.size(), report->left_out.size());
  return given.json.empty() ? Result<void>() : pipeline::save_json(to_json(given, *report), given.json);
}

}  // namespace

void add_reproduce(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<ReproduceArguments>();
  pipeline::ReproduceOptions& o = options->reproduce;
  CLI::App* verb = add_verb(
      app, chosen, "reproduce", "The thesis' experiments on renderers: a table and a picture sheet each",
      {"floatstage reproduce -o results", "floatstage reproduce -o results --data sets --only fig52,sweeps"});
  add_out(*verb, o.out, "Folder of the results; experiments that are done there are kept")->required();
  verb->add_option("--data", o.data,
                   "Folder that holds the real sets stanford-bunny and lightfield-shop (default: experiments "
                   "that need them are left out)")
      ->type_name("FOLDER");
  add_list(*verb, "--only", o.only, "Only these experiments", pipeline::experiment_names());
  verb->add_flag("--small", o.small, "Pictures of half the size and few views: a look, not the figures");
  add_redo(*verb, o.redo);
  add_back_end_flag(*verb, options->back_end);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_reproduce(*options); }; });
}

}  // namespace floatstage::apps
