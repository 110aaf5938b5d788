#pragma once

namespace floatstage {

/// A network of this process's own: nothing but a loopback, with as many addresses as a test needs. What
/// other programs and other tests send stays outside.
///
/// Moves the calling thread, and every thread and process it begins from then on, into a new network
/// namespace; there is no way back. Without root a user namespace comes first, which needs a process of one
/// thread. False when the system does not allow it.
bool enter_own_network();

/// Takes the loopback of this process's own network down, as a cable that is pulled, and up again.
bool set_loopback(bool up);

/// Gives the loopback the address 127.0.0.`number`, 2…254 (127.0.0.1 is there already).
bool add_loopback_address(int number);

}  // namespace floatstage
