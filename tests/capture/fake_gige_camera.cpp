#include "tests/capture/fake_gige_camera.h"

#include <cerrno>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <vector>

#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>

#include "core/text.h"

extern char** environ;

namespace floatstage::capture {
namespace {

// Whether a socket listens for GigE Vision control (port 3956) on 127.0.0.`number`.
bool listens(int number) {
  char wanted[32];
  std::snprintf(wanted, sizeof wanted, "%02X00007F:0F74", static_cast<unsigned>(number));
  std::ifstream table("/proc/net/udp");
  for (std::string line; std::getline(table, line);)
    if (line.find(wanted) != std::string::npos) return true;
  return false;
}

}  // namespace

FakeGigeCamera::FakeGigeCamera(int number, const std::string& serial, int lost_per_thousand,
                               const std::filesystem::path& genicam)
    : address_("127.0.0." + std::to_string(number)), serial_(serial) {
  const std::string lost = std::to_string(lost_per_thousand);
  std::vector<const char*> arguments = {FLOATSTAGE_FAKE_GIGE, "-i", address_.c_str(), "-s",
                                        serial_.c_str(),      "-r", lost.c_str()};
  if (!genicam.empty()) arguments.insert(arguments.end(), {"-g", genicam.c_str()});
  arguments.push_back(nullptr);
  if (posix_spawn(&pid_, FLOATSTAGE_FAKE_GIGE, nullptr, nullptr, const_cast<char**>(arguments.data()),
                  environ) != 0)
    throw std::runtime_error("no fake camera");
  for (int tries = 0; !listens(number); ++tries) {
    if (tries > 1000) throw std::runtime_error("the fake camera does not listen");
    ::poll(nullptr, 0, 10);
  }
}

FakeGigeCamera::~FakeGigeCamera() { kill(); }

std::string FakeGigeCamera::uri(const std::string& options) const {
  return text("gige:", serial_, "?address=", address_, options.empty() ? "" : "&", options);
}

void FakeGigeCamera::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

void FakeGigeCamera::freeze() { ::kill(pid_, SIGSTOP); }
void FakeGigeCamera::thaw() { ::kill(pid_, SIGCONT); }

}  // namespace floatstage::capture
