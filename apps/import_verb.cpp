#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "apps/progress_bar.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/import/import.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct Options {
  pipeline::ImportOptions import;
  std::string codec = "ffv1", other_size = "refuse", frames, cameras;
  double frame_rate = 0;  // 0: not given
  std::filesystem::path json;
};

nlohmann::json to_json(const pipeline::ImportReport& report, const std::filesystem::path& take) {
  return {{"take", take.string()},     {"frames", report.frames}, {"gaps", report.gaps},
          {"cameras", report.serials}, {"mattes", report.mattes}, {"notes", report.notes}};
}

Result<void> run(const Options& given) {
  pipeline::ImportOptions options = given.import;
  options.codec = given.codec == "ffv1"  ? capture::TakeCodec::Ffv1
                  : given.codec == "raw" ? capture::TakeCodec::Raw
                                         : capture::TakeCodec::H264;
  options.other_size = given.other_size == "scaled"    ? pipeline::OtherSize::Scaled
                       : given.other_size == "cropped" ? pipeline::OtherSize::Cropped
                                                       : pipeline::OtherSize::Refuse;
  options.cameras = split_list(given.cameras);
  if (given.frame_rate > 0) options.frame_rate = given.frame_rate;
  if (!given.frames.empty()) {
    const Result<pipeline::FrameRange> range = pipeline::parse_frame_range(given.frames);
    if (!range) return forward(range);
    options.frames = *range;
  }
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ImportReport> report = pipeline::import_take(options);
  if (!report) return forward(report);
  for (const std::string& note : report->notes) log::info(note);
  std::printf("%s: %d frames of %zu cameras%s\n", options.out.c_str(), report->frames, report->serials.size(),
              report->mattes ? ", with mattes" : "");
  if (!given.json.empty()) return pipeline::save_json(to_json(*report, options.out), given.json);
  return {};
}

// What one sub-verb reads.
struct Reads {
  std::string name, title, files;
  bool states_unit;
};

void add_format(CLI::App& verb, const Reads& format, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  pipeline::ImportOptions& import = options->import;
  import.calibration.format = format.name;
  CLI::App* app = verb.add_subcommand(format.name, format.title);
  app->add_option("calibration", import.calibration.path, format.files)->required();
  app->add_option("--out", import.out, "The new take's folder")->required();
  app->add_option("--images,--videos", import.pictures,
                  "Folder with a picture, a video or a folder of pictures for each camera (default: beside "
                  "the calibration)");
  app->add_option(
      "--mattes", import.mattes,
      "Folder with mattes (PNG) named like the pictures: the take needs no keying. Enough without pictures");
  app->add_option("--other-size", options->other_size,
                  "Pictures of another size than calibrated: refuse them, or they were scaled (each axis by "
                  "itself) or cropped (at the right and the bottom)")
      ->capture_default_str()
      ->check(CLI::IsMember({"refuse", "scaled", "cropped"}));
  app->add_option("--cameras", options->cameras, "Only these serials: a,b,c");
  app->add_option("--frames", options->frames, "Only frames A:B of videos and folders (B not included)");
  app->add_option("--fps", options->frame_rate, "Frames a second (default: as the videos say)")
      ->check(CLI::PositiveNumber);
  app->add_option("--codec", options->codec, "Media codec")
      ->capture_default_str()
      ->check(CLI::IsMember({"ffv1", "raw", "h264"}));
  app->add_option("--label", import.label, "The take's label (default: the format's name)");
  app->add_option("--threads", import.threads, "Threads; 0: one per core")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app->add_option("--json", options->json, "Write a report to this file");
  if (!format.states_unit)
    app->add_option("--metres-per-unit", import.calibration.metres_per_unit,
                    "Length of the calibration's unit, which it does not state")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  app->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace

void add_import(CLI::App& app, Chosen& chosen) {
  CLI::App* verb =
      app.add_subcommand("import", "Makes a take of others' pictures or videos and their calibration");
  verb->require_subcommand(1);
  add_format(*verb,
             {std::string(calib::kAnyRigFormat), "Whichever of the formats is there",
              "a calibration's file, or the folder that holds it", false},
             chosen);
  for (const calib::RigFormat& f : calib::rig_formats())
    add_format(*verb, {std::string(f.name), std::string(f.title), std::string(f.files), f.states_unit},
               chosen);
}

}  // namespace floatstage::apps
