#pragma once

namespace floatstage::apps {

/// From now on Ctrl-C, SIGTERM and a closed terminal (SIGHUP) only set a flag that long work asks for between
/// two items; another one, a second later or more, ends the process at once (what comes sooner is the same
/// order from the same sender). A reader of our output who goes ends nothing. (The flag is the one global of
/// the program: a signal handler can reach nothing else.)
void watch_for_interrupts();
bool interrupted();

}  // namespace floatstage::apps
