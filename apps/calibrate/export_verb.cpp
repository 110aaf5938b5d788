#include <algorithm>
#include <filesystem>
#include <functional>

#include "apps/calibrate/calibrate_verbs.h"
#include "calib/rig_formats.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

struct Options {
  std::filesystem::path rig, out;
  std::string format, pictures = "png";
};

using Names = std::vector<std::string>;
using Write = std::function<Result<void>(const Rig&, const Names&, const std::filesystem::path&)>;

struct Format {
  const char* name;
  const char* writes;
  Write write;
};

// Those that carry no names of pictures.
template <auto kWrite>
Result<void> nameless(const Rig& rig, const Names&, const std::filesystem::path& out) {
  return kWrite(rig, out);
}

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {"colmap", "a folder with cameras.txt, images.txt, points3D.txt", calib::write_colmap},
      {"opencv", "a folder with intri.yml and extri.yml, as EasyMocap has them",
       nameless<calib::write_easymocap>},
      {"kalibr", "a camchain .yaml", nameless<calib::write_kalibr>},
      {"middlebury", "a _par.txt", calib::write_middlebury},
      {"qualisys", "a .qca.txt", nameless<calib::write_qualisys>},
  };
  return all;
}

std::string list_of_formats() {
  std::string out;
  for (const Format& f : formats()) out += text(out.empty() ? "" : "; ", f.name, ": ", f.writes);
  return out;
}

Result<void> run(const Options& given) {
  const auto format = std::find_if(formats().begin(), formats().end(),
                                   [&](const Format& f) { return f.name == given.format; });
  if (format == formats().end())
    return fail(ErrorCode::InvalidArgument,
                text("'", given.format, "' is no format that is written; there are ", list_of_formats()));
  if (std::filesystem::exists(given.out))
    return fail(ErrorCode::AlreadyExists,
                text(given.out.string(), ": is there already, and is left as it is; give another --out"));
  const bool take = std::filesystem::is_directory(given.rig);
  const Result<Rig> rig = load_rig(take ? TakeLayout(given.rig).rig() : given.rig);
  if (!rig) return forward(rig);
  Names pictures;
  for (const RigCamera& camera : rig->cameras) pictures.push_back(camera.serial + "." + given.pictures);
  const Result<void> written = format->write(*rig, pictures, given.out);
  std::error_code ignored;
  if (!written) std::filesystem::remove_all(given.out, ignored);  // a folder may be written in part
  return written;
}

}  // namespace

void add_calibrate_export(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = calibrate.add_subcommand("export", "Writes a rig in another program's format");
  verb->add_option("rig", options->rig, "A rig.json, or a take that has one")->required();
  verb->add_option("--format", options->format, list_of_formats())->required();
  verb->add_option("--out", options->out, "The file or folder to write; it must not be there yet")
      ->required();
  verb->add_option("--pictures", options->pictures,
                   "Extension of the pictures' names, which are <serial>.<extension> (COLMAP, Middlebury)")
      ->capture_default_str();
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
