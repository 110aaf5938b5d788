#include "tests/support/network_lab.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/run_command.h"

namespace floatstage {
namespace {

bool shell(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

// A clock of its own for the program that comes next; one that stays as it is where that is not allowed.
void move_monotonic_clock(int seconds) {
  constexpr int kNewTime = 0x80;  // CLONE_NEWTIME; old headers do not name it
  if (seconds == 0 || ::unshare(kNewTime) != 0) return;
  const std::string offset = "monotonic " + std::to_string(seconds) + " 0\n";
  const int fd = ::open("/proc/self/timens_offsets", O_WRONLY | O_CLOEXEC);
  [[maybe_unused]] const ssize_t written = ::write(fd, offset.data(), offset.size());
  ::close(fd);
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments, const std::string& log, int uptime)
    : log_(log) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ != 0) return;
  const int fd = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(fd, STDOUT_FILENO);
  ::dup2(fd, STDERR_FILENO);
  move_monotonic_clock(uptime);
  ::execvp(argv[0], argv.data());
  ::_exit(127);
}

RunningProgram::~RunningProgram() {
  kill();
  wait();
}

void RunningProgram::kill() {
  if (pid_ > 0) ::kill(pid_, SIGKILL);
}

void RunningProgram::terminate() {
  if (pid_ > 0) ::kill(pid_, SIGTERM);
}

int RunningProgram::wait() {
  if (pid_ > 0) ::waitpid(pid_, &status_, 0);
  pid_ = -1;
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
}

bool RunningProgram::catches(int signal) const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string word; status >> word;) {
    if (word != "SigCgt:") continue;
    std::uint64_t mask = 0;
    status >> std::hex >> mask;
    return mask >> (signal - 1) & 1;
  }
  return false;
}

bool RunningProgram::running() {
  if (pid_ > 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
  return pid_ > 0;
}

std::string RunningProgram::output() const {
  std::ostringstream out;
  out << std::ifstream(log_).rdbuf();
  return out.str();
}

std::string NetworkLab::forbidden() {
  if (::geteuid() != 0) return "machines of a network of their own take root";
  if (!shell("ip -V")) return "machines of a network of their own take the program `ip`";
  const pid_t child = ::fork();
  if (child == 0) ::_exit(::unshare(CLONE_NEWNET | CLONE_NEWNS) == 0 ? 0 : 1);
  int status = 1;
  ::waitpid(child, &status, 0);
  return status == 0 ? "" : "the system does not allow network namespaces";
}

std::unique_ptr<NetworkLab> NetworkLab::with_machines(int count) {
  std::unique_ptr<NetworkLab> lab(new NetworkLab);
  return lab->make(count) ? std::move(lab) : nullptr;
}

bool NetworkLab::make(int count) {
  prefix_ = "fs" + std::to_string(::getpid()) + "-";
  const std::string hub = prefix_ + "switch";
  if (!shell("ip netns add " + hub)) return false;
  if (!shell("ip -n " + hub + " link add switch type bridge") ||
      !shell("ip -n " + hub + " link set switch up"))
    return false;
  for (int m = 0; m < count; ++m) {
    if (!shell("ip netns add " + name(m))) return false;
    ++machines_;
    const std::string port = "port" + std::to_string(m);
    const bool plugged =
        shell("ip -n " + name(m) + " link add eth0 type veth peer name " + port + " netns " + hub) &&
        shell("ip -n " + name(m) + " addr add " + address(m) + "/24 dev eth0") &&
        shell("ip -n " + name(m) + " link set lo up") && shell("ip -n " + name(m) + " link set eth0 up") &&
        shell("ip -n " + hub + " link set " + port + " master switch up");
    if (!plugged) return false;
  }
  return true;
}

NetworkLab::~NetworkLab() {
  for (int m = 0; m < machines_; ++m) shell("ip netns del " + name(m));
  if (!prefix_.empty()) shell("ip netns del " + prefix_ + "switch");
}

std::string NetworkLab::name(int machine) const { return prefix_ + std::to_string(machine); }
std::string NetworkLab::address(int machine) const { return "10.77.0." + std::to_string(machine + 1); }

std::unique_ptr<RunningProgram> NetworkLab::run(int machine, std::vector<std::string> arguments,
                                                const std::string& log) const {
  std::vector<std::string> inside = {"ip", "netns", "exec", name(machine)};
  inside.insert(inside.end(), arguments.begin(), arguments.end());
  constexpr int kHours = 3600;
  return std::make_unique<RunningProgram>(inside, log, (machine + 1) * kHours);
}

bool NetworkLab::enter(int machine) const {
  const int fd = ::open(("/run/netns/" + name(machine)).c_str(), O_RDONLY | O_CLOEXEC);
  const bool entered = fd >= 0 && ::setns(fd, CLONE_NEWNET) == 0;
  if (fd >= 0) ::close(fd);
  return entered;
}

// The switch counts what comes from a machine and what goes to it.
std::uint64_t NetworkLab::statistic(int machine, const std::string& which) const {
  const std::string command = "ip netns exec " + prefix_ + "switch cat /sys/class/net/port" +
                              std::to_string(machine) + "/statistics/" + which;
  return std::strtoull(run_command(command).output.c_str(), nullptr, 10);
}

std::uint64_t NetworkLab::sent_bytes(int machine) const { return statistic(machine, "rx_bytes"); }
std::uint64_t NetworkLab::received_bytes(int machine) const { return statistic(machine, "tx_bytes"); }

void NetworkLab::shrink_send_buffers(int machine) const {
  shell("ip netns exec " + name(machine) + " sh -c 'echo 4096 16384 16384 > /proc/sys/net/ipv4/tcp_wmem'");
}

void NetworkLab::cut(int machine) const {
  shell("ip -n " + prefix_ + "switch link set port" + std::to_string(machine) + " down");
}

void NetworkLab::mend(int machine) const {
  shell("ip -n " + prefix_ + "switch link set port" + std::to_string(machine) + " up");
}

}  // namespace floatstage
