#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <sys/types.h>

#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage {

/// A Slurm cluster of two machines, node1 and node2, of which each is a namespace of this one: with processes
/// of its own, which end with it, and a disk of its own at scratch(). Debian's slurmctld, slurmd and munged,
/// with keys, ports and folders of their own, beside a cluster that may be there. Takes root's rights.
class SlurmLab {
 public:
  /// `room`: bytes of a node's disk, by name; else 64 MB.
  explicit SlurmLab(const std::map<std::string, int>& room = {});
  ~SlurmLab();
  SlurmLab(const SlurmLab&) = delete;
  SlurmLab& operator=(const SlurmLab&) = delete;

  /// Whether both machines are there to work.
  bool is_up() const;
  /// A command of a user's on this cluster.
  Ended run(const std::string& command) const;
  /// As if somebody pulled the plug.
  void kill_node(const std::string& name);
  /// Where a node's own disk is, by the same name on each.
  std::filesystem::path scratch() const { return folder_ / "scratch"; }
  /// What the daemons said, for who wonders.
  std::string logs() const;

 private:
  void write_configuration() const;
  pid_t start(const std::string& command) const;

  TempFolder folder_;
  std::map<std::string, pid_t> nodes_;
  pid_t munged_ = -1, controller_ = -1;
};

}  // namespace floatstage
