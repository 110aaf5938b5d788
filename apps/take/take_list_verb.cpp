#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct TakeListArguments {
  fs::path folder, thumbnails, json;
};

constexpr int kThumbnailWidth = 320;

// A picture for each take that has one; where it has none, nothing is said that the table does not say.
Result<void> save_thumbnails(const TakeListArguments& given, const std::vector<pipeline::ListedTake>& takes) {
  if (Result<void> ok = make_folder(given.thumbnails); !ok) return ok;
  for (const pipeline::ListedTake& take : takes) {
    if (!take.opens) continue;
    const fs::path folder =
        takes.size() == 1 && take.name == given.folder.string() ? given.folder : given.folder / take.name;
    const Result<std::unique_ptr<capture::TakeReader>> reader = capture::TakeReader::open(folder);
    if (!reader) return forward(reader);
    const Result<Image> picture = pipeline::thumbnail(**reader, kThumbnailWidth);
    if (!picture && picture.error().code == ErrorCode::NotFound) continue;
    if (!picture) return forward(picture);
    const std::string name = fs::path(take.name).lexically_normal().filename().string();
    if (Result<void> ok = save_png(*picture, given.thumbnails / ((name.empty() ? "take" : name) + ".png"));
        !ok)
      return ok;
  }
  return {};
}

Result<void> run_take_list(const TakeListArguments& given) {
  const Result<std::vector<pipeline::ListedTake>> takes = pipeline::list_takes(given.folder);
  if (!takes) return forward(takes);
  std::printf("%-28s %-20s %7s %7s %8s %9s %7s %7s  %s\n", "take", "recorded", "frames", "cameras", "seconds",
              "MB", "mattes", "hulls", "verdict");
  nlohmann::json rows = nlohmann::json::array();
  for (const pipeline::ListedTake& t : *takes) {
    const pipeline::TakeFacts& f = t.facts;
    std::printf("%-28s %-20s %7d %7d %8.1f %9.1f %7d %7d  %s\n", t.name.c_str(), t.manifest.created.c_str(),
                f.frames, f.cameras, f.seconds, static_cast<double>(f.bytes) / 1e6, f.mattes, f.meshes,
                t.verdict.c_str());
    rows.push_back({{"name", t.name},
                    {"label", t.manifest.label},
                    {"created", t.manifest.created},
                    {"opens", t.opens},
                    {"frames", f.frames},
                    {"cameras", f.cameras},
                    {"seconds", f.seconds},
                    {"bytes", f.bytes},
                    {"mattes", f.mattes},
                    {"meshes", f.meshes},
                    {"verdict", t.verdict}});
  }
  if (takes->empty()) std::printf("no takes in %s\n", given.folder.c_str());
  if (!given.thumbnails.empty())
    if (Result<void> ok = save_thumbnails(given, *takes); !ok) return ok;
  return given.json.empty()
             ? Result<void>()
             : pipeline::save_json({{"folder", given.folder.string()}, {"takes", rows}}, given.json);
}

}  // namespace

void add_take_list(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeListArguments>();
  CLI::App* verb = add_verb(take, chosen, "list", "The takes of a folder: what they hold and their verdicts",
                            {"floatstage take list recordings/",
                             "floatstage take list recordings/ --thumbnails pictures/ --json L.json"});
  verb->add_option("folder", options->folder, "A folder that holds takes")->required();
  verb->add_option("--thumbnails", options->thumbnails, "Write a small picture of each take to this folder")
      ->type_name("FOLDER");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_list(*options); }; });
}

}  // namespace floatstage::apps
