#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/occluders.h"
#include "pipeline/scene_loader.h"
#include "pipeline/silhouettes/silhouette_check.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

constexpr int kInstants = 4;  // where none are named: three reach a hundredth of a degree in the studio

struct SilhouettesArguments {
  std::filesystem::path take, out, reference, json_file;
  std::string frames;
  double alarm = 0.1;
  int threads = 0;
};

std::vector<int> spread(const std::vector<int>& frames) {
  if (static_cast<int>(frames.size()) <= kInstants) return frames;
  std::vector<int> out;
  for (int k = 0; k < kInstants; ++k)
    out.push_back(frames[static_cast<std::size_t>(k) * (frames.size() - 1) / (kInstants - 1)]);
  return out;
}

Result<std::vector<pipeline::InstantMattes>> load(const capture::TakeReader& take,
                                                  const std::vector<int>& frames) {
  std::vector<pipeline::InstantMattes> instants;
  const Result<pipeline::Occluders> occluders = pipeline::load_occluders(take.layout(), take.rig());
  if (!occluders) return forward(occluders);
  for (const int frame : frames) {
    Result<std::vector<Matte>> mattes = pipeline::load_mattes(take, frame);
    if (mattes) mattes = occluders->props.silhouettes(take.rig(), std::move(*mattes), 0);
    if (!mattes) return forward(mattes);
    const bool any = std::any_of(mattes->begin(), mattes->end(), [](const Matte& m) { return !m.empty(); });
    if (any) instants.push_back(*std::move(mattes));
  }
  if (!instants.empty()) return instants;
  return fail(ErrorCode::NotFound, text(take.layout().folder().string(),
                                        " has no mattes of these frames; make them with `floatstage matte`"));
}

// What an earlier run measured, from its --json report.
Result<std::vector<Eigen::Vector3d>> load_reference(const std::filesystem::path& file, const Rig& rig) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  const Result<json> report = parse_json(*bytes, file.string());
  if (!report) return forward(report);
  std::vector<Eigen::Vector3d> out;
  for (const RigCamera& camera : rig.cameras) {
    std::optional<Eigen::Vector3d> vector;
    if (report->is_object() && report->contains("cameras") && (*report)["cameras"].is_array())
      for (const json& c : (*report)["cameras"]) {
        if (!c.is_object() || c.value("serial", json()) != camera.serial || !c.contains("turn_vector"))
          continue;
        const json& v = c["turn_vector"];
        if (v.is_array() && v.size() == 3 &&
            std::all_of(v.begin(), v.end(), [](const json& n) { return n.is_number(); }))
          vector = Eigen::Vector3d(v[0], v[1], v[2]);
      }
    if (!vector)
      return fail(ErrorCode::BadData,
                  text(file.string(), ": says nothing of camera '", camera.serial,
                       "'; it must be the --json report of `calibrate silhouettes` on a take of this rig"));
    out.push_back(*vector);
  }
  return out;
}

json to_json(const calib::SilhouetteTurn& turn) {
  if (!turn.known) return {{"known", false}, {"points", turn.points}};
  return {{"known", true},
          {"degrees", turn.degrees},
          {"sigma_degrees", turn.sigma_degrees},
          {"outside_px", turn.outside_px},
          {"outside_after_turn_px", turn.outside_after_px},
          {"points", turn.points}};
}

json to_json(const pipeline::SilhouetteCheck& check, const std::vector<Eigen::Vector3d>& reference,
             const std::vector<int>& frames) {
  json cameras = json::array();
  for (std::size_t c = 0; c < check.cameras.size(); ++c) {
    const pipeline::SilhouetteCameraCheck& one = check.cameras[c];
    json j = {{"serial", one.serial},
              {"named", one.named},
              {"turned_degrees", one.turned_degrees},
              {"wrong_mattes", one.wrong_mattes},
              {"before", to_json(one.before)},
              {"after", to_json(one.after)}};
    if (one.before.known) {
      const Eigen::Vector3d all = reference.empty() ? one.before.vector : one.before.vector + reference[c];
      j["turn_vector"] = {all.x(), all.y(), all.z()};
    }
    cameras.push_back(std::move(j));
  }
  json misplaced = json::array();
  for (const pipeline::MisplacedCamera& one : check.misplaced)
    misplaced.push_back({{"serial", check.cameras[one.camera].serial},
                         {"stands_at", check.cameras[one.place].serial},
                         {"pictures", pipeline::name_of(one.flip)},
                         {"iou", {{"before", one.iou}, {"after", one.iou_there}}}});
  json out = {{"frames", frames},
              {"cameras", cameras},
              {"misplaced", misplaced},
              {"no_camera_explains_it", check.whole_rig},
              {"usual_degrees", check.usual_degrees},
              {"sentences", pipeline::sentences(check)}};
  if (check.iou_before && check.iou_after)
    out["hull_iou"] = {{"before", *check.iou_before}, {"after", *check.iou_after}};
  return out;
}

void print(const pipeline::SilhouetteCheck& check, double alarm) {
  for (const std::string& sentence : pipeline::sentences(check)) std::printf("%s\n", sentence.c_str());
  if (check.iou_before && check.iou_after)
    std::printf("mean IoU of the hull with the mattes: %.4f before, %.4f after\n", *check.iou_before,
                *check.iou_after);
  for (const pipeline::SilhouetteCameraCheck& c : check.cameras)
    if (!c.before.known)
      std::printf(
          "%s: not measured, because its outlines (%d points) and the others' hull do not hold a turn\n",
          c.serial.c_str(), c.before.points);
  const bool any =
      std::any_of(check.cameras.begin(), check.cameras.end(), [](const auto& c) { return c.named; });
  if (!any && !check.whole_rig && check.misplaced.empty())
    std::printf(
        "no camera is seen to stand otherwise than calibrated by more than %g degrees (usually %.3f)\n",
        alarm, check.usual_degrees);
}

Result<void> save_corrected(const pipeline::SilhouetteCheck& check, const std::filesystem::path& file) {
  const bool mirrored = std::any_of(check.misplaced.begin(), check.misplaced.end(), [](const auto& c) {
    return c.flip == pipeline::PictureFlip::Mirrored || c.flip == pipeline::PictureFlip::MirroredUpsideDown;
  });
  if (mirrored)
    return fail(
        ErrorCode::Unsupported,
        text(file.string(), " is not written: no rig has mirrored pictures; import them mirrored back"));
  if (check.misplaced.empty() &&
      std::none_of(check.cameras.begin(), check.cameras.end(), [](const auto& c) { return c.named; })) {
    std::printf("%s is not written: there is nothing to correct\n", file.c_str());
    return {};
  }
  if (is_there(file))
    return fail(ErrorCode::AlreadyExists,
                text("--out ", file.string(), " is there already; name a new file"));
  return save_rig(check.corrected, file);
}

Result<void> run_silhouettes(const SilhouettesArguments& given) {
  if (!(given.alarm > 0)) return fail(ErrorCode::InvalidArgument, "--alarm must be positive");
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  std::vector<int> frames;
  if (given.frames.empty()) {
    for (int f = 0; f < (*take)->frame_count(); ++f) frames.push_back(f);
    frames = spread(frames);
  } else {
    const Result<std::vector<int>> named = frames_of_take(given.take, given.frames);
    if (!named) return forward(named);
    frames = *named;
  }
  pipeline::SilhouetteCheckOptions options{.alarm_degrees = given.alarm, .threads = given.threads};
  if (!given.reference.empty()) {
    Result<std::vector<Eigen::Vector3d>> reference = load_reference(given.reference, (*take)->rig());
    if (!reference) return forward(reference);
    options.reference = *std::move(reference);
  }
  const Result<std::vector<pipeline::InstantMattes>> instants = load(**take, frames);
  if (!instants) return forward(instants);
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::SilhouetteCheck> check =
      pipeline::check_silhouettes((*take)->rig(), *instants, options);
  if (!check) return forward(check);
  print(*check, given.alarm);
  if (!given.out.empty())
    if (Result<void> ok = save_corrected(*check, given.out); !ok) return ok;
  if (given.json_file.empty()) return {};
  return pipeline::save_json(to_json(*check, options.reference, frames), given.json_file);
}

}  // namespace

void add_calibrate_silhouettes(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<SilhouettesArguments>();
  CLI::App* verb =
      add_verb(calibrate, chosen, "silhouettes",
               "Do the cameras' poses agree with their mattes? Names a camera that has turned, or is another",
               {"floatstage calibrate silhouettes friday",
                "floatstage calibrate silhouettes friday --reference monday.json -o corrected.json"});
  add_take(*verb, options->take);
  add_out(
      *verb, options->out,
      "Write a rig with the named cameras turned, or in their places (a new file; the take keeps its own)");
  verb->add_option("--reference", options->reference,
                   "The --json report of an earlier take when all was well: what changed since is named")
      ->type_name("FILE");
  add_frames(*verb, options->frames, "4, spread over the take");
  verb->add_option("--alarm", options->alarm, "Degrees that a camera is named for")->capture_default_str();
  add_threads(*verb, options->threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_silhouettes(*options); }; });
}

}  // namespace floatstage::apps
