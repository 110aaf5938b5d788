#include "core/confined.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/confined_rules.h"
#include "core/file_descriptor.h"
#include "core/log.h"
#include "core/text.h"
#include "core/working_page.h"

namespace floatstage {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // terabytes of shadow, and handlers of its own
#else
constexpr bool kSanitized = false;
#endif

constexpr std::uint32_t kLongestWord = 1 << 16, kLongestResult = 1u << 30;
constexpr auto kLook = milliseconds(100);  // how often the parent looks at its child
constexpr auto kToEnd = std::chrono::seconds(2);
constexpr rlim_t kMostCpuSeconds = 24 * 3600;

// What the child says begins with one of these and the length of what follows.
enum class Word : char { Told, Result, Error, Check, NoMemory, Exception };

struct Head {
  Word word;
  std::uint32_t length;
};

// ---- the child

std::uint64_t g_memory_at_begin = 0;

std::uint64_t address_space() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t free_memory() {
  std::ifstream file("/proc/meminfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("MemAvailable:")) return std::strtoull(line.c_str() + 13, nullptr, 10) << 10;
  return std::uint64_t{1} << 34;
}

void limit(int what, std::uint64_t most) {
  rlimit now = {};
  ::getrlimit(static_cast<__rlimit_resource>(what), &now);
  now.rlim_max = now.rlim_cur = std::min<rlim_t>(most, now.rlim_cur);
  ::setrlimit(static_cast<__rlimit_resource>(what), &now);
}

extern "C" void on_crash(int signal_number) {
  if (t_working_place != nullptr) t_working_place->failed = true;
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);
}

void say(int pipe, Word word, std::string_view first, std::string_view rest) {
  const Head head = {word, static_cast<std::uint32_t>(first.size() + rest.size())};
  char bytes[sizeof head] = {};
  std::memcpy(bytes, &head, sizeof head);
  for (std::string_view part : {std::string_view(bytes, sizeof bytes), first, rest})
    while (!part.empty()) {
      const ssize_t n = ::write(pipe, part.data(), part.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) ::_exit(1);  // nobody listens
      part.remove_prefix(static_cast<std::size_t>(n));
    }
}

void keep_to(const Confinement& limits, pid_t parent, int& pipe) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  // Whoever presses Ctrl-C is heard by the parent, which ends its child.
  for (const int ignored : {SIGINT, SIGHUP, SIGPIPE, SIGXFSZ}) ::signal(ignored, SIG_IGN);
  ::signal(SIGTERM, SIG_DFL);
  if (!kSanitized)
    for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::signal(crash, &on_crash);
  // None of the parent's files: its sockets and locks stay its own.
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::dup2(nothing, STDIN_FILENO);
  constexpr int kFirst = STDERR_FILENO + 1;
  if (pipe != kFirst) ::dup2(pipe, kFirst);
  pipe = kFirst;
  ::syscall(__NR_close_range, kFirst + 1, ~0u, 0);

  std::uint64_t disk = RLIM_INFINITY;
  for (const std::filesystem::path& folder : limits.writable)
    if (struct statvfs fs = {}; ::statvfs(folder.c_str(), &fs) == 0)
      disk = std::min<std::uint64_t>(disk, std::uint64_t{fs.f_bavail} * fs.f_frsize / 10 * 9);
  limit(RLIMIT_FSIZE, disk);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NOFILE, RLIM_INFINITY);  // what the soft limit is
  limit(RLIMIT_CPU, kMostCpuSeconds);
  g_memory_at_begin = address_space();
  confine_memory(limits.memory ? limits.memory : free_memory());
  write_only_below(limits.writable);
  call_only_what_decoders_call();
}

[[noreturn]] void be_the_child(const Confinement& limits,
                               const std::function<Result<std::string>(const Tell&)>& work, pid_t parent,
                               int pipe) {
  keep_to(limits, parent, pipe);
  std::mutex mutex;
  try {
    const Result<std::string> result = work([&](std::string_view told) {
      const std::lock_guard lock(mutex);
      say(pipe, Word::Told, told, "");
    });
    if (result) {
      say(pipe, Word::Result, *result, "");
    } else {
      const char code = static_cast<char>(result.error().code);
      say(pipe, Word::Error, {&code, 1}, result.error().message);
    }
  } catch (const CheckFailure& e) {
    say(pipe, Word::Check, e.what(), "");
  } catch (const std::bad_alloc&) {
    say(pipe, Word::NoMemory, "", "");
  } catch (const std::exception& e) {
    say(pipe, Word::Exception, e.what(), "");
  }
  ::_exit(0);
}

// ---- the parent

class Page {
 public:
  Page()
      : page_(::mmap(nullptr, sizeof(WorkingPage), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
                     0)) {}
  ~Page() {
    if (*this) ::munmap(page_, sizeof(WorkingPage));
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;
  explicit operator bool() const { return page_ != MAP_FAILED; }
  WorkingPage* get() const { return static_cast<WorkingPage*>(page_); }

 private:
  void* const page_;
};

std::string name_at(const WorkingPage::Place& place) {
  return {place.name, ::strnlen(place.name, sizeof place.name)};
}

/// The files that `counts` takes; else those that are being decoded; else `what`.
template <class Counts>
std::string names(const WorkingPage& page, const std::string& what, const Counts& counts) {
  std::vector<std::string> found;
  for (const bool any : {false, true})
    if (found.empty())
      for (const WorkingPage::Place& place : page.places)
        if (any ? place.steps % 2 == 1 : counts(place)) found.push_back(name_at(place));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  if (found.empty()) return what;
  std::string out = found[0];
  for (std::size_t i = 1; i < std::min<std::size_t>(found.size(), 3); ++i) out += " or " + found[i];
  return found.size() > 3 ? text(out, " or one of ", found.size() - 3, " more") : out;
}

bool has_failed(const WorkingPage::Place& place) { return place.failed; }

/// Which files a child has been decoding for how long.
class Patience {
 public:
  Patience(const WorkingPage& page, pid_t child) : page_(page) {
    known_ = ::clock_getcpuclockid(child, &clock_) == 0;
  }

  /// The names of those that take more than so many seconds of processor time.
  std::optional<std::string> lost(double seconds) {
    timespec now = {};
    if (!known_ || ::clock_gettime(clock_, &now) != 0) return std::nullopt;
    const double cpu = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    std::size_t busy = 0;
    std::optional<std::size_t> longest;
    for (std::size_t i = 0; i < WorkingPage::kPlaces; ++i) {
      const std::uint32_t steps = page_.places[i].steps;
      if (steps != steps_[i] || steps % 2 == 0) since_[i] = cpu;
      steps_[i] = steps;
      if (steps % 2 == 0) continue;
      ++busy;
      if (!longest || since_[i] < since_[*longest]) longest = i;
    }
    // The time is that of all threads together.
    if (!longest || cpu - since_[*longest] <= seconds * static_cast<double>(busy)) return std::nullopt;
    return name_at(page_.places[*longest]);
  }

 private:
  const WorkingPage& page_;
  clockid_t clock_ = {};
  bool known_ = false;
  std::uint32_t steps_[WorkingPage::kPlaces] = {};
  double since_[WorkingPage::kPlaces] = {};
};

Unexpected cannot_begin(const std::string& what) {
  return fail(ErrorCode::Io, text(what, ": no process can be made for it: ", std::strerror(errno)));
}

class Parent {
 public:
  Parent(const Confinement& limits, WorkingPage& page, pid_t child, FileDescriptor pipe)
      : limits_(limits), page_(page), child_(child), pipe_(std::move(pipe)) {}
  ~Parent() { end(); }
  Parent(const Parent&) = delete;
  Parent& operator=(const Parent&) = delete;

  Result<std::string> listen(const std::function<Result<void>(std::string_view)>& watch) {
    Patience patience(page_, child_);
    for (bool more = true; more;) {
      pollfd readable = {pipe_.get(), POLLIN, 0};
      if (::poll(&readable, 1, static_cast<int>(kLook.count())) > 0) more = read();
      while (take_word())
        if (Result<void> ok = watch(said_); !ok) return asked_to_end(ok.error());
      if (nonsense_) return without_result();
      if (Result<void> ok = watch(""); !ok) return asked_to_end(ok.error());
      if (const auto file = patience.lost(limits_.decode_seconds)) return too_slow(*file);
    }
    const std::optional<int> ended = reap();
    if (!ended) return without_result();
    const int status = *ended;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && last_) return outcome();
    return death(status);
  }

 private:
  // Its own last word where it is an error; what it tells until then is not heard.
  Unexpected asked_to_end(const Error& why) {
    page_.to_end = true;
    const auto until = Clock::now() + std::chrono::duration<double>(limits_.ending_seconds);
    while (Clock::now() < until) {
      pollfd readable = {pipe_.get(), POLLIN, 0};
      if (::poll(&readable, 1, static_cast<int>(kLook.count())) > 0 && !read()) break;
      while (take_word()) continue;
    }
    if (last_ == Word::Error && reap())
      if (const Result<std::string> outcome = this->outcome(); !outcome) return forward(outcome);
    return fail(why.code, why.message);
  }

  // Whether there may be more.
  bool read() {
    const std::size_t had = bytes_.size();
    bytes_.resize(had + (1 << 16));
    const ssize_t n = ::read(pipe_.get(), bytes_.data() + had, bytes_.size() - had);
    bytes_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    return n > 0 || (n < 0 && errno == EINTR);
  }

  // The next whole thing that was said, in word_ and said_; what ends the talk is kept in last_.
  bool take_word() {
    if (last_ || bytes_.size() - at_ < sizeof word_) return false;
    std::memcpy(&word_, bytes_.data() + at_, sizeof word_);
    const bool told = word_.word == Word::Told;
    if (word_.length > (told ? kLongestWord : kLongestResult)) {
      nonsense_ = true;
      return false;
    }
    if (bytes_.size() - at_ - sizeof word_ < word_.length) {
      bytes_.reserve(at_ + sizeof word_ + word_.length);
      return false;
    }
    said_ = bytes_.substr(at_ + sizeof word_, word_.length);
    at_ += sizeof word_ + word_.length;
    if (at_ == bytes_.size()) bytes_.clear(), at_ = 0;
    if (!told) last_ = word_.word;
    return told;
  }

  // Gives it time to end by itself: what it said last counts only then.
  std::optional<int> reap() {
    int status = 0;
    for (const auto until = Clock::now() + kToEnd; Clock::now() < until;) {
      if (::waitpid(child_, &status, WNOHANG) == child_) {
        child_ = 0;
        return status;
      }
      std::this_thread::sleep_for(milliseconds(1));
    }
    return std::nullopt;
  }

  void end() {
    if (child_ == 0) return;
    ::kill(child_, SIGKILL);
    while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) continue;
    child_ = 0;
  }

  Result<std::string> outcome() {
    switch (*last_) {
      case Word::Result:
        return std::move(said_);
      case Word::Error:
        if (said_.empty() || said_[0] < 0 || said_[0] > static_cast<char>(ErrorCode::Cancelled)) break;
        return fail(static_cast<ErrorCode>(said_[0]), said_.substr(1));
      case Word::Check:
        throw CheckFailure(said_);
      case Word::NoMemory:
        return fail(ErrorCode::BadData, text(names(page_, limits_.what, has_failed),
                                             ": decoding it takes more memory than there is for it"));
      case Word::Exception:
        throw std::runtime_error(said_);
      case Word::Told:
        break;
    }
    return without_result();
  }

  Unexpected without_result() const {
    return fail(ErrorCode::BadData, text(names(page_, limits_.what, has_failed),
                                         ": what decodes it ended without a result; leave it out"));
  }

  Unexpected too_slow(const std::string& file) const {
    return fail(ErrorCode::BadData, text(file, ": not decoded after ", limits_.decode_seconds,
                                         " s of processor time; leave it out, or write it anew"));
  }

  Unexpected death(int status) const {
    if (!WIFSIGNALED(status)) return without_result();
    const std::string file = names(page_, limits_.what, has_failed);
    const int number = WTERMSIG(status);
    switch (number) {
      case SIGSYS:
        return fail(ErrorCode::BadData,
                    text(file,
                         ": what decodes it wanted the network, another program or another process, and "
                         "was stopped; do not trust this file"));
      case SIGXCPU:
        return fail(ErrorCode::BadData, text(file, ": not decoded after ", kMostCpuSeconds / 3600, " hours"));
      case SIGSEGV:
      case SIGBUS:
      case SIGFPE:
      case SIGILL:
      case SIGABRT:
      case SIGTRAP:
        return fail(ErrorCode::BadData,
                    text(file, ": what decodes it crashed (", ::strsignal(number),
                         "); it is damaged or was made to do that: leave it out, or write it anew"));
      default:
        return fail(ErrorCode::Io, text(limits_.what, ": its process was ended from outside (",
                                        ::strsignal(number), "), as happens where memory runs out"));
    }
  }

  const Confinement& limits_;
  WorkingPage& page_;
  pid_t child_;  // 0: reaped
  const FileDescriptor pipe_;
  std::string bytes_, said_;
  std::size_t at_ = 0;  // what was taken of bytes_
  Head word_ = {};
  std::optional<Word> last_;
  bool nonsense_ = false;  // it said what is no word of ours
};

void say_what_is_missing() {
  static std::once_flag once;
  std::call_once(once, [] {
    const ConfiningKernel kernel = confining_kernel();
    if (kernel.landlock && kernel.seccomp) return;
    log::warning(
        text("this kernel has no ", kernel.landlock ? "" : "Landlock",
             kernel.landlock || kernel.seccomp ? "" : " and no ", kernel.seccomp ? "" : "seccomp filters",
             ": what decodes foreign files is confined less; import what you do not trust elsewhere"));
  });
}

}  // namespace

ConfiningKernel confining_kernel() {
  const long landlock = ::syscall(__NR_landlock_create_ruleset, nullptr, 0, 1 /* its version */);
  return {landlock >= 1, ::prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0};
}

void confine_memory(std::uint64_t bytes) {
  if (!kSanitized && g_memory_at_begin > 0) limit(RLIMIT_AS, g_memory_at_begin + bytes);
}

bool asked_to_end() { return g_working_page != nullptr && g_working_page->to_end; }

Result<std::string> run_confined(const Confinement& limits,
                                 const std::function<Result<std::string>(const Tell&)>& work,
                                 const std::function<Result<void>(std::string_view)>& watch) {
  say_what_is_missing();
  const Page page;
  int ends[2] = {};
  if (!page || ::pipe2(ends, O_CLOEXEC) != 0) return cannot_begin(limits.what);
  FileDescriptor from(ends[0]), to(ends[1]);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) return cannot_begin(limits.what);
  if (child == 0) {
    g_working_page = page.get();
    be_the_child(limits, work, parent, to.get());
  }
  to = FileDescriptor();
  return Parent(limits, *page.get(), child, std::move(from)).listen(watch);
}

}  // namespace floatstage
