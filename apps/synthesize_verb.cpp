#include <cstdio>

#include "apps/progress_bar.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "core/text.h"
#include "pipeline/synthesize.h"

namespace floatstage::apps {
namespace {

struct Options {
  pipeline::SynthesizeOptions synthesize;
  std::string size = "640x480", shape = "ring", codec = "ffv1";
  bool black = false;
};

Result<void> run(const Options& given) {
  pipeline::SynthesizeOptions options = given.synthesize;
  Result<std::pair<int, int>> size = parse_size(given.size);
  if (!size) return forward(size);
  std::tie(options.rig.width, options.rig.height) = *size;
  options.rig.shape = given.shape == "ring" ? RigShape::Ring : RigShape::QuarterDome;
  options.take.codec = given.codec == "ffv1"  ? capture::TakeCodec::Ffv1
                       : given.codec == "raw" ? capture::TakeCodec::Raw
                                              : capture::TakeCodec::H264;
  options.studio.green_room = !given.black;
  ProgressBar bar;
  options.progress = &bar;
  if (Result<void> ok = pipeline::synthesize_take(options); !ok) return ok;
  std::printf("%s: %d frames of %d cameras, %s\n", options.out.c_str(), options.frames, options.rig.cameras,
              given.size.c_str());
  return {};
}

}  // namespace

void add_synthesize(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  pipeline::SynthesizeOptions& s = options->synthesize;
  Defects& d = s.studio.defects;
  CLI::App* verb =
      app.add_subcommand("synthesize", "Writes a take with ground truth from the synthetic studio");
  verb->add_option("--out", s.out, "The new take's folder")->required();
  verb->add_option("--cameras", s.rig.cameras, "Number of cameras")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  verb->add_option("--shape", options->shape, "Where they stand")
      ->capture_default_str()
      ->check(CLI::IsMember({"ring", "quarter-dome"}));
  verb->add_option("--size", options->size, "Size of the photographs")->capture_default_str();
  verb->add_option("--frames", s.frames, "Number of instants")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  verb->add_option("--fps", s.studio.frame_rate, "Instants a second")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  verb->add_option("--seed", s.studio.seed, "Same seed, same bytes")->capture_default_str();
  verb->add_option("--samples", s.studio.samples, "Rays a pixel, a square number")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  verb->add_flag("--black", options->black, "A black stage instead of green cloth");
  verb->add_flag("--depth", s.depth, "Write the true depth maps too");
  verb->add_option("--codec", options->codec, "Media codec")
      ->capture_default_str()
      ->check(CLI::IsMember({"ffv1", "raw", "h264"}));
  verb->add_option("--threads", s.threads, "Threads; 0: one per core")->capture_default_str();
  verb->add_option("--noise", d.noise, "Defect: sensor noise, 8-bit steps")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--lens-k1", d.lens_k1, "Defect: radial lens distortion")->capture_default_str();
  verb->add_option("--color-gain", d.color_gain, "Defect: relative spread of the cameras' colour gains")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--calibration-error", d.calibration_error,
                   "Defect: spread of the published rig's projections, px")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--green-spill", d.green_spill, "Defect: green light on the performer, 0 to 1")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  verb->add_option("--dropped-frames", d.dropped_frames, "Defect: fraction of frames lost")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  verb->add_option("--time-jitter", d.time_jitter, "Defect: spread of the exposures' starts, seconds")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
