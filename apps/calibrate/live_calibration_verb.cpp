#include <chrono>
#include <cstdio>
#include <thread>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/viewer/calibration/calibration_view.h"
#include "core/text.h"
#include "pipeline/calibrate/calibration_outcome.h"
#include "pipeline/calibrate/session_observations.h"

namespace floatstage::apps {
namespace {

struct LiveCalibrationArguments {
  std::filesystem::path config, out, report, json, observations, from, screenshot;
  std::string target, lens = "brown-conrady";
  Size size{1280, 800};
  double seconds = 0, least_move = 0.01;
  int threads = 0, solve_every = 20;
  bool headless = false, keep_failed = false, floor_at_end = false, fixed_intrinsics = false;
};

Result<calib::LensKind> lens_named(const std::string& name) {
  if (name == "none") return calib::LensKind::None;
  if (name == "brown-conrady") return calib::LensKind::BrownConrady;
  if (name == "kannala-brandt") return calib::LensKind::KannalaBrandt;
  return fail(ErrorCode::InvalidArgument,
              text("--lens is none, brown-conrady or kannala-brandt, not '", name, "'",
                   did_you_mean(name, {"none", "brown-conrady", "kannala-brandt"})));
}

// A line when the advice changes, and everything now and then.
void watch(const LiveRun& run) {
  std::string told;
  int sets = -1;
  for (;;) {
    const LiveStatus status = run.status();
    const std::string next = status.advice.empty() ? "enough" : status.advice.front().sentence;
    if (next != told) std::printf("after %d instants, next: %s\n", status.counted, next.c_str());
    told = next;
    constexpr int kTold = 50;
    if (status.sets >= sets + kTold) std::printf("%s\n", describe_live(status).c_str()), sets = status.sets;
    std::fflush(stdout);
    if (status.over || interrupted()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

// What was seen becomes a rig, once nothing more comes.
Result<void> solve(LiveRun& live, const LiveOptions& options, const LiveCalibrationArguments& given) {
  live.stop();
  if (Result<void> ok = live.outcome(); !ok) return ok;
  if (given.floor_at_end) live.set_floor(0);
  const calib::Observations observations = live.observations();
  const LiveStatus status = live.status();
  std::printf("%s\n", describe_live(status).c_str());
  if (!given.observations.empty()) {
    if (Result<void> ok = calib::save_observations(observations, given.observations); !ok) return ok;
  }
  const Result<calib::Calibration> solved = calib::calibrate(observations, options.calibration);
  if (!solved) return forward(solved);
  pipeline::ReportContext context{
      given.config.stem().string(),
      {text(status.sets, " instants were looked at live, ", status.counted, " of them counted")},
      {},
      0};
  for (const calib::Advice& a : status.advice) context.remarks.push_back("still wanted: " + a.sentence);
  return pipeline::write_outcome(
      *solved, {}, {}, context,
      {given.config.string(), given.out, given.report, given.json, given.keep_failed, {}});
}

Result<void> run_live_calibration(const LiveCalibrationArguments& given) {
  Result<studio::CaptureConfig> config = studio::load_capture_config(given.config);
  if (!config) return forward(config);
  Result<calib::TargetDesign> design = calib::parse_target(given.target);
  if (!design) return forward(design);
  const Result<calib::LensKind> lens = lens_named(given.lens);
  if (!lens) return forward(lens);
  std::optional<Rig> known;
  const pipeline::SessionKnown how{
      .format = "rig",
      .file = given.from,
      .intrinsics = given.fixed_intrinsics ? calib::Prior::Fixed : calib::Prior::Start,
      .poses = calib::Prior::Start};
  if (!given.from.empty()) {
    Result<Rig> rig = pipeline::load_known(how);
    if (!rig) return forward(rig);
    known = *std::move(rig);
  }
  LiveOptions options;
  options.target = {
      .design = *design, .lens = *lens, .least_move = given.least_move, .threads = given.threads};
  options.calibration.threads = given.threads;
  options.solve_every = given.solve_every;
  options.seconds = given.seconds;
  options.stop = interrupted;
  Result<void> applied;
  const Result<std::unique_ptr<LiveRun>> live = LiveRun::start(*config, options, [&](calib::Observations& o) {
    if (known) applied = pipeline::apply_known(how, *known, o);
  });
  if (!live) return forward(live);
  if (!applied) return applied;
  if (given.headless) {
    watch(**live);
  } else if (Result<void> shown =
                 show_live(**live, {given.size.width, given.size.height, given.screenshot}, interrupted);
             !shown) {
    return fail(shown.error().code,
                text(shown.error().message, "; --headless prints what the window would show"));
  }
  return solve(**live, options, given);
}

}  // namespace

void add_calibrate_live(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<LiveCalibrationArguments>();
  CLI::App* verb = add_verb(
      calibrate, chosen, "live",
      "Wave a target before running cameras: coverage, errors, and what to show next",
      {"floatstage calibrate live studio.toml --target \"charuco columns=5 rows=7 square=40mm marker=30mm "
       "dictionary=5x5_100\" -o rig.json",
       "floatstage calibrate live studio.toml --target \"chessboard columns=8 rows=5 square=30mm\" --from "
       "rig.json --headless"});
  verb->add_option("config", options->config, "The studio: its cameras, as for capture (TOML)")->required();
  verb->add_option("--target", options->target,
                   "What is waved, in one line of words: \"charuco columns=5 …\"")
      ->required();
  add_out(*verb, options->out, "The rig.json to write when the calibration passes");
  verb->add_option("--report", options->report, "Folder for calibration.html and calibration.json")
      ->type_name("FOLDER");
  verb->add_option("--lens", options->lens, "none, brown-conrady or kannala-brandt")->capture_default_str();
  verb->add_option("--from", options->from, "A rig.json of before: solved again from there, in its world")
      ->type_name("FILE");
  verb->add_flag("--fixed-intrinsics", options->fixed_intrinsics,
                 "With --from: lenses stay as they are there");
  add_seconds(*verb, options->seconds,
              "How long (default: until the window is closed, Ctrl-C, or recordings are over)");
  verb->add_flag("--headless", options->headless, "No window: print it");
  verb->add_flag("--floor-at-end", options->floor_at_end,
                 "In the last instant that counted the target lies on the floor");
  verb->add_option("--observations", options->observations,
                   "Write what was detected to this file: a session can solve it again")
      ->type_name("FILE");
  verb->add_flag("--keep-failed", options->keep_failed,
                 "Write --out even when the calibration does not pass");
  add_size(*verb, options->size, "Size of the window")->group(kGroupWindow);
  verb->add_option("--screenshot", options->screenshot,
                   "Write the window to this PNG when the pictures are over, then end")
      ->type_name("FILE")
      ->group(kGroupWindow);
  add_threads(*verb, options->threads);
  add_json(*verb, options->json);
  verb->add_option("--least-move", options->least_move,
                   "An instant counts when the target has moved by this share of a picture's width")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0))
      ->group(kGroupTuning);
  verb->add_option("--solve-every", options->solve_every,
                   "Instants that counted, between two quick solutions")
      ->capture_default_str()
      ->check(CLI::PositiveNumber)
      ->group(kGroupTuning);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_live_calibration(*options); }; });
}

}  // namespace floatstage::apps
