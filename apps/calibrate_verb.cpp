#include "apps/calibrate_verbs.h"

namespace floatstage {

void add_calibrate(CLI::App& app, Chosen& chosen) {
  CLI::App* verb = app.add_subcommand("calibrate", "Everything about calibrating the studio");
  verb->require_subcommand(1);
  add_calibrate_target(*verb, chosen);
}

}  // namespace floatstage
