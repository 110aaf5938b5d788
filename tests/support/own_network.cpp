#include "tests/support/own_network.h"

#include <cstring>
#include <string>

#include <arpa/inet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace floatstage {
namespace {

// One request about an interface.
bool ask_interface(unsigned long request, ifreq& about) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return false;
  const bool done = ::ioctl(fd, request, &about) == 0;
  ::close(fd);
  return done;
}

ifreq interface_named(const std::string& name) {
  ifreq about{};
  name.copy(about.ifr_name, IFNAMSIZ - 1);
  return about;
}

}  // namespace

bool enter_own_network() {
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  return set_loopback(true);
}

bool set_loopback(bool up) {
  ifreq loopback = interface_named("lo");
  if (!ask_interface(SIOCGIFFLAGS, loopback)) return false;
  loopback.ifr_flags = static_cast<short>(up ? loopback.ifr_flags | IFF_UP : loopback.ifr_flags & ~IFF_UP);
  return ask_interface(SIOCSIFFLAGS, loopback);
}

bool add_loopback_address(int number) {
  ifreq alias = interface_named("lo:" + std::to_string(number));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  ::inet_pton(AF_INET, ("127.0.0." + std::to_string(number)).c_str(), &address.sin_addr);
  std::memcpy(&alias.ifr_addr, &address, sizeof address);
  return ask_interface(SIOCSIFADDR, alias);
}

}  // namespace floatstage
