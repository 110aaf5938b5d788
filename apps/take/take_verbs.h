#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// `take`.
void add_take_verb(CLI::App& app, Chosen& chosen);

// Its sub-verbs that have files of their own.

/// set-rig, set-times, trim, join: new takes of old ones.
void add_take_derivations(CLI::App& take, Chosen& chosen);
/// set-world: the same cameras in another world.
void add_take_set_world(CLI::App& take, Chosen& chosen);
/// set-time-code: the same recording with time code.
void add_take_set_time_code(CLI::App& take, Chosen& chosen);
/// set-sound: the same recording with another recorder's sound.
void add_take_set_sound(CLI::App& take, Chosen& chosen);
/// undistort: the same recording with straight pictures.
void add_take_undistort(CLI::App& take, Chosen& chosen);
/// add-detail: one instant with the details of close stills.
void add_take_add_detail(CLI::App& take, Chosen& chosen);
/// list: the takes of a folder.
void add_take_list(CLI::App& take, Chosen& chosen);

}  // namespace floatstage::apps
