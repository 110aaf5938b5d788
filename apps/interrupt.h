#pragma once

namespace floatstage::apps {

/// From now on Ctrl-C and SIGTERM only set a flag that long work asks for between two items; a second Ctrl-C
/// ends the process at once. (The flag is the one global of the program: a signal handler can reach nothing
/// else.)
void watch_for_interrupts();
bool interrupted();

}  // namespace floatstage::apps
