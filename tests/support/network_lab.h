#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

namespace floatstage {

/// A program that was started by a test. Killed when this goes.
class RunningProgram {
 public:
  /// `arguments[0]` is the program's path; standard output and error go to `log`. Its monotonic clock began
  /// `uptime` seconds before this program's, where the system can do that.
  RunningProgram(const std::vector<std::string>& arguments, const std::string& log, int uptime = 0);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  /// SIGKILL: it gets no chance to tidy up.
  void kill();
  /// SIGTERM, as a service manager does.
  void terminate();
  /// Its exit code, or minus the signal that ended it.
  int wait();
  /// Whether it has a handler for a signal by now: before that a SIGTERM ends it as it ends any program.
  bool catches(int signal) const;
  bool running();
  pid_t pid() const { return pid_; }
  /// What it has written so far.
  std::string output() const;

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  const std::string log_;
};

/// Machines on a switch: a network namespace each, with one cable (a veth pair) to a bridge in another. They
/// reach one another at 10.77.0.1, 10.77.0.2, …, and nothing else. No two were switched on at the same time:
/// their programs' monotonic clocks differ by hours.
class NetworkLab {
 public:
  /// Why there can be none here; empty where there can: it takes root, the `ip` program, and namespaces.
  static std::string forbidden();
  /// Null when something fails.
  static std::unique_ptr<NetworkLab> with_machines(int count);
  ~NetworkLab();

  std::string address(int machine) const;  ///< without a port
  /// Starts a program on a machine.
  std::unique_ptr<RunningProgram> run(int machine, std::vector<std::string> arguments,
                                      const std::string& log) const;
  /// Moves the calling thread, and those it begins from now on, to a machine. False when that is not allowed.
  bool enter(int machine) const;
  /// Bytes that have gone through its cable, headers and all.
  std::uint64_t sent_bytes(int machine) const;
  std::uint64_t received_bytes(int machine) const;
  /// From now on connections of a machine hold only some kilobytes on their way out.
  void shrink_send_buffers(int machine) const;
  /// Pulls a machine's cable out, and puts it in again.
  void cut(int machine) const;
  void mend(int machine) const;

 private:
  NetworkLab() = default;
  bool make(int count);
  std::string name(int machine) const;
  std::uint64_t statistic(int machine, const std::string& which) const;

  std::string prefix_;
  int machines_ = 0;
};

}  // namespace floatstage
