#include "apps/terminal/flags.h"

#include <algorithm>

#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/joined.h"
#include "apps/terminal/text_options.h"
#include "core/text.h"
#include "matting/keyers/keyer.h"
#include "pipeline/matte/matte_how.h"
#include "render/renderer.h"

namespace floatstage::apps {
namespace {

constexpr int kMostThreads = 1024, kMostCameras = 1000, kMostFrames = 1000000;

const std::vector<std::string>& codec_names() {
  static const std::vector<std::string> names = {"ffv1", "raw", "h264"};
  return names;
}
constexpr capture::TakeCodec kCodecs[] = {capture::TakeCodec::Ffv1, capture::TakeCodec::Raw,
                                          capture::TakeCodec::H264};

// Why `word` is none of `words`, or nothing.
std::string fault_of(const std::string& word, const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), word) != words.end()) return "";
  return text("'", word, "' is none of ", joined(words, ", "), did_you_mean(word, words));
}

}  // namespace

std::vector<std::string> option_groups() {
  return {kGroupCommon, kGroupHull,    kGroupCleanup, kGroupPicture, kGroupWindow,
          kGroupMattes, kGroupDefects, kGroupPlan,    kGroupRun,     kGroupTuning};
}

CLI::Option* add_take(CLI::App& verb, std::filesystem::path& take, const std::string& help) {
  return verb.add_option("take", take, help)->required()->type_name("TAKE");
}

CLI::Option* add_out(CLI::App& verb, std::filesystem::path& out, const std::string& help) {
  return verb.add_option("-o,--out", out, help)->type_name("PATH");
}

CLI::Option* add_json(CLI::App& verb, std::filesystem::path& file) {
  return verb.add_option("--json", file, "Write a report for machines to this file")
      ->type_name("FILE")
      ->group(kGroupRun);
}

CLI::Option* add_threads(CLI::App& verb, int& threads) {
  return verb.add_option("-j,--threads", threads, "Threads; 0: one per core")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(0, kMostThreads).description(""))
      ->group(kGroupRun);
}

CLI::Option* add_cameras(CLI::App& verb, std::vector<std::string>& serials, const std::string& help) {
  return add_list(verb, "--cameras", serials, help + " (default: all)");
}

CLI::Option* add_camera_count(CLI::App& verb, int& count, int fewest) {
  return verb.add_option("--camera-count", count, "Cameras around the stage")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(fewest, kMostCameras).description(""));
}

CLI::Option* add_frames(CLI::App& verb, std::string& frames, const std::string& otherwise) {
  return verb
      .add_option("--frames", frames,
                  text("Which frames: 5, 2:10 or 2:10:4, the end not included (default: ", otherwise, ")"))
      ->type_name("A:B[:STEP]");
}

CLI::Option* add_frame_count(CLI::App& verb, int& count, const std::string& help) {
  return verb.add_option("--frame-count", count, help)
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(1, kMostFrames).description(""));
}

CLI::Option* add_size(CLI::App& verb, Size& size, const std::string& help, const std::string& name) {
  return verb
      .add_option_function<std::string>(
          name,
          [&size, name](const std::string& word) {
            const Result<std::pair<int, int>> parsed = parse_size(word);
            if (!parsed) throw CLI::ValidationError(name, parsed.error().message);
            std::tie(size.width, size.height) = *parsed;
          },
          help)
      ->default_str(text(size.width, "x", size.height))
      ->type_name("WxH");
}

CLI::Option* add_fps(CLI::App& verb, double& fps, const std::string& help) {
  CLI::Option* option = verb.add_option("--fps", fps, help)
                            ->type_name("N")
                            ->check(CLI::Validator(CLI::PositiveNumber).description(""));
  return fps > 0 ? option->capture_default_str() : option;
}

CLI::Option* add_seconds(CLI::App& verb, double& seconds, const std::string& help) {
  return verb.add_option("--seconds", seconds, help)
      ->type_name("S")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""));
}

CLI::Option* add_blend(CLI::App& verb, int& photographs) {
  return verb
      .add_option("--blend", photographs, "Photographs blended in a view, and others that are as near")
      ->capture_default_str()
      ->type_name("K")
      ->group(kGroupPicture);
}

CLI::Option* add_background(CLI::App& verb, std::string& color) {
  return verb.add_option("--background", color, "Colour behind the performer")
      ->capture_default_str()
      ->type_name("RRGGBB")
      ->group(kGroupPicture);
}

CLI::Option* add_codec(CLI::App& verb, capture::TakeCodec& codec) {
  const auto set = [&codec](const std::string& name) { codec = kCodecs[place_of(codec_names(), name)]; };
  const auto now = std::find(std::begin(kCodecs), std::end(kCodecs), codec) - std::begin(kCodecs);
  return verb.add_option_function<std::string>("--codec", set, "Media codec of the take")
      ->default_str(codec_names()[static_cast<std::size_t>(now)])
      ->check(one_of(codec_names()));
}

CLI::Option* add_redo(CLI::App& verb, bool& redo) {
  return verb.add_flag("--redo", redo,
                       "Make again what Floatstage made, with these options; files of unknown origin stay");
}

CLI::Option* add_added(CLI::App& verb, std::optional<bool>& hide) {
  return verb
      .add_option_function<std::string>(
          "--added", [&hide](const std::string& word) { hide = word == "hide"; },
          "Bars, time stamps and logos that cameras and converters added to pictures: look for them and hide "
          "them, or keep pictures as they are (default: as before, else hide)")
      ->type_name("HOW")
      ->check(one_of({"hide", "keep"}));
}

Result<std::vector<int>> frames_of_take(const std::filesystem::path& take, const std::string& frames) {
  const Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take);
  if (!opened) return forward(opened);
  return parse_frames(frames, (*opened)->frame_count());
}

CLI::Option* add_matte_how(CLI::App& verb, std::string& how, const std::string& usual) {
  std::vector<std::string> names;
  std::string help = text("How mattes are made (default: ", usual, "):");
  for (const pipeline::MatteMethod& m : pipeline::matte_methods()) {
    help += "\n  " + (m.keyer ? m.help : m.name + ": " + m.help);
    names.push_back(m.name);
  }
  const auto fault = [names](const std::string& word) {
    const Result<void> ok = pipeline::check_matte_how(word);
    return ok ? "" : ok.error().message + did_you_mean(pipeline::method_name(word), names);
  };
  return verb.add_option("--matte", how, help)->type_name("HOW")->check(CLI::Validator(fault, ""));
}

CLI::Option* add_matte_keyer(CLI::App& verb, std::string& keyer) {
  std::vector<std::string> names{"auto"};
  std::string help =
      "How the subject is keyed, picture by picture:\n  auto: each camera by what it shows: cloth, else its "
      "clean plate, else a black stage";
  for (const matting::KeyerInfo& k : matting::keyers()) help += "\n  " + k.help, names.push_back(k.name);
  const auto fault = [names](const std::string& word) {
    return fault_of(pipeline::method_name(word), names);
  };
  return verb.add_option("--matte", keyer, help)
      ->capture_default_str()
      ->type_name("HOW")
      ->check(CLI::Validator(fault, ""));
}

CLI::Option* add_guide(CLI::App& verb, std::filesystem::path& folder) {
  return verb
      .add_option("--guide", folder,
                  "Others' mattes to start from: a folder with <serial>/<frame>.png; of a clip (matte) a PNG "
                  "of its first frame or a folder of PNGs")
      ->type_name("PATH");
}

CLI::Option* add_list(CLI::App& verb, const std::string& name, std::vector<std::string>& list,
                      const std::string& help, const std::vector<std::string>& known) {
  const auto set = [&list, name, known](const std::string& word) {
    list = split_list(word);
    if (list.empty()) throw CLI::ValidationError(name, "names nothing; write a,b,c");
    if (known.empty()) return;
    for (const std::string& part : list)
      if (const std::string fault = fault_of(part, known); !fault.empty())
        throw CLI::ValidationError(name, fault);
  };
  CLI::Option* option = verb.add_option_function<std::string>(name, set, help)->type_name("A,B,C");
  return list.empty() ? option : option->default_str(joined(list, ","));
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  return CLI::Validator([words](std::string& word) { return fault_of(word, words); },
                        text("{", joined(words, ","), "}"));
}

std::size_t place_of(const std::vector<std::string>& words, const std::string& word) {
  return static_cast<std::size_t>(std::find(words.begin(), words.end(), word) - words.begin());
}

std::vector<std::string> renderer_names() {
  std::vector<std::string> names;
  for (const render::RendererInfo& r : render::renderers()) names.push_back(r.name);
  return names;
}

}  // namespace floatstage::apps
