#include <cstdio>
#include <filesystem>

#include "apps/verbs.h"
#include "studio/network/keys.h"

namespace floatstage::apps {
namespace {

Result<void> run(const std::filesystem::path& file) {
  const Result<studio::wire::StudioKeys> keys = studio::wire::make_keys();
  if (!keys) return forward(keys);
  if (Result<void> saved = studio::wire::save_keys(*keys, file); !saved) return saved;
  std::printf("%s: copy it to the studio's machines, and to no other\n", file.c_str());
  return {};
}

}  // namespace

void add_keys(CLI::App& app, Chosen& chosen) {
  auto file = std::make_shared<std::filesystem::path>();
  CLI::App* verb =
      app.add_subcommand("keys", "Makes the keys with which a studio's machines know one another");
  verb->add_option("--out", *file, "A new file; only its owner can read it")->required();
  verb->callback([file, &chosen] { chosen.run = [file] { return run(*file); }; });
}

}  // namespace floatstage::apps
