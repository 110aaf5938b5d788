#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/world_flags.h"
#include "apps/verbs.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/import/import.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct ImportArguments {
  pipeline::ImportOptions import;
  std::string other_size = "refuse", contour_origin = "corner", frames, sync;
  double frame_rate = 0, plane = 0;  // 0: not given
  std::filesystem::path json;
};

nlohmann::json to_json(const pipeline::ImportReport& report, const std::filesystem::path& take) {
  nlohmann::json sync = nlohmann::json::array();
  for (const pipeline::CameraSync& c : report.sync)
    sync.push_back(
        {{"serial", c.serial}, {"began_before_s", c.seconds}, {"events", c.events}, {"spread_s", c.spread}});
  return {{"take", take.string()},     {"frames", report.frames}, {"gaps", report.gaps},
          {"cameras", report.serials}, {"mattes", report.mattes}, {"plates", report.plates},
          {"sounds", report.sounds},   {"sync", std::move(sync)}, {"notes", report.notes},
          {"world", report.world}};
}

Result<void> run_import(const ImportArguments& given) {
  pipeline::ImportOptions options = given.import;
  options.other_size = given.other_size == "scaled"    ? pipeline::OtherSize::Scaled
                       : given.other_size == "cropped" ? pipeline::OtherSize::Cropped
                                                       : pipeline::OtherSize::Refuse;
  options.contour_options.origin =
      given.contour_origin == "centre" ? pipeline::ContourOrigin::Centre : pipeline::ContourOrigin::Corner;
  if (given.frame_rate > 0) options.frame_rate = given.frame_rate;
  if (!given.sync.empty())
    options.sync = given.sync == "clap" ? pipeline::SyncSign::Clap : pipeline::SyncSign::Flash;
  if (given.plane != 0) options.plane = given.plane;
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
  log::info(report->world);
  std::printf(
      "%s: %d frames of %zu cameras%s%s%s\n", options.out.c_str(), report->frames, report->serials.size(),
      report->mattes ? ", with mattes" : "", report->plates > 0 ? ", with plates" : "",
      report->sounds > 0
          ? text(", with ", report->sounds, report->sounds == 1 ? " sound track" : " sound tracks").c_str()
          : "");
  if (!given.json.empty()) return pipeline::save_json(to_json(*report, options.out), given.json);
  return {};
}

// What one sub-verb reads.
struct Reads {
  std::string name, title, files;
  bool states_unit;
};

void add_format(CLI::App& verb, const Reads& format, Chosen& chosen) {
  auto options = std::make_shared<ImportArguments>();
  pipeline::ImportOptions& import = options->import;
  import.calibration.format = format.name;
  const std::string begin = "floatstage import " + format.name + " ";
  CLI::App* app = add_verb(verb, chosen, format.name, format.title,
                           {begin + "calibration/ --images pictures/ -o take",
                            begin + "calibration/ --frames 100:200 --cameras 01,03 -o part"});
  app->add_option("calibration", import.calibration.path, format.files)->required();
  add_out(*app, import.out, "The new take's folder")->required();
  app->add_option("--images,--videos", import.pictures,
                  "Folder with a picture, a video or a folder of pictures for each camera (default: beside "
                  "the calibration)")
      ->type_name("FOLDER");
  app->add_option("--mattes", import.mattes,
                  "Folder with mattes (PNG) named like the pictures: the take needs no keying. Enough "
                  "without pictures")
      ->type_name("FOLDER");
  app->add_option("--contours", import.contours,
                  "Polygons of other programs in the place of mattes: COCO's JSON file, or a folder of "
                  "labelme's named like the pictures (SERIAL/NAME.json)")
      ->type_name("PATH");
  app->add_option(
         "--plates", import.plates,
         "Folder with a picture of the empty stage for each camera, named like the pictures; or a video "
         "or a folder of them, for the noise of each pixel")
      ->type_name("FOLDER");
  app->add_option("--contour-origin", options->contour_origin,
                  "Where (0, 0) is for that program: the picture's corner (labelme, CVAT), or the first "
                  "pixel's centre (OpenCV, scikit-image)")
      ->capture_default_str()
      ->check(one_of({"corner", "centre"}));
  add_list(*app, "--contour-labels", import.contour_options.labels,
           "Labels whose contours are the subject (default: all)");
  add_cameras(*app, import.cameras);
  add_frames(*app, options->frames, "all");
  app->add_option("--other-size", options->other_size,
                  "Pictures of another size than calibrated: refuse them, or they were scaled (each axis by "
                  "itself) or cropped (at the right and the bottom)")
      ->capture_default_str()
      ->check(one_of({"refuse", "scaled", "cropped"}));
  add_fps(*app, options->frame_rate, "Frames a second (default: as the videos say)");
  app->add_option(
         "--sync", options->sync,
         "Videos were started by hand: bring them together by claps in their sound, or by flashes in "
         "their pictures")
      ->check(one_of({"clap", "flash"}));
  add_codec(*app, import.codec);
  app->add_flag("!--no-sound", import.sound, "Leave out the videos' sound tracks");
  app->add_option("--label", import.label, "The take's label (default: the format's name)");
  if (format.name == "lightfield")
    app->add_option("--plane", options->plane,
                    "How far before the cameras the plane stands that it is drawn on, metres (default: where "
                    "neighbouring pictures agree best)")
        ->type_name("Z");
  add_world_flags(*app, import.world);
  if (!format.states_unit)
    app->add_option("--metres-per-unit", import.calibration.metres_per_unit,
                    "Length of the calibration's unit, which it does not state")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  add_threads(*app, import.threads);
  add_json(*app, options->json);
  app->callback([options, &chosen] { chosen.run = [options] { return run_import(*options); }; });
}

}  // namespace

void add_import(CLI::App& app, Chosen& chosen) {
  CLI::App* verb =
      add_verb(app, chosen, "import", "Makes a take of others' pictures or videos and their calibration",
               {"floatstage import middlebury templeRing/ -o temple",
                "floatstage import opencv calibration/ --videos footage/ -o take"});
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
