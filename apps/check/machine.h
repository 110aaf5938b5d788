#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace floatstage::apps {

/// One line of `floatstage check`.
struct Finding {
  enum class Verdict { Pass, Warn, Fail } verdict = Verdict::Pass;
  std::string what;  ///< what was looked at, what was found, and (unless it passed) what to do
};

/// Receive buffers that sockets may have: four pictures of `picture_bytes` a camera. `root` is where proc/
/// and sys/ lie: "/", or a test's.
Finding look_at_receive_buffers(const std::filesystem::path& root, std::size_t picture_bytes);
/// Every network interface that is up, but the loopback: its MTU. Jumbo frames halve the work of receiving.
std::vector<Finding> look_at_mtu(const std::filesystem::path& root);
/// Hardware clocks for PTP, and the daemon that keeps them.
Finding look_at_ptp(const std::filesystem::path& root);
/// The kernel's clock source, and whether the system's time is kept by somebody.
std::vector<Finding> look_at_clock(const std::filesystem::path& root);
/// Datagram sockets for the cameras, and files for as many as a studio opens.
Finding look_at_sockets();
/// Whether a TCP port can be served.
Finding look_at_port(const std::string& address, int port, const std::string& whose);
/// A disk's measured speed against what is `needed` in bytes a second (0: not known); `for_whom` says of
/// what.
struct DiskMeasured {
  double bytes_per_second = 0;
  std::uint64_t available_bytes = 0;
};
Finding judge_disk(const std::filesystem::path& folder, const DiskMeasured& disk, double needed,
                   const std::string& for_whom);
/// Measures it: writes 64 MiB into `folder` and flushes.
Finding look_at_disk(const std::filesystem::path& folder, double needed, const std::string& for_whom);

}  // namespace floatstage::apps
