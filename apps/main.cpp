#include <cstdio>
#include <exception>

#include <malloc.h>

#include "apps/command_line.h"
#include "apps/plan/planned.h"
#include "apps/terminal/exit_codes.h"
#include "apps/terminal/interrupt.h"
#include "core/log.h"

namespace {

// Pictures come and go by the megabyte, on all threads. What they leave is used by the next ones, and not
// given back to the system to be asked for again, page by page (docs/adr/0319).
void keep_freed_memory() {
  constexpr int kOfItsOwn = 32 << 20, kKept = 256 << 20;  // bytes: of one block, and free ones in all
  ::mallopt(M_MMAP_THRESHOLD, kOfItsOwn);
  ::mallopt(M_TRIM_THRESHOLD, kKept);
}

int run(const std::vector<std::string>& words) {
  using namespace floatstage;
  apps::Chosen chosen;
  const std::unique_ptr<CLI::App> app = apps::command_line(chosen);
  if (const std::optional<apps::Ending> ending = apps::read_command_line(*app, words)) {
    std::fputs(ending->output.c_str(), stdout);
    if (!ending->error.empty()) std::fprintf(stderr, "%s\n", ending->error.c_str());
    return ending->code;
  }
  if (apps::PlannedRun* verb = chosen.run.target<apps::PlannedRun>()) verb->words = words;
  log::set_level(chosen.verbose ? log::Level::Debug : chosen.quiet ? log::Level::Warning : log::Level::Info);
  apps::watch_for_interrupts();
  const Result<void> result = chosen.run();
  if (result) return apps::kExitOk;
  std::fflush(stdout);  // into one file or pipe, too, the sentence stands last
  std::fprintf(stderr, "floatstage: %s\n", result.error().message.c_str());
  return apps::exit_code(result.error().code);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    keep_freed_memory();
    return run({argv + (argc > 0), argv + argc});
  } catch (
      const std::exception& e) {  // CheckFailure, out of memory: nothing that a user's input should cause
    std::fprintf(stderr, "floatstage: internal error: %s\n", e.what());
    return floatstage::apps::kExitBug;
  }
}
