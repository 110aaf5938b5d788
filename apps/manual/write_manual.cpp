// Writes the manual pages and the completion script that the package installs: floatstage_manual FOLDER.
#include <cstdio>

#include "apps/command_line.h"
#include "apps/manual/bash_completion.h"
#include "apps/manual/man_page.h"
#include "apps/terminal/exit_codes.h"
#include "apps/terminal/verb_tree.h"
#include "core/file.h"

namespace {

using namespace floatstage;

Result<void> write_manual(const std::filesystem::path& folder) {
  apps::Chosen chosen;
  const std::unique_ptr<CLI::App> program = apps::command_line(chosen);
  for (const char* name : {"man1", "completions"})
    if (Result<void> made = make_folder(folder / name); !made) return made;
  for (const CLI::App* verb : apps::verbs_from(*program))
    if (Result<void> ok = write_file(folder / "man1" / apps::man_page_name(*verb), apps::man_page(*verb));
        !ok)
      return ok;
  return write_file(folder / "completions/floatstage", apps::bash_completion(*program));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: floatstage_manual FOLDER\n", stderr);
    return apps::kExitUsage;
  }
  if (const Result<void> written = write_manual(argv[1]); !written) {
    std::fprintf(stderr, "floatstage_manual: %s\n", written.error().message.c_str());
    return apps::exit_code(written.error().code);
  }
  return apps::kExitOk;
}
