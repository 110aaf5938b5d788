#pragma once

#include <filesystem>
#include <string>

#include "tests/support/temp_folder.h"

namespace floatstage::capture {

/// Features that Aravis' fake camera has not got: a GenICam description, for FakeGigeCamera, that promises
/// them besides its own, over registers of its memory that nothing else uses. Starts a camera for a moment on
/// 127.0.0.1 to ask for its own.
std::filesystem::path described_with(const std::string& features, const TempFolder& folder);

/// PTP whose status is Listening until a register is 1, and Slave from then on: "Enable" is what PtpEnable
/// writes, "Latch" what PtpDataSetLatch writes, and "Never" nobody writes.
std::string ptp_features(const std::string& follows);

/// White balance as a ratio, 0.5 to 4, of each of three channels behind one selector.
std::string white_balance_features();

}  // namespace floatstage::capture
