#pragma once

namespace floatstage::apps {

/// From now on Ctrl-C, SIGTERM and a closed terminal (SIGHUP) only set a flag that long work asks for between
/// two items; a second one ends the process at once. A reader of our output who goes ends nothing. (The flag
/// is the one global of the program: a signal handler can reach nothing else.)
void watch_for_interrupts();
bool interrupted();

}  // namespace floatstage::apps
