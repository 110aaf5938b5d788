#include "apps/check/machine.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/timex.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using Verdict = Finding::Verdict;

constexpr std::size_t kPicturesInSocket = 4;
constexpr int kJumbo = 9000;
constexpr rlim_t kFewFiles = 1024;

// The first line of a file; empty where there is none.
std::string line_of(const fs::path& file) {
  const Result<std::string> bytes = read_file(file);
  return bytes ? bytes->substr(0, bytes->find('\n')) : "";
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool runs(const fs::path& root, const std::string& program) {
  for (const fs::path& process : entries_of(root / "proc"))
    if (line_of(process / "comm") == program) return true;
  return false;
}

std::string megabytes(double bytes) {
  const double mb = bytes / 1e6;
  return text(mb < 10 ? std::round(mb * 10) / 10 : std::round(mb), " MB");
}

}  // namespace

Finding look_at_receive_buffers(const fs::path& root, std::size_t picture_bytes) {
  const std::string line = line_of(root / "proc/sys/net/core/rmem_max");
  if (line.empty())
    return {Verdict::Warn,
            "receive buffers: net.core.rmem_max cannot be read; see `sysctl net.core.rmem_max`"};
  const std::size_t most = std::strtoull(line.c_str(), nullptr, 10);
  const std::size_t wanted = kPicturesInSocket * picture_bytes;
  const std::string what = text("receive buffers: a socket may hold ", megabytes(static_cast<double>(most)));
  if (most >= wanted) return {Verdict::Pass, what};
  return {most < picture_bytes ? Verdict::Fail : Verdict::Warn,
          text(what, ", four pictures of a GigE camera are ", megabytes(static_cast<double>(wanted)),
               ": sysctl -w net.core.rmem_max=", wanted, " (and the same line in /etc/sysctl.d/)")};
}

std::vector<Finding> look_at_mtu(const fs::path& root) {
  std::vector<Finding> findings;
  for (const fs::path& interface : entries_of(root / "sys/class/net")) {
    const std::string name = interface.filename().string();
    if (name == "lo" || line_of(interface / "operstate") != "up") continue;
    const int mtu = std::atoi(line_of(interface / "mtu").c_str());
    const std::string speed = line_of(interface / "speed");
    const std::string what = text("network: ", name, ", packets of ", mtu, " bytes",
                                  speed.empty() || speed[0] == '-' ? "" : text(", ", speed, " Mbit/s"));
    findings.push_back(
        mtu >= kJumbo
            ? Finding{Verdict::Pass, what}
            : Finding{Verdict::Warn, text(what,
                                          "; where GigE cameras are on it, let them send jumbo frames: "
                                          "ip link set dev ",
                                          name, " mtu ", kJumbo, " (and on the switch)")});
  }
  if (findings.empty())
    findings.push_back(
        {Verdict::Warn,
         "network: no interface but the loopback is up; GigE cameras need one, V4L2 cameras do not"});
  return findings;
}

Finding look_at_ptp(const fs::path& root) {
  std::string clocks;
  for (const fs::path& clock : entries_of(root / "sys/class/ptp"))
    clocks +=
        text(clocks.empty() ? "" : ", ", clock.filename().string(), " (", line_of(clock / "clock_name"), ")");
  if (clocks.empty())
    return {Verdict::Warn,
            "PTP: no network card has a hardware clock; camera clocks are fitted to arrivals instead (about "
            "1 ms): "
            "trigger the cameras by wire, or use a card with one (Intel i210, i225, X710)"};
  if (!runs(root, "ptp4l"))
    return {Verdict::Warn,
            text("PTP: ", clocks,
                 ", and no ptp4l runs: apt install linuxptp; ptp4l -i <interface> -m, then phc2sys -a -r")};
  return {Verdict::Pass, text("PTP: ", clocks, ", kept by ptp4l")};
}

std::vector<Finding> look_at_clock(const fs::path& root) {
  std::vector<Finding> findings;
  const std::string source =
      line_of(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  const bool slow = source == "hpet" || source == "acpi_pm" || source == "jiffies";
  findings.push_back(
      {slow ? Verdict::Warn : Verdict::Pass,
       text("clock: the kernel counts by ", source.empty() ? "an unknown source" : source,
            slow ? ", which is slow to read; see `dmesg | grep -i tsc` for why it is not tsc" : "")});
  timex state = {};
  const int kept = ::adjtimex(&state);
  const bool unkept = kept == TIME_ERROR || (state.status & STA_UNSYNC) != 0;
  findings.push_back(unkept ? Finding{Verdict::Warn,
                                      "clock: nobody keeps the system's time; takes of several machines will "
                                      "not agree: apt install chrony"}
                            : Finding{Verdict::Pass, "clock: the system's time is kept"});
  return findings;
}

Finding look_at_sockets() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0)
    return {Verdict::Fail,
            text("sockets: none can be opened (", std::strerror(errno), "); is this program confined?")};
  ::close(fd);
  rlimit files = {};
  ::getrlimit(RLIMIT_NOFILE, &files);
  const std::string what = text("sockets: this program may open ", files.rlim_cur, " files");
  if (files.rlim_cur < kFewFiles)
    return {Verdict::Warn, text(what, "; a studio of many cameras needs more: ulimit -n ", 4 * kFewFiles)};
  return {Verdict::Pass, what};
}

Finding look_at_port(const std::string& address, int port, const std::string& whose) {
  const std::string what = text("port: ", address, ":", port, " for ", whose);
  sockaddr_in there = {};
  there.sin_family = AF_INET;
  there.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, address.c_str(), &there.sin_addr) != 1)
    return {Verdict::Warn, what + " is not looked at: it is no IPv4 address"};
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const bool free = fd >= 0 && ::bind(fd, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0 &&
                    ::listen(fd, 1) == 0;
  const int error = errno;
  if (fd >= 0) ::close(fd);
  if (free) return {Verdict::Pass, what + " is free"};
  return {Verdict::Fail, text(what, " cannot be served (", std::strerror(error),
                              "); `ss -ltnp` says who has it, or choose another")};
}

// Measured, because a promise of a disk's maker is not a number.
Finding look_at_disk(const fs::path& folder, double needed, const std::string& for_whom) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error)
    return {Verdict::Fail, text("disk: cannot look at ", folder.string(), ": ", error.message(),
                                "; name a folder with --folder")};
  constexpr std::size_t kProbe = std::size_t{64} << 20;
  const fs::path file = folder / "floatstage-disk-check.bin";
  const auto begin = std::chrono::steady_clock::now();
  const Result<void> written = write_file(file, std::string(kProbe, '\x5a'));
  if (const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC); fd >= 0) {
    ::fsync(fd);
    ::close(fd);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fs::remove(file, error);
  if (!written) return {Verdict::Fail, "disk: " + written.error().message};
  return judge_disk(folder, {static_cast<double>(kProbe) / seconds, space.available}, needed, for_whom);
}

Finding judge_disk(const fs::path& folder, const DiskMeasured& disk, double needed,
                   const std::string& for_whom) {
  constexpr double kMargin = 1.5, kLittle = 10 * 60;
  const auto available = static_cast<double>(disk.available_bytes);
  const std::string what = text("disk: ", folder.string(), " writes ", megabytes(disk.bytes_per_second),
                                " a second, ", static_cast<int>(available / 1e9), " GB free");
  const std::string need = text("; ", for_whom, " need ", megabytes(needed), " a second");
  if (disk.bytes_per_second < needed)
    return {Verdict::Fail, text(what, need, ": record to a faster disk, or fewer or smaller pictures")};
  if (disk.bytes_per_second < kMargin * needed)
    return {Verdict::Warn,
            text(what, need, ": that is close; a faster disk leaves room for its bad moments")};
  const double lasts = needed > 0 ? available / needed : 1e9;
  if (lasts < kLittle)
    return {Verdict::Warn,
            text(what, need, ": it is full after ", static_cast<int>(lasts / 60), " minutes, make room")};
  return {Verdict::Pass, what + need};
}

}  // namespace floatstage::apps
