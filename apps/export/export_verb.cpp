#include "apps/export/export_verbs.h"

namespace floatstage::apps {

void add_export(CLI::App& app, Chosen& chosen) {
  CLI::App* verb =
      add_verb(app, chosen, "export", "A processed take in the formats of other programs",
               {"floatstage export colmap take -o project", "floatstage export mesh take -o take.glb"});
  verb->require_subcommand(1);
  add_export_colmap(*verb, chosen);
  add_export_easyvolcap(*verb, chosen);
  add_export_light_field(*verb, chosen);
  add_export_mesh(*verb, chosen);
  add_export_web(*verb, chosen);
}

}  // namespace floatstage::apps
