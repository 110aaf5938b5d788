#pragma once

#include <functional>
#include <string>

#include "core/time.h"

namespace floatstage::capture {

enum class Knock { Answered, Silence, Stopped };

/// Whether a GigE Vision device is at an IPv4 address: asks it who it is (GVCP's DISCOVERY_CMD, GigE
/// Vision 2.0, section 14.1, which every device answers, whoever controls it) five times a second, for as
/// long as `patience` or until `stop` says yes. Answered, too, for what is no such address: then its library
/// may know better. Aravis itself waits some seconds for a device that is not there, and nobody can tell it
/// not to.
Knock knock(const std::string& address, Nanoseconds patience, const std::function<bool()>& stop);

}  // namespace floatstage::capture
