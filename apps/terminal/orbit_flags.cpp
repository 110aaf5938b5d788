#include "apps/terminal/orbit_flags.h"

#include "apps/terminal/flags.h"

namespace floatstage::apps {

void add_orbit_flags(CLI::App& verb, pipeline::OrbitOptions& orbit, CLI::Option* walk) {
  CLI::Option* const options[] = {
      verb.add_option("--height", orbit.height,
                      "Metres that the walk goes above the subject's middle (default: as the cameras stand)")
          ->type_name("M"),
      verb.add_option("--distance", orbit.distance,
                      "Metres from the axis that it goes around (default: where the cameras stand)")
          ->check(CLI::PositiveNumber)
          ->type_name("M"),
      verb.add_option("--fov", orbit.fov,
                      "Its view's height in degrees (default: so much that the subject fits)")
          ->check(CLI::Range(1.0, 150.0))
          ->type_name("DEG"),
      verb.add_option(
              "--turns", orbit.turns,
              "Times around, or there and back where cameras stand on one side only; -1: the other way")
          ->check(CLI::Range(-100.0, 100.0))
          ->capture_default_str()
          ->type_name("N"),
      verb.add_option("--start", orbit.start, "Degrees from the first camera that it begins at")
          ->check(CLI::Range(-360.0, 360.0))
          ->capture_default_str()
          ->type_name("DEG")};
  for (CLI::Option* option : options) {
    option->group(kGroupPicture);
    if (walk != nullptr) option->needs(walk);
  }
}

}  // namespace floatstage::apps
