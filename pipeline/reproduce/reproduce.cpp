#include "pipeline/reproduce/reproduce.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/log.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/reproduce/experiment.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char *kTable = "table.json", *kMarkdown = "table.md";
constexpr const char* kFiles[] = {kTable, "table.csv", kMarkdown, "sheet.png", "chart.svg"};
constexpr int kVersion = 1;  // of the experiments: what an older one made is not mixed with these

bool is_wanted(const Experiment& e, const std::vector<std::string>& only) {
  return only.empty() || std::any_of(only.begin(), only.end(), [&](const std::string& name) {
           return name == e.figure || name == e.name();
         });
}

json made_with(const ReproduceOptions& options, render::BackEnd back_end) {
  json methods = compared_methods(false);
  return {{"version", kVersion},
          {"small", options.small},
          {"renderer", render::back_end_names()[static_cast<std::size_t>(back_end)]},
          {"methods", std::move(methods)}};
}

// Why an experiment cannot be made here, or nothing.
std::optional<std::string> missing(const Experiment& e, const fs::path& data) {
  if (*e.data == 0) return std::nullopt;
  if (data.empty()) return text("it needs the set ", e.data, "; say where the sets are with --data FOLDER");
  std::error_code error;
  if (!fs::is_directory(data / e.data, error)) return text((data / e.data).string(), " is not there");
  return std::nullopt;
}

Result<json> load_table(const fs::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  Result<json> table = parse_json(*bytes, file.string());
  if (table && !(table->is_object() && table->contains("made_with") && table->contains("rows")))
    return fail(ErrorCode::BadData,
                text(file.string(), " is no table of an experiment; say --redo to make it anew"));
  return table;
}

Result<void> write_outcome(const Outcome& outcome, const json& with, const fs::path& folder) {
  json table = to_json(outcome.table);
  table["made_with"] = with;
  if (Result<void> ok = save_json(table, folder / kTable); !ok) return ok;
  if (Result<void> ok = write_file(folder / "table.csv", to_csv(outcome.table)); !ok) return ok;
  if (Result<void> ok = write_file(folder / kMarkdown, to_markdown(outcome.table)); !ok) return ok;
  if (!outcome.sheet.empty())
    if (Result<void> ok = save_png(outcome.sheet, folder / "sheet.png"); !ok) return ok;
  return outcome.chart.empty() ? Result<void>() : write_file(folder / "chart.svg", outcome.chart);
}

// AlreadyExists where something lies in an experiment's folder that none made.
Result<void> check_folder(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (std::find(std::begin(kFiles), std::end(kFiles), name) == std::end(kFiles))
      return fail(ErrorCode::AlreadyExists,
                  text(folder.string(), " holds ", name, ", which no experiment made; choose another --out"));
  }
  return {};
}

// Whether an experiment is there as it would be made now; AlreadyExists where it is there, but otherwise.
Result<bool> is_done(const fs::path& folder, const json& with) {
  if (!is_there(folder / kTable)) return false;
  const Result<json> table = load_table(folder / kTable);
  if (!table) return forward(table);
  if (table->at("made_with") == with) return true;
  return fail(ErrorCode::AlreadyExists,
              text(folder.string(),
                   " was made otherwise (other methods, size or renderer); say --redo to make "
                   "it anew, or choose another --out"));
}

// What an earlier run made stays until this one has something in its place.
Result<void> make(const Experiment& e, const Lab& lab, const json& with, const fs::path& folder) {
  const Result<Outcome> outcome = e.run(lab);
  if (!outcome && outcome.error().code == ErrorCode::Cancelled) return cancelled();
  if (!outcome) return fail(outcome.error().code, text(e.name(), ": ", outcome.error().message));
  if (Result<void> ok = make_folder(folder.parent_path()); !ok) return ok;
  std::error_code error;
  for (const char* name : kFiles) fs::remove(folder / name, error);
  Result<UnfinishedFolder> unfinished = UnfinishedFolder::begin(folder);
  if (!unfinished) return forward(unfinished);
  if (Result<void> ok = write_outcome(*outcome, with, unfinished->folder()); !ok) return ok;
  return unfinished->publish();
}

// All that is there, whoever made it.
Result<void> write_report(const fs::path& out, const std::vector<ReproduceReport::LeftOut>& left_out) {
  json report = {{"left_out", json::array()}};
  for (const ReproduceReport::LeftOut& l : left_out)
    report["left_out"].push_back({{"name", l.name}, {"why", l.why}});
  std::string pages = "# The experiments of chapters 10 and 11\n";
  for (const Experiment& e : experiments()) {
    const fs::path folder = out / e.name();
    json& place = *e.part == 0 ? report[e.figure] : report[e.figure][e.part];
    if (!is_there(folder / kTable)) continue;
    Result<json> table = load_table(folder / kTable);
    if (!table) return forward(table);
    const Result<std::string> page = read_file(folder / kMarkdown);
    if (!page) return forward(page);
    place = std::move(*table);
    pages += "\n" + *page;
    for (const char* picture : {"sheet.png", "chart.svg"})
      if (is_there(folder / picture)) pages += text("\n![", e.name(), "](", e.name(), "/", picture, ")\n");
  }
  for (const ReproduceReport::LeftOut& l : left_out)
    pages += text("\nLeft out: ", l.name, ", as ", l.why, ".\n");
  if (Result<void> ok = save_json(report, out / "report.json"); !ok) return ok;
  return write_file(out / "report.md", pages);
}

}  // namespace

std::vector<std::string> experiment_names() {
  std::vector<std::string> names;
  for (const Experiment& e : experiments()) {
    if (std::find(names.begin(), names.end(), e.figure) == names.end()) names.emplace_back(e.figure);
    if (*e.part != 0) names.push_back(e.name());
  }
  return names;
}

Result<ReproduceReport> reproduce(const ReproduceOptions& options) {
  if (options.out.empty())
    return fail(ErrorCode::InvalidArgument, "no folder for the experiments; say --out FOLDER");
  const std::vector<std::string> names = experiment_names();
  for (const std::string& name : options.only)
    if (std::find(names.begin(), names.end(), name) == names.end())
      return fail(ErrorCode::InvalidArgument, text("there is no experiment '", name, "'"));
  std::error_code error;
  if (!options.data.empty() && !fs::is_directory(options.data, error))
    return fail(ErrorCode::NotFound, text("--data ", options.data.string(), ": there is no such folder"));
  const Result<render::OpenBackEnd> drawing = render::open_back_end(options.back_end);
  if (!drawing) return forward(drawing);
  const Lab lab{options.data, drawing->back_end, options.small, options.progress};
  const json with = made_with(options, drawing->back_end);

  ReproduceReport report;
  std::vector<const Experiment*> wanted;
  for (const Experiment& e : experiments()) {
    if (!is_wanted(e, options.only)) continue;
    const fs::path folder = options.out / e.name();
    if (Result<void> ok = check_folder(folder); !ok) return forward(ok);
    if (!options.redo) {
      const Result<bool> done = is_done(folder, with);
      if (!done) return forward(done);
      if (*done) {
        report.kept.push_back(e.name());
        continue;
      }
    }
    if (const std::optional<std::string> why = missing(e, options.data)) {
      if (std::find(options.only.begin(), options.only.end(), e.name()) != options.only.end())
        return fail(ErrorCode::NotFound, text(e.name(), " cannot be made: ", *why));
      report.left_out.push_back({e.name(), *why});
      continue;
    }
    wanted.push_back(&e);
  }
  if (Result<void> ok = make_folder(options.out); !ok) return forward(ok);
  if (Result<void> ok = write_report(options.out, report.left_out); !ok) return forward(ok);
  for (const Experiment* e : wanted) {
    if (is_cancelled(options.progress)) return cancelled();
    log::info(text(e->name(), ": ", e->help));
    if (Result<void> ok = make(*e, lab, with, options.out / e->name()); !ok) return forward(ok);
    report.made.push_back(e->name());
    if (Result<void> ok = write_report(options.out, report.left_out); !ok) return forward(ok);
  }
  return report;
}

}  // namespace floatstage::pipeline
