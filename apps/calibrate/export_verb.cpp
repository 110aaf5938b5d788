#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/flags.h"
#include "calib/formats/refit.h"
#include "calib/rig_formats.h"
#include "core/file_presence.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/measured_json.h"

namespace floatstage::apps {
namespace {

struct ExportArguments {
  std::filesystem::path rig, out, json;
  std::string format, pictures = "png";
  double largest_residual = 1e-3;  // px: below it nothing that is measured in pictures shows a difference
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

// How far off each camera is that was fitted again, in words and for the report.
nlohmann::json state_residuals(const calib::FittedRig& fitted, const std::string& format) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t c = 0; c < fitted.residual_px.size(); ++c) {
    const std::string& serial = fitted.rig.cameras[c].serial;
    const Measured& residual = fitted.residual_px[c];
    if (residual)
      std::printf("%s: fitted again to what %s holds; at most %.2g px off in its picture\n", serial.c_str(),
                  format.c_str(), *residual);
    nlohmann::json camera = {{"serial", serial}};
    pipeline::put(camera, "residual_px", residual);
    out.push_back(std::move(camera));
  }
  return out;
}

Result<void> run_export(const ExportArguments& given) {
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
  const Result<calib::FittedRig> fitted =
      calib::fit_to_format(*rig, format->holds, format->name, given.largest_residual);
  if (!fitted) return fail(fitted.error().code, text(given.out.string(), ": ", fitted.error().message));
  const Result<void> written = format->write(fitted->rig, pictures, given.out);
  std::error_code ignored;
  if (!written) std::filesystem::remove_all(given.out, ignored);  // a folder may be written in part
  if (!written) return written;
  const nlohmann::json residuals = state_residuals(*fitted, given.format);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"out", given.out.string()},
                              {"format", given.format},
                              {"cameras", rig->cameras.size()},
                              {"residuals", residuals}},
                             given.json);
}

}  // namespace

void add_calibrate_export(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<ExportArguments>();
  CLI::App* verb = add_verb(calibrate, chosen, "export", "Writes a rig in another program's format",
                            {"floatstage calibrate export rig.json --format colmap -o model",
                             "floatstage calibrate export take --format kalibr -o camchain.yaml"});
  verb->add_option("rig", options->rig, "A rig.json, or a take that has one")->required();
  verb->add_option("--format", options->format, list_of_formats())->required()->type_name("FORMAT");
  add_out(*verb, options->out, "The file or folder to write; it must not be there yet")->required();
  verb->add_option("--pictures", options->pictures,
                   "Extension of the pictures' names, which are <serial>.<extension> (COLMAP, Middlebury)")
      ->capture_default_str();
  verb->add_option(
          "--largest-residual", options->largest_residual,
          "Pixels that a camera may be off where the format cannot hold its lens and gets the nearest")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_export(*options); }; });
}

}  // namespace floatstage::apps
