#include "studio/network/control_server.h"

#include <atomic>
#include <mutex>
#include <thread>

#include "core/log.h"
#include "studio/messages/control_message.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::int64_t kLongestRequest = 64 * 1024;
constexpr int kWaitingRequests = 64;

}  // namespace

struct ControlServer::Impl {
  Impl(const std::optional<StudioKeys>& keys, StudioControl& c)
      : control(c), socket(context, zmq::socket_type::router), monitor(context), door(context, keys) {}

  void run();
  void serve(zmq::message_t peer, std::string_view request);

  StudioControl& control;
  zmq::context_t context;
  zmq::socket_t socket;
  SocketMonitor monitor;
  DoorKeeper door;
  WakeUp wake;
  std::string address;
  mutable std::mutex mutex;
  ControlCounters counts;
  std::atomic<bool> stopping{false};
  std::thread thread;
};

void ControlServer::Impl::serve(zmq::message_t peer, std::string_view bytes) {
  const Result<Message> message = open(bytes);
  const Result<ControlRequest> request =
      message ? decode_request(*message) : Result<ControlRequest>(forward(message));
  {
    std::lock_guard lock(mutex);
    if (request)
      ++counts.requests;
    else
      ++(request.error().code == ErrorCode::Unsupported ? counts.other_version : counts.malformed);
  }
  const ControlReply reply = request ? answer(*request, control) : ControlReply(forward(request));
  Result<std::string> sealed = encode_reply(reply);
  if (!sealed) return log::error(sealed.error().message);
  // To a peer that has gone meanwhile, or does not read, nothing is sent.
  if (socket.send(peer, zmq::send_flags::sndmore | zmq::send_flags::dontwait))
    socket.send(zmq::buffer(*sealed), zmq::send_flags::dontwait);
}

void ControlServer::Impl::run() {
  zmq::pollitem_t items[] = {{socket.handle(), 0, ZMQ_POLLIN, 0}, door.item(), monitor.item(), wake.item()};
  while (!stopping) {
    wait_for(items, std::chrono::milliseconds(1000));
    wake.drain();
    door.answer_all();
    monitor.read();
    {
      std::lock_guard lock(mutex);
      counts.refused = monitor.refused();
    }
    zmq::message_t peer, request;
    if (!socket.recv(peer, zmq::recv_flags::dontwait) || !peer.more()) continue;
    if (!socket.recv(request, zmq::recv_flags::dontwait)) continue;
    if (!request.more()) {
      serve(std::move(peer), bytes_of(request));
      continue;
    }
    while (request.more() && socket.recv(request, zmq::recv_flags::dontwait)) {
    }
    std::lock_guard lock(mutex);
    ++counts.malformed;
  }
}

ControlServer::ControlServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<ControlServer>> ControlServer::bind(const std::string& address,
                                                           const std::optional<StudioKeys>& keys,
                                                           StudioControl& control) {
  auto impl = std::make_unique<Impl>(keys, control);
  prepare(impl->socket, kLongestRequest, Heartbeats::Taken);
  impl->socket.set(zmq::sockopt::rcvhwm, kWaitingRequests);
  impl->socket.set(zmq::sockopt::sndhwm, kWaitingRequests);
  become_server(impl->socket, keys);
  impl->monitor.watch(impl->socket, "control");
  Result<std::string> bound = bind_to(impl->socket, address, keys);
  if (!bound) return forward(bound);
  impl->address = std::move(*bound);
  impl->thread = quiet_thread([i = impl.get()] { i->run(); });
  return std::unique_ptr<ControlServer>(new ControlServer(std::move(impl)));
}

ControlServer::~ControlServer() {
  impl_->stopping = true;
  impl_->wake.signal();
  impl_->thread.join();
}

const std::string& ControlServer::address() const { return impl_->address; }

ControlCounters ControlServer::counters() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->counts;
}

}  // namespace floatstage::studio::wire
