#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/verbs.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/synthesize.h"

namespace floatstage::apps {
namespace {

struct SynthesizeArguments {
  pipeline::SynthesizeOptions synthesize;
  std::filesystem::path json_file;
  std::string shape = "ring", stage = "green", cast = "one";
  Size size;
};

Result<void> run_synthesize(const SynthesizeArguments& given) {
  pipeline::SynthesizeOptions options = given.synthesize;
  options.rig.width = given.size.width;
  options.rig.height = given.size.height;
  options.rig.shape = given.shape == "ring" ? RigShape::Ring : RigShape::QuarterDome;
  options.studio.stage = *synthetic_stage(given.stage);
  options.studio.cast = given.cast == "two"     ? SyntheticCast::Two
                        : given.cast == "alike" ? SyntheticCast::Alike
                                                : SyntheticCast::One;
  ProgressBar bar;
  options.progress = &bar;
  if (Result<void> ok = pipeline::synthesize_take(options); !ok) return ok;
  std::printf("%s: %d frames of %d cameras, %dx%d\n", options.out.c_str(), options.frames,
              options.rig.cameras, options.rig.width, options.rig.height);
  if (given.json_file.empty()) return {};
  return pipeline::save_json({{"take", options.out.string()},
                              {"frames", options.frames},
                              {"cameras", options.rig.cameras},
                              {"width", options.rig.width},
                              {"height", options.rig.height},
                              {"stage", given.stage},
                              {"seed", options.studio.seed}},
                             given.json_file);
}

void add_defect_flags(CLI::App& verb, Defects& d) {
  const std::vector<CLI::Option*> defects = {
      verb.add_option("--noise", d.noise, "Sensor noise, 8-bit steps")->check(CLI::NonNegativeNumber),
      verb.add_option("--lens-k1", d.lens_k1, "Radial lens distortion"),
      verb.add_option("--color-gain", d.color_gain, "Relative spread of the cameras' colour gains")
          ->check(CLI::NonNegativeNumber),
      verb.add_option("--calibration-error", d.calibration_error,
                      "Spread of the published rig's projections, px")
          ->check(CLI::NonNegativeNumber),
      verb.add_option("--green-spill", d.green_spill, "Green light on the performer, 0 to 1")
          ->check(CLI::Range(0.0, 1.0)),
      verb.add_option("--dropped-frames", d.dropped_frames, "Fraction of frames lost")
          ->check(CLI::Range(0.0, 1.0)),
      verb.add_option("--time-jitter", d.time_jitter, "Spread of the exposures' starts, seconds")
          ->check(CLI::NonNegativeNumber)};
  for (CLI::Option* defect : defects) defect->capture_default_str()->group(kGroupDefects);
}

}  // namespace

void add_synthesize(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<SynthesizeArguments>();
  pipeline::SynthesizeOptions& s = options->synthesize;
  CLI::App* verb =
      add_verb(app, chosen, "synthesize", "Writes a take with ground truth from the synthetic studio",
               {"floatstage synthesize -o take --camera-count 8 --frame-count 50",
                "floatstage synthesize -o noisy --stage lit-black --size 320x240 --noise 2"});
  add_out(*verb, s.out, "The new take's folder")->required();
  add_camera_count(*verb, s.rig.cameras, 1);
  verb->add_option("--shape", options->shape, "Where they stand")
      ->capture_default_str()
      ->check(one_of({"ring", "quarter-dome"}));
  add_size(*verb, options->size, "Size of the photographs");
  add_frame_count(*verb, s.frames, "Instants of the take");
  add_fps(*verb, s.studio.frame_rate, "Instants a second");
  verb->add_option("--seed", s.studio.seed, "Same seed, same bytes")->capture_default_str();
  std::string stage_help = "What stands behind the performer:";
  std::vector<std::string> stages;
  for (const SyntheticStageName& known : synthetic_stages()) {
    stage_help += text("\n  ", known.name, ": ", known.help);
    stages.emplace_back(known.name);
  }
  verb->add_option("--stage", options->stage, stage_help)->capture_default_str()->check(one_of(stages));
  verb->add_option("--cast", options->cast,
                   "Who performs: one; two in different clothes who cross; two alike who walk through one "
                   "another")
      ->capture_default_str()
      ->check(one_of({"one", "two", "alike"}));
  verb->add_flag("--depth", s.depth, "Write the true depth maps too");
  add_codec(*verb, s.take.codec);
  add_defect_flags(*verb, s.studio.defects);
  add_threads(*verb, s.threads);
  add_json(*verb, options->json_file);
  verb->add_option("--samples", s.studio.samples, "Rays a pixel, a square number")
      ->capture_default_str()
      ->check(CLI::Range(1, 256))
      ->group(kGroupTuning);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_synthesize(*options); }; });
}

}  // namespace floatstage::apps
