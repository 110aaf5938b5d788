#pragma once

// What all ends of the network share. Names ZeroMQ: for the .cpp files of this folder.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include <zmq.hpp>

#include "core/result.h"
#include "studio/network/keys.h"

namespace floatstage::studio::wire {

/// Wakes a thread that polls.
class WakeUp {
 public:
  WakeUp();
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  void signal();
  void drain();
  zmq::pollitem_t item() const { return {nullptr, fd_, ZMQ_POLLIN, 0}; }

 private:
  int fd_;
};

/// What ZeroMQ tells of a socket's connections.
class SocketMonitor {
 public:
  explicit SocketMonitor(zmq::context_t& context) : events_(context, zmq::socket_type::pair) {}

  void watch(zmq::socket_t& socket, const std::string& name);
  /// Reads what has happened; the number of peers that came in since the last call.
  std::uint64_t read();
  /// Of all connections so far those that ended at the door: other keys, another release, no ZeroMQ.
  std::uint64_t refused() const { return std::min(ended_, came_ - std::min(came_, entered_)); }
  zmq::pollitem_t item() { return {events_.handle(), 0, ZMQ_POLLIN, 0}; }

 private:
  zmq::socket_t events_;
  std::uint64_t came_ = 0, entered_ = 0, ended_ = 0;
};

/// Who may come in (ZeroMQ's authentication protocol, RFC 27): those who prove the studio's key. Answered on
/// the thread that owns the server's socket. One for each context.
class DoorKeeper {
 public:
  DoorKeeper(zmq::context_t& context, const std::optional<StudioKeys>& keys);
  void answer_all();
  zmq::pollitem_t item() { return {asked_.handle(), 0, ZMQ_POLLIN, 0}; }

 private:
  std::array<std::uint8_t, 32> ours_{};
  zmq::socket_t asked_;
};

/// Who asks whether the other is still there. A socket whose received messages may wait must not: where they
/// fill its queue and the peer goes, the next heartbeat ends the whole program (libzmq 4.3.4, "!_io_error").
/// Where requests and replies travel the client does then, and its heartbeats' time to live tells the server
/// when it is dead; publishers and subscribers have the watch that is said again and again (audience.h).
enum class Heartbeats { Given, Taken };

/// Options of every socket: nothing lingers, peers are given up that acknowledge nothing for two seconds, and
/// looked for again; no message is longer than `longest`.
void prepare(zmq::socket_t& socket, std::int64_t longest, Heartbeats heartbeats);
/// One end with the studio's keys, or without.
void become_server(zmq::socket_t& socket, const std::optional<StudioKeys>& keys);
void become_client(zmq::socket_t& socket, const std::optional<StudioKeys>& keys);

/// Binds after check_address(); the address it got, which names the port where 0 was asked for. Io where the
/// port is taken.
Result<std::string> bind_to(zmq::socket_t& socket, const std::string& address,
                            const std::optional<StudioKeys>& keys);
Result<void> connect_to(zmq::socket_t& socket, const std::string& address,
                        const std::optional<StudioKeys>& keys);

/// As zmq::poll(); a signal ends the wait early.
void wait_for(std::span<zmq::pollitem_t> items, std::chrono::milliseconds timeout);

/// A thread that no signal is delivered to: those are the main thread's.
std::thread quiet_thread(std::function<void()> body);

/// Another number at each start of a program.
std::uint64_t draw_session();

inline std::string_view bytes_of(const zmq::message_t& message) {
  return {static_cast<const char*>(message.data()), message.size()};
}

}  // namespace floatstage::studio::wire
