#include <cstdio>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/matte/matte_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/verb.h"
#include "pipeline/json_report.h"
#include "studio/network/keys.h"

namespace floatstage::apps {
namespace {

struct KeysArguments {
  std::filesystem::path file, json;
};

Result<void> run_keys(const KeysArguments& given) {
  const Result<studio::wire::StudioKeys> keys = studio::wire::make_keys();
  if (!keys) return forward(keys);
  if (Result<void> saved = studio::wire::save_keys(*keys, given.file); !saved) return saved;
  std::printf("%s: copy it to the studio's machines, and to no other\n", given.file.c_str());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"keys", given.file.string()}}, given.json);
}

}  // namespace

void add_keys(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<KeysArguments>();
  CLI::App* verb =
      add_verb(app, chosen, "keys", "Makes the keys with which a studio's machines know one another",
               {"floatstage keys -o studio.keys", "floatstage keys --out /media/stick/studio.keys"});
  add_out(*verb, options->file, "A new file; only its owner can read it")->required();
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_keys(*options); }; });
}

}  // namespace floatstage::apps
