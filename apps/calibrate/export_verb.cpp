#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/did_you_mean.h"
#include "apps/flags.h"
#include "calib/rig_formats.h"
#include "core/file_presence.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct Options {
  std::filesystem::path rig, out, json;
  std::string format, pictures = "png";
};

std::string list_of_formats() {
  std::string out;
  for (const calib::RigFormat& f : calib::rig_formats())
    if (f.write) out += text(out.empty() ? "" : "; ", f.name, ": ", f.written);
  return out;
}

std::vector<std::string> names_of_formats() {
  std::vector<std::string> names;
  for (const calib::RigFormat& f : calib::rig_formats())
    if (f.write) names.emplace_back(f.name);
  return names;
}

Result<void> run(const Options& given) {
  const auto formats = calib::rig_formats();
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const calib::RigFormat& f) {
    return f.write && f.name == given.format;
  });
  if (format == formats.end())
    return fail(ErrorCode::InvalidArgument,
                text("'", given.format, "' is no format that is written; there are ", list_of_formats(),
                     did_you_mean(given.format, names_of_formats())));
  if (is_there(given.out))
    return fail(ErrorCode::AlreadyExists,
                text(given.out.string(), ": is there already, and is left as it is; give another --out"));
  const bool take = is_folder(given.rig);
  const Result<Rig> rig = load_rig(take ? TakeLayout(given.rig).rig() : given.rig);
  if (!rig) return forward(rig);
  std::vector<std::string> pictures;
  for (const RigCamera& camera : rig->cameras) pictures.push_back(camera.serial + "." + given.pictures);
  const Result<void> written = format->write(*rig, pictures, given.out);
  std::error_code ignored;
  if (!written) std::filesystem::remove_all(given.out, ignored);  // a folder may be written in part
  if (!written || given.json.empty()) return written;
  return pipeline::save_json(
      {{"out", given.out.string()}, {"format", given.format}, {"cameras", rig->cameras.size()}}, given.json);
}

}  // namespace

void add_calibrate_export(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = add_verb(calibrate, chosen, "export", "Writes a rig in another program's format",
                            {"floatstage calibrate export rig.json --format colmap -o model",
                             "floatstage calibrate export take --format kalibr -o camchain.yaml"});
  verb->add_option("rig", options->rig, "A rig.json, or a take that has one")->required();
  verb->add_option("--format", options->format, list_of_formats())->required()->type_name("FORMAT");
  add_out(*verb, options->out, "The file or folder to write; it must not be there yet")->required();
  verb->add_option("--pictures", options->pictures,
                   "Extension of the pictures' names, which are <serial>.<extension> (COLMAP, Middlebury)")
      ->capture_default_str();
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
