#include "core/confined_rules.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/file_descriptor.h"

namespace floatstage {
namespace {

// What a file system lets one do beyond reading. Debian 12's headers know the first two of Landlock's
// versions; the third has TRUNCATE.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;
constexpr std::uint64_t kChanges = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                                   LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                                   LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                                   LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
                                   LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;

bool give_up_privileges() { return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0; }

// Calls of a decoder, an encoder, a thread and a file. What changes a file by its name without opening it is
// left out (Landlock does not look at modes and times, and at truncate() only from Linux 6.2 on), and clone3:
// glibc then asks clone, whose flags can be looked at.
constexpr std::array kAllowed = {
#ifdef __NR_open  // x86-64 has the older calls too
    __NR_creat,
    __NR_stat,
    __NR_lstat,
    __NR_access,
    __NR_readlink,
    __NR_rename,
    __NR_mkdir,
    __NR_rmdir,
    __NR_unlink,
    __NR_getdents,
    __NR_pipe,
    __NR_dup2,
    __NR_poll,
    __NR_select,
    __NR_time,
    __NR_arch_prctl,
#endif
    __NR_close,
    __NR_read,
    __NR_readv,
    __NR_pread64,
    __NR_preadv,
    __NR_write,
    __NR_writev,
    __NR_pwrite64,
    __NR_pwritev,
    __NR_lseek,
    __NR_fstat,
    __NR_newfstatat,
    __NR_statx,
    __NR_faccessat,
    __NR_faccessat2,
    __NR_readlinkat,
    __NR_getdents64,
    __NR_getcwd,
    __NR_fcntl,
    __NR_flock,
    __NR_fsync,
    __NR_fdatasync,
    __NR_sync_file_range,
    __NR_ftruncate,
    __NR_fallocate,
    __NR_fadvise64,
    __NR_copy_file_range,
    __NR_sendfile,
    __NR_renameat,
    __NR_renameat2,
    __NR_mkdirat,
    __NR_unlinkat,
    __NR_statfs,
    __NR_fstatfs,
    __NR_dup,
    __NR_dup3,
    __NR_pipe2,
    __NR_umask,
    __NR_memfd_create,
    __NR_ppoll,
    __NR_pselect6,
    __NR_eventfd2,  //
    __NR_mmap,
    __NR_munmap,
    __NR_mprotect,
    __NR_mremap,
    __NR_madvise,
    __NR_brk,
    __NR_mincore,
    __NR_mlock,
    __NR_munlock,
    __NR_membarrier,
    __NR_mbind,
    __NR_get_mempolicy,
    __NR_set_mempolicy,  //
    __NR_futex,
    __NR_set_robust_list,
    __NR_get_robust_list,
    __NR_rseq,
    __NR_set_tid_address,
    __NR_sched_yield,
    __NR_sched_getaffinity,
    __NR_sched_setaffinity,
    __NR_sched_getparam,
    __NR_sched_getscheduler,
    __NR_getcpu,
    __NR_getpriority,
    __NR_exit,
    __NR_exit_group,
    __NR_restart_syscall,  //
    __NR_rt_sigaction,
    __NR_rt_sigprocmask,
    __NR_rt_sigreturn,
    __NR_sigaltstack,  //
    __NR_nanosleep,
    __NR_clock_nanosleep,
    __NR_clock_gettime,
    __NR_clock_getres,
    __NR_gettimeofday,
    __NR_times,
    __NR_getpid,
    __NR_getppid,
    __NR_gettid,
    __NR_getuid,
    __NR_geteuid,
    __NR_getgid,
    __NR_getegid,
    __NR_getrusage,
    __NR_getrlimit,
    __NR_sysinfo,
    __NR_uname,
    __NR_getrandom};

// What no decoder ever needs: who asks for it has been taken over.
constexpr std::array kFatal = {
#ifdef __NR_fork
    __NR_fork,
    __NR_vfork,
#endif
    __NR_socket,
    __NR_socketpair,
    __NR_connect,
    __NR_bind,
    __NR_listen,
    __NR_accept,
    __NR_accept4,
    __NR_sendto,
    __NR_sendmsg,
    __NR_sendmmsg,
    __NR_execve,
    __NR_execveat,
    __NR_ptrace,
    __NR_process_vm_readv,
    __NR_process_vm_writev,
    __NR_kill,
    __NR_tkill,
    __NR_pidfd_open,
    __NR_pidfd_getfd,
    __NR_pidfd_send_signal,
    __NR_io_uring_setup,
    __NR_bpf,
    __NR_perf_event_open,
    __NR_userfaultfd,
    __NR_unshare,
    __NR_setns,
    __NR_mount,
    __NR_open_by_handle_at,
    __NR_init_module,
    __NR_finit_module,
    __NR_keyctl,
    __NR_add_key,
    __NR_request_key};

#if defined(__x86_64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kMachine = 0;
#endif

constexpr std::uint32_t kAllow = SECCOMP_RET_ALLOW, kKill = SECCOMP_RET_KILL_PROCESS,
                        kUnknown = SECCOMP_RET_ERRNO | ENOSYS, kRefused = SECCOMP_RET_ERRNO | EPERM;

/// A program for the kernel's filter, put together line by line.
class Filter {
 public:
  void load(std::size_t offset) { add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)); }
  /// Ends with `ending` when what is loaded is `value`.
  void end_if(std::uint32_t value, std::uint32_t ending) {
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    end(ending);
  }
  void end_unless(std::uint32_t value, std::uint32_t ending) {
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
    end(ending);
  }
  void end(std::uint32_t ending) { add(BPF_RET | BPF_K, ending); }
  /// Of the call `number` the lower half of an argument decides: where its bits in `mask` are one of `values`
  /// it ends so, else otherwise. Leaves the call's number loaded.
  template <std::size_t N>
  void by_argument(long number, std::size_t argument, std::uint32_t mask,
                   const std::array<std::uint32_t, N>& values, std::uint32_t ending,
                   std::uint32_t otherwise) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(number), 0, 3 + 2 * N);
    load(offsetof(seccomp_data, args) + 8 * argument);
    add(BPF_ALU | BPF_AND | BPF_K, mask);
    for (const std::uint32_t value : values) end_if(value, ending);
    end(otherwise);
  }

  bool install() {
    sock_fprog program = {static_cast<unsigned short>(lines_.size()), lines_.data()};
    return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
  }

 private:
  void add(int code, std::uint32_t value, std::uint8_t if_true = 0, std::uint8_t if_false = 0) {
    lines_.push_back({static_cast<std::uint16_t>(code), if_true, if_false, value});
  }
  std::vector<sock_filter> lines_;
};

}  // namespace

bool write_only_below(const std::vector<std::filesystem::path>& folders) {
  const long version = ::syscall(__NR_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1 || !give_up_privileges()) return false;
  landlock_ruleset_attr rules = {};
  rules.handled_access_fs = kChanges;
  if (version >= 2) rules.handled_access_fs |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) rules.handled_access_fs |= kTruncate;
  const FileDescriptor ruleset(
      static_cast<int>(::syscall(__NR_landlock_create_ruleset, &rules, sizeof rules, 0)));
  if (!ruleset) return false;
  for (const std::filesystem::path& folder : folders) {
    const FileDescriptor open(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    landlock_path_beneath_attr below = {};
    below.allowed_access = rules.handled_access_fs;
    below.parent_fd = open.get();
    if (!open || ::syscall(__NR_landlock_add_rule, ruleset.get(), LANDLOCK_RULE_PATH_BENEATH, &below, 0) != 0)
      return false;
  }
  return ::syscall(__NR_landlock_restrict_self, ruleset.get(), 0) == 0;
}

bool call_only_what_decoders_call() {
  if (kMachine == 0 || !give_up_privileges()) return false;
  const auto self = static_cast<std::uint32_t>(::getpid());
  Filter filter;
  filter.load(offsetof(seccomp_data, arch));
  filter.end_unless(kMachine, kKill);
  filter.load(offsetof(seccomp_data, nr));
  for (const long number : kFatal) filter.end_if(static_cast<std::uint32_t>(number), kKill);
  for (const long number : kAllowed) filter.end_if(static_cast<std::uint32_t>(number), kAllow);
  // A thread, no process; a signal to itself (abort()); a thread's name; its own limits; is that a terminal?
  constexpr std::uint32_t kAll = ~std::uint32_t{0};
  filter.by_argument(__NR_clone, 0, CLONE_THREAD, std::array<std::uint32_t, 1>{0}, kKill, kAllow);
  filter.by_argument(__NR_tgkill, 0, kAll, std::array{self}, kAllow, kKill);
  filter.by_argument(__NR_prctl, 0, kAll, std::array<std::uint32_t, 2>{PR_SET_NAME, PR_GET_NAME}, kAllow,
                     kRefused);
  filter.by_argument(__NR_prlimit64, 0, kAll, std::array<std::uint32_t, 2>{0, self}, kAllow, kRefused);
  filter.by_argument(__NR_ioctl, 1, kAll, std::array<std::uint32_t, 3>{TCGETS, TIOCGWINSZ, FIONREAD}, kAllow,
                     kRefused);
  // Opened for reading and emptied: Landlock sees that only from Linux 6.2 on.
  constexpr std::array<std::uint32_t, 1> kEmptied = {O_RDONLY | O_TRUNC};
  filter.by_argument(__NR_openat, 2, O_ACCMODE | O_TRUNC, kEmptied, kRefused, kAllow);
#ifdef __NR_open
  filter.by_argument(__NR_open, 1, O_ACCMODE | O_TRUNC, kEmptied, kRefused, kAllow);
#endif
  filter.end(kUnknown);
  return filter.install();
}

}  // namespace floatstage
