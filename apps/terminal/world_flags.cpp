#include "apps/terminal/world_flags.h"

#include "apps/terminal/flags.h"

namespace floatstage::apps {

void add_world_flags(CLI::App& verb, pipeline::WorldOptions& world) {
  verb.add_option("--up", world.up,
                  "What is up in its world: an axis, or ring: as the cameras stand around (default: z)")
      ->check(one_of(pipeline::up_names()))
      ->type_name("AXIS");
  verb.add_option("--scale", world.scale, "Metres that one of its lengths is (default: 1)")
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  verb.add_option("--floor", world.floor,
                  "Height along up, in metres, at which the floor lies: it becomes z = 0 (default: 0)")
      ->type_name("Z");
}

}  // namespace floatstage::apps
