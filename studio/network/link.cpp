#include "studio/network/link.h"

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "core/check.h"
#include "core/text.h"

namespace floatstage::studio::wire {
namespace {

constexpr const char* kZapAddress = "inproc://zeromq.zap.01";
constexpr const char* kDomain = "floatstage";
constexpr int kHeartbeatMs = 500, kDeadMs = 2000, kIdleSeconds = 1, kProbes = 2;

}  // namespace

WakeUp::WakeUp() : fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) { FLOATSTAGE_CHECK(fd_ >= 0, "no eventfd"); }
WakeUp::~WakeUp() { ::close(fd_); }
void WakeUp::signal() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t full = ::write(fd_, &one, sizeof one);  // then it is signalled already
}
void WakeUp::drain() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t empty = ::read(fd_, &count, sizeof count);
}

void SocketMonitor::watch(zmq::socket_t& socket, const std::string& name) {
  const std::string address = "inproc://monitor." + name;
  constexpr int kEvents =
      ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_CONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED;
  FLOATSTAGE_CHECK(zmq_socket_monitor(socket.handle(), address.c_str(), kEvents) == 0,
                   "a socket that cannot be watched");
  events_.set(zmq::sockopt::linger, 0);
  events_.connect(address);
}

std::uint64_t SocketMonitor::read() {
  const std::uint64_t before = entered_;
  zmq::message_t part;
  while (events_.recv(part, zmq::recv_flags::dontwait)) {
    std::uint16_t event = 0;  // a number and a value, and in a second part an address
    if (!part.more() || part.size() < sizeof event) continue;
    std::memcpy(&event, part.data(), sizeof event);
    // Why a handshake failed is not said each time (not where the types of sockets do not fit): so they are
    // counted.
    if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED)
      ++entered_;
    else if (event == ZMQ_EVENT_DISCONNECTED)
      ++ended_;
    else
      ++came_;
  }
  return entered_ - before;
}

DoorKeeper::DoorKeeper(zmq::context_t& context, const std::optional<StudioKeys>& keys)
    : asked_(context, zmq::socket_type::rep) {
  if (keys)
    FLOATSTAGE_CHECK(zmq_z85_decode(ours_.data(), keys->public_key.c_str()) != nullptr,
                     "keys that were not checked");
  asked_.set(zmq::sockopt::linger, 0);
  asked_.bind(kZapAddress);
}

void DoorKeeper::answer_all() {
  // Version, request, domain, address, identity, mechanism, and with CURVE the peer's key.
  constexpr std::size_t kVersion = 0, kRequest = 1, kMechanism = 5, kKey = 6;
  for (;;) {
    std::vector<std::string> parts;
    zmq::message_t part;
    do {
      if (!asked_.recv(part, zmq::recv_flags::dontwait)) return;
      parts.emplace_back(bytes_of(part));
    } while (part.more());
    const bool known = parts.size() == kKey + 1 && parts[kMechanism] == "CURVE" &&
                       parts[kKey].size() == ours_.size() &&
                       std::memcmp(parts[kKey].data(), ours_.data(), ours_.size()) == 0;
    parts.resize(std::max(parts.size(), kRequest + 1));
    const std::string reply[] = {
        parts[kVersion], parts[kRequest], known ? "200" : "400", known ? "" : "not of this studio", "", ""};
    for (std::size_t i = 0; i < std::size(reply); ++i)
      asked_.send(zmq::buffer(reply[i]),
                  i + 1 < std::size(reply) ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
}

void prepare(zmq::socket_t& socket, std::int64_t longest, Heartbeats heartbeats) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::maxmsgsize, longest);
  if (heartbeats == Heartbeats::Given) {
    socket.set(zmq::sockopt::heartbeat_ivl, kHeartbeatMs);
    socket.set(zmq::sockopt::heartbeat_timeout, kDeadMs);
    socket.set(zmq::sockopt::heartbeat_ttl, kDeadMs);
  }
  socket.set(zmq::sockopt::tcp_maxrt, kDeadMs);
  socket.set(zmq::sockopt::tcp_keepalive, 1);
  socket.set(zmq::sockopt::tcp_keepalive_idle, kIdleSeconds);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, kIdleSeconds);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, kProbes);
  socket.set(zmq::sockopt::handshake_ivl, kDeadMs);
  socket.set(zmq::sockopt::connect_timeout, kDeadMs);
  socket.set(zmq::sockopt::reconnect_ivl, 100);
  socket.set(zmq::sockopt::reconnect_ivl_max, 1000);
}

void become_server(zmq::socket_t& socket, const std::optional<StudioKeys>& keys) {
  if (!keys) return;
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_publickey, keys->public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys->secret_key);
  socket.set(zmq::sockopt::zap_domain, std::string(kDomain));
}

void become_client(zmq::socket_t& socket, const std::optional<StudioKeys>& keys) {
  if (!keys) return;
  socket.set(zmq::sockopt::curve_serverkey, keys->public_key);
  socket.set(zmq::sockopt::curve_publickey, keys->public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys->secret_key);
}

Result<std::string> bind_to(zmq::socket_t& socket, const std::string& address,
                            const std::optional<StudioKeys>& keys) {
  if (Result<void> allowed = check_address(address, keys); !allowed) return forward(allowed);
  if (zmq_bind(socket.handle(), address.c_str()) != 0)
    return fail(ErrorCode::Io, text("'", address, "': cannot be listened on: ", zmq_strerror(zmq_errno()),
                                    "; choose another port or end the program that has it"));
  return socket.get(zmq::sockopt::last_endpoint);
}

Result<void> connect_to(zmq::socket_t& socket, const std::string& address,
                        const std::optional<StudioKeys>& keys) {
  if (Result<void> allowed = check_address(address, keys); !allowed) return allowed;
  if (zmq_connect(socket.handle(), address.c_str()) != 0)
    return fail(ErrorCode::InvalidArgument, text("'", address, "': no address: ", zmq_strerror(zmq_errno())));
  return {};
}

void wait_for(std::span<zmq::pollitem_t> items, std::chrono::milliseconds timeout) {
  zmq_poll(items.data(), static_cast<int>(items.size()), timeout.count());
}

std::thread quiet_thread(std::function<void()> body) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::move(body));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

std::uint64_t draw_session() {
  std::random_device entropy;
  return (static_cast<std::uint64_t>(entropy()) << 32) | entropy();
}

}  // namespace floatstage::studio::wire
