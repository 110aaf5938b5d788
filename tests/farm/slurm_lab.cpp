#include "tests/farm/slurm_lab.h"

#include <csignal>
#include <fstream>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"
#include "tests/support/eventually.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

constexpr int kRoom = 64 << 20;

// Ports that nobody has at this moment.
std::vector<int> free_ports(int count) {
  std::vector<int> sockets, ports;
  for (int i = 0; i < count; ++i) {
    sockets.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::getsockname(sockets.back(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    ports.push_back(ntohs(address.sin_port));
  }
  for (const int socket : sockets) ::close(socket);
  return ports;
}

}  // namespace

SlurmLab::SlurmLab(const std::map<std::string, int>& room) {
  fs::permissions(folder_.path(), fs::perms::owner_all | fs::perms::others_exec | fs::perms::group_exec);
  for (const char* inside : {"munge", "state", "log", "scratch"}) fs::create_directory(folder_ / inside);
  fs::permissions(folder_ / "munge", fs::perms::owner_all);
  const std::string at = folder_.path().string();
  run_command("dd if=/dev/urandom of=" + at + "/munge/key bs=1024 count=1; chmod 400 " + at + "/munge/key");
  munged_ = start(text("munged --foreground --force --key-file=", at, "/munge/key --socket=", at,
                       "/munge.socket --pid-file=", at, "/munge/pid --log-file=", at,
                       "/munge/log --seed-file=", at, "/munge/seed"));
  write_configuration();
  EXPECT_TRUE(eventually([&] { return fs::exists(folder_ / "munge.socket"); })) << logs();
  controller_ = start("slurmctld -D -c -f " + at + "/slurm.conf");
  for (const char* name : {"node1", "node2"}) {
    const auto given = room.find(name);
    nodes_[name] =
        start(text("unshare --mount --pid --fork --kill-child --mount-proc sh -c 'mount -t tmpfs -o size=",
                   given == room.end() ? kRoom : given->second, " tmpfs ", at,
                   "/scratch && exec slurmd -D -N ", name, " -f ", at, "/slurm.conf'"));
  }
  EXPECT_TRUE(eventually([&] { return is_up(); }, std::chrono::seconds(30))) << logs();
}

SlurmLab::~SlurmLab() {
  run("scancel --user=root");
  for (const auto& [name, pid] : nodes_) kill_node(name);
  for (const pid_t pid : {controller_, munged_}) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
  }
}

void SlurmLab::write_configuration() const {
  const std::vector<int> ports = free_ports(3);
  const std::string at = folder_.path().string();
  std::ofstream(folder_ / "slurm.conf")
      << "ClusterName=lab\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort=" << ports[0]
      << "\nSlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\nAuthInfo=socket="
      << at
      // What was sent to a machine that died is forgotten sooner than after two minutes.
      << "/munge.socket,cred_expire=5\nStateSaveLocation=" << at << "/state\nSlurmdSpoolDir=" << at
      << "/spool-%n\nSlurmctldPidFile=" << at << "/slurmctld.pid\nSlurmdPidFile=" << at
      << "/slurmd-%n.pid\nSlurmctldLogFile=" << at << "/log/slurmctld\nSlurmdLogFile=" << at
      << "/log/slurmd-%n\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\n"
         "MpiDefault=none\nJobAcctGatherType=jobacct_gather/none\nReturnToService=2\nSlurmdTimeout=5\n"
         "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
         "SchedulerParameters=sched_interval=2,sched_min_interval=0\nKillWait=1\n";
  std::ofstream nodes(folder_ / "slurm.conf", std::ios::app);
  for (int i : {1, 2})
    nodes << "NodeName=node" << i
          << " NodeHostname=localhost NodeAddr=127.0.0.1 Port=" << ports[static_cast<std::size_t>(i)]
          << " CPUs=1 RealMemory=100 State=UNKNOWN\n";
  nodes << "PartitionName=all Nodes=node1,node2 Default=YES MaxTime=INFINITE State=UP\n";
}

pid_t SlurmLab::start(const std::string& command) const {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const std::string log = (folder_ / "log/output").string();
  if (::freopen(log.c_str(), "a", stdout) && ::freopen(log.c_str(), "a", stderr))
    ::execl("/bin/sh", "sh", "-c", ("PATH=$PATH:/usr/sbin:/sbin; exec " + command).c_str(),
            static_cast<char*>(nullptr));
  ::_exit(127);
}

bool SlurmLab::is_up() const { return run("sinfo --noheader --format=%T:%D").output == "idle:2\n"; }

Ended SlurmLab::run(const std::string& command) const {
  return run_command("SLURM_CONF=" + (folder_ / "slurm.conf").string() + " " + command);
}

void SlurmLab::kill_node(const std::string& name) {
  pid_t& pid = nodes_.at(name);
  if (pid > 0) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
  }
  pid = -1;
}

std::string SlurmLab::logs() const {
  return run_command("tail -n 30 " + folder_.path().string() + "/log/*").output;
}

}  // namespace floatstage
