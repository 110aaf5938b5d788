#include "capture/aravis/gvcp_knock.h"

#include <array>
#include <cstdint>

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "capture/studio_clock.h"

namespace floatstage::capture {
namespace {

constexpr std::uint16_t kPort = 3956;
// Key, flags (an answer is wanted), DISCOVERY_CMD, no payload, number 1; the answer is 0x0003 to that number.
constexpr std::array<std::uint8_t, 8> kWhoAreYou = {0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01};
constexpr int kLookMs = 50, kLooksAKnock = 4;

bool is_answer(const std::uint8_t* bytes, ssize_t size) {
  return size >= static_cast<ssize_t>(kWhoAreYou.size()) && bytes[0] == 0 && bytes[1] == 0 && bytes[2] == 0 &&
         bytes[3] == 3 && bytes[6] == 0 && bytes[7] == 1;
}

struct Socket {
  int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  ~Socket() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

Knock knock(const std::string& address, Nanoseconds patience, const std::function<bool()>& stop) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kPort);
  const Socket socket;
  if (socket.fd < 0 || ::inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1 ||
      ::connect(socket.fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
    return Knock::Answered;
  const Timestamp end = studio_now() + patience;
  for (int look = 0; studio_now() < end; ++look) {
    if (stop && stop()) return Knock::Stopped;
    if (look % kLooksAKnock == 0) [[maybe_unused]]
      const ssize_t sent = ::send(socket.fd, kWhoAreYou.data(), kWhoAreYou.size(), 0);
    pollfd ready{socket.fd, POLLIN, 0};
    ::poll(&ready, 1, kLookMs);
    std::uint8_t answer[1024];
    if (is_answer(answer, ::recv(socket.fd, answer, sizeof answer, 0))) return Knock::Answered;
    if ((ready.revents & POLLERR) != 0) ::poll(nullptr, 0, kLookMs);  // refused at once: there is nobody yet
  }
  return Knock::Silence;
}

}  // namespace floatstage::capture
