#include <cstdio>
#include <exception>

#include "apps/exit_codes.h"
#include "apps/interrupt.h"
#include "apps/verbs.h"
#include "apps/version.h"
#include "core/log.h"

namespace {

// CLI11 only says that a subcommand is required; a user wants to know which word was wrong.
bool names_unknown_verb(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return false;
  std::string verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == argv[1]) return false;
    verbs += " " + verb->get_name();
  }
  std::fprintf(stderr, "floatstage: there is no verb '%s'; there are:%s\n", argv[1], verbs.c_str());
  return true;
}

int run(int argc, char** argv) {
  using namespace floatstage;
  CLI::App app("Floatstage: a multiview capture-and-playback studio with Floating Textures", "floatstage");
  app.set_version_flag("--version", std::string("floatstage ") + kVersion);
  app.require_subcommand(1);
  app.fallthrough();
  bool quiet = false, verbose = false;
  app.add_flag("-q,--quiet", quiet, "Only warnings and errors");
  app.add_flag("-v,--verbose", verbose, "Debug messages too");

  apps::Chosen chosen;
  for (auto add :
       {apps::add_demo, apps::add_capture, apps::add_check, apps::add_calibrate, apps::add_synthesize,
        apps::add_import, apps::add_matte, apps::add_matte_image, apps::add_hull, apps::add_keys,
        apps::add_process, apps::add_render, apps::add_evaluate, apps::add_live, apps::add_play})
    add(app, chosen);

  if (names_unknown_verb(app, argc, argv)) return apps::kExitUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? apps::kExitOk : apps::kExitUsage;
  }
  log::set_level(verbose ? log::Level::Debug : quiet ? log::Level::Warning : log::Level::Info);
  apps::watch_for_interrupts();
  const Result<void> result = chosen.run();
  if (result) return apps::kExitOk;
  std::fprintf(stderr, "floatstage: %s\n", result.error().message.c_str());
  return apps::exit_code(result.error().code);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (
      const std::exception& e) {  // CheckFailure, out of memory: nothing that a user's input should cause
    std::fprintf(stderr, "floatstage: internal error: %s\n", e.what());
    return floatstage::apps::kExitBug;
  }
}
