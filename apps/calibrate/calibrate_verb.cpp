#include "apps/calibrate/calibrate_verbs.h"

namespace floatstage::apps {

void add_calibrate(CLI::App& app, Chosen& chosen) {
  CLI::App* verb = add_verb(app, chosen, "calibrate",
                            "Cameras from pictures of a target: intrinsics, poses, and how good they are",
                            {"floatstage calibrate session.toml -o rig.json --report report",
                             "floatstage calibrate session.toml --from yesterday.json -o rig.json"});
  verb->require_subcommand(0, 1);
  add_calibrate_session(*verb, chosen);
  add_calibrate_color(*verb, chosen);
  add_calibrate_drift(*verb, chosen);
  add_calibrate_export(*verb, chosen);
  add_calibrate_live(*verb, chosen);
  add_calibrate_new(*verb, chosen);
  add_calibrate_silhouettes(*verb, chosen);
  add_calibrate_target(*verb, chosen);
  add_calibrate_times(*verb, chosen);
}

}  // namespace floatstage::apps
