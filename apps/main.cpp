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

  Chosen chosen;
  for (auto add :
       {add_demo, add_capture, add_check, add_calibrate, add_synthesize, add_import, add_matte,
        add_matte_image, add_hull, add_keys, add_process, add_render, add_evaluate, add_live, add_play})
    add(app, chosen);

  if (names_unknown_verb(app, argc, argv)) return kExitUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  log::set_level(verbose ? log::Level::Debug : quiet ? log::Level::Warning : log::Level::Info);
  watch_for_interrupts();
  const Result<void> result = chosen.run();
  if (result) return kExitOk;
  std::fprintf(stderr, "floatstage: %s\n", result.error().message.c_str());
  return exit_code(result.error().code);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (
      const std::exception& e) {  // CheckFailure, out of memory: nothing that a user's input should cause
    std::fprintf(stderr, "floatstage: internal error: %s\n", e.what());
    return floatstage::kExitBug;
  }
}
