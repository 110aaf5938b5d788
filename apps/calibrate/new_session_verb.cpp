#include <cstdio>
#include <cstdlib>
#include <iostream>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/progress_bar.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/calibrate/new_session.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct NewSessionArguments {
  std::filesystem::path folder, out, json;
  std::string target;
  double square_mm = 0, distance_mm = 0;
  bool alone = false, at_once = false;
  int threads = 0;
};

// A number of millimetres from who sits at the terminal; nothing for an empty line.
std::optional<double> asked(const std::string& question) {
  std::printf("%s (Enter: assume) ", question.c_str());
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line)) return std::nullopt;
  char* end = nullptr;
  const double mm = std::strtod(line.c_str(), &end);
  if (end == line.c_str() || !(mm > 0)) return std::nullopt;
  return 1e-3 * mm;
}

// As write_file() does, where nothing is there yet.
Result<void> write_new(const std::filesystem::path& file, const std::string& bytes) {
  const std::filesystem::path temporary = temporary_name(file);
  if (Result<void> ok = write_file(temporary, bytes); !ok) return ok;
  const Result<void> renamed = rename_new(temporary, file);
  std::error_code ignored;
  if (!renamed) std::filesystem::remove(temporary, ignored);
  return renamed;
}

Result<void> run_new_session(const NewSessionArguments& given) {
  const std::filesystem::path out = given.out.empty() ? given.folder / "session.toml" : given.out;
  if (is_there(out))
    return fail(ErrorCode::AlreadyExists,
                text(out.string(), ": is there already, and is left as it is; give another --out"));
  pipeline::NewSessionOptions options;
  options.target = given.target;
  options.threads = given.threads;
  if (given.square_mm > 0) options.square = 1e-3 * given.square_mm;
  if (given.distance_mm > 0) options.distance = 1e-3 * given.distance_mm;
  options.alone = given.alone;
  options.at_once = given.at_once;
  if (isatty(STDIN_FILENO) != 0 && isatty(STDOUT_FILENO) != 0) options.ask = asked;
  ProgressBar bar;
  const std::filesystem::path beside = out.has_parent_path() ? out.parent_path() : ".";
  const Result<pipeline::NewSession> session = pipeline::draft_session(given.folder, beside, options, &bar);
  if (!session) return forward(session);
  if (interrupted()) return pipeline::cancelled_unwritten();
  if (Result<void> ok = write_new(out, session->toml); !ok) return ok;
  for (const std::string& sentence : session->found) std::printf("found: %s\n", sentence.c_str());
  for (const std::string& sentence : session->assumed) std::printf("assumed: %s\n", sentence.c_str());
  std::printf("%s: %zu cameras; run it with: floatstage calibrate %s -o rig.json --report report\n",
              out.string().c_str(), session->cameras, out.string().c_str());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"session", out.string()},
                              {"cameras", session->cameras},
                              {"found", session->found},
                              {"assumed", session->assumed}},
                             given.json);
}

}  // namespace

void add_calibrate_new(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<NewSessionArguments>();
  CLI::App* verb = add_verb(calibrate, chosen, "new",
                            "Looks at a folder of pictures and writes a session that can be run as it is",
                            {"floatstage calibrate new pictures",
                             "floatstage calibrate new pictures --square-mm 24.5 -o session.toml"});
  verb->add_option("folder", options->folder,
                   "The folder: boards, videos, EXIF and calibrations of other programs are looked for")
      ->required();
  add_out(*verb, options->out, "The session to write; it must not be there yet (FOLDER/session.toml)");
  verb->add_option("--target", options->target,
                   "The board's line, where it should not be told from the pictures: \"chessboard columns=8 "
                   "rows=5 square=30mm\"");
  verb->add_option("--square-mm", options->square_mm, "Side of the board's squares, which no picture shows")
      ->check(CLI::PositiveNumber);
  verb->add_option("--distance-mm", options->distance_mm,
                   "Between the first two cameras, where there is no board: how large the scene is")
      ->check(CLI::PositiveNumber);
  CLI::Option* alone =
      verb->add_flag("--alone", options->alone, "Stills of the board were taken by each camera for itself");
  verb->add_flag("--at-once", options->at_once, "Stills of the board were taken by all cameras at once")
      ->excludes(alone);
  add_threads(*verb, options->threads);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_new_session(*options); }; });
}

}  // namespace floatstage::apps
