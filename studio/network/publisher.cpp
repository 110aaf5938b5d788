#include "studio/network/publisher.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "core/bounded_queue.h"
#include "core/log.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/network/audience.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

using Topic = std::pair<MessageKind, std::string>;  // with a serial where it is of a camera
using Told = std::variant<std::shared_ptr<const CameraView>, std::shared_ptr<const StudioScene>, NodeStatus>;

using Clock = Audience::Clock;

// Of one peer, waiting in ZeroMQ: then its connection is read no more until there is room.
constexpr int kWaitingWatches = 16;
// In one round: a flood must not keep us from sending.
constexpr int kBurst = 16, kWatchesARound = 64;

}  // namespace

struct Publisher::Impl {
  Impl(const PublisherOptions& o)
      : options(o),
        socket(context, zmq::socket_type::router),
        monitor(context),
        door(context, o.keys),
        queue(static_cast<std::size_t>(std::max(1, o.queue)), QueuePolicy::DropOldest) {}

  void run();
  void read_watches();
  void take_watch(const std::string& peer, std::string_view bytes);
  void send(const Told& told);
  void send(const Topic& topic, Result<std::string> message, std::uint64_t PublisherCounters::*count,
            std::uint64_t PublisherCounters::*bytes);
  void send_to(const std::string& peer, zmq::message_t& message);

  const PublisherOptions options;
  zmq::context_t context;
  zmq::socket_t socket;
  SocketMonitor monitor;
  DoorKeeper door;
  WakeUp wake;
  std::string address;
  const std::uint64_t session = draw_session();
  BoundedQueue<Told> queue;
  std::map<Topic, std::uint64_t> sequences;  // the thread's own

  mutable std::mutex mutex;  // over what follows
  Audience audience;
  PublisherCounters counts;

  std::atomic<bool> stopping{false};
  std::thread thread;
};

void Publisher::Impl::read_watches() {
  zmq::message_t id, part;
  for (int i = 0; i < kWatchesARound && socket.recv(id, zmq::recv_flags::dontwait); ++i) {
    int parts = 0;
    for (bool more = id.more(); more && socket.recv(part, zmq::recv_flags::dontwait); more = part.more())
      ++parts;
    take_watch(std::string(bytes_of(id)), parts == 1 ? bytes_of(part) : std::string_view());
  }
}

void Publisher::Impl::take_watch(const std::string& peer, std::string_view bytes) {
  const Result<Message> message = open(bytes);
  Result<Watch> watch = message ? decode_watch(*message) : Result<Watch>(forward(message));
  std::lock_guard lock(mutex);
  if (!watch)
    ++(watch.error().code == ErrorCode::Unsupported ? counts.other_version : counts.malformed);
  else if (!audience.put(peer, std::move(*watch), Clock::now()))
    ++counts.turned_away;
}

void Publisher::Impl::send_to(const std::string& peer, zmq::message_t& message) {
  zmq::message_t shared;  // its bytes: each peer's copy counts them, none has them again
  shared.copy(message);
  zmq::message_t id(peer);
  // A peer that is full or gone is told by the first part: nothing is left half-sent.
  if (zmq_msg_send(id.handle(), socket.handle(), ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0) {
    zmq_msg_send(shared.handle(), socket.handle(), ZMQ_DONTWAIT);
    return;
  }
  const bool gone = zmq_errno() == EHOSTUNREACH;
  std::lock_guard lock(mutex);
  if (gone)
    audience.forget(peer);
  else
    ++counts.left_out;
}

void Publisher::Impl::send(const Topic& topic, Result<std::string> message,
                           std::uint64_t PublisherCounters::*count, std::uint64_t PublisherCounters::*bytes) {
  if (!message) {
    log::warning(message.error().message);
    std::lock_guard lock(mutex);
    ++counts.unsendable;
    return;
  }
  stamp(*message, session, sequences[topic]++);
  auto* owned = new std::string(std::move(*message));
  zmq::message_t sent(
      owned->data(), owned->size(), [](void*, void* string) { delete static_cast<std::string*>(string); },
      owned);
  std::vector<std::string> peers;
  {
    std::lock_guard lock(mutex);
    ++(counts.*count);
    counts.*bytes += sent.size();
    peers = audience.who_wants(topic.first, topic.second);
  }
  for (const std::string& peer : peers) send_to(peer, sent);
}

void Publisher::Impl::send(const Told& told) {
  if (const auto* view = std::get_if<std::shared_ptr<const CameraView>>(&told)) {
    send({MessageKind::Outline, (*view)->serial}, encode_outline(**view), &PublisherCounters::outlines,
         &PublisherCounters::outline_bytes);
    if (!(*view)->tile) return;
    bool wanted = false;
    {
      std::lock_guard lock(mutex);
      wanted = audience.wants(MessageKind::Tile, (*view)->serial);
    }
    if (!wanted) return;
    send({MessageKind::Tile, (*view)->serial}, encode_tile(**view, options.tiles), &PublisherCounters::tiles,
         &PublisherCounters::tile_bytes);
    std::lock_guard lock(mutex);
    ++counts.tiles_by_camera[(*view)->serial];
  } else if (const auto* scene = std::get_if<std::shared_ptr<const StudioScene>>(&told)) {
    send({MessageKind::Scene, ""}, encode_scene(**scene), &PublisherCounters::scenes,
         &PublisherCounters::scene_bytes);
  } else {
    send({MessageKind::Status, ""}, encode_status(std::get<NodeStatus>(told)), &PublisherCounters::statuses,
         &PublisherCounters::status_bytes);
  }
}

void Publisher::Impl::run() {
  zmq::pollitem_t items[] = {{socket.handle(), 0, ZMQ_POLLIN, 0}, door.item(), monitor.item(), wake.item()};
  while (!stopping) {
    wait_for(items, std::chrono::milliseconds(1000));
    wake.drain();
    door.answer_all();
    read_watches();
    monitor.read();
    {
      std::lock_guard lock(mutex);
      counts.refused = monitor.refused();
      audience.forget_silent(Clock::now());
    }
    int left = kBurst;
    for (; left > 0 && !stopping; --left) {
      const std::optional<Told> told = queue.pop_for(Nanoseconds{0});
      if (!told) break;
      send(*told);
    }
    if (left == 0) wake.signal();  // more may wait; first look at the rest
  }
}

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Publisher>> Publisher::bind(const PublisherOptions& options) {
  auto impl = std::make_unique<Impl>(options);
  prepare(impl->socket, kLongestWatch, Heartbeats::Taken);
  impl->socket.set(zmq::sockopt::router_mandatory, true);  // says of a peer that it is full or gone
  impl->socket.set(zmq::sockopt::rcvhwm, kWaitingWatches);
  impl->socket.set(zmq::sockopt::sndhwm, options.per_peer);
  become_server(impl->socket, options.keys);
  impl->monitor.watch(impl->socket, "publisher");
  Result<std::string> bound = bind_to(impl->socket, options.address, options.keys);
  if (!bound) return forward(bound);
  impl->address = std::move(*bound);
  impl->thread = quiet_thread([i = impl.get()] { i->run(); });
  return std::unique_ptr<Publisher>(new Publisher(std::move(impl)));
}

Publisher::~Publisher() {
  impl_->stopping = true;
  impl_->wake.signal();
  impl_->thread.join();
}

void Publisher::publish(std::shared_ptr<const CameraView> view) {
  impl_->queue.push(std::move(view));
  impl_->wake.signal();
}

void Publisher::publish(std::shared_ptr<const StudioScene> scene) {
  impl_->queue.push(std::move(scene));
  impl_->wake.signal();
}

void Publisher::publish(NodeStatus status) {
  impl_->queue.push(std::move(status));
  impl_->wake.signal();
}

bool Publisher::wants_tile(const std::string& serial) const {
  std::lock_guard lock(impl_->mutex);
  return impl_->audience.wants(MessageKind::Tile, serial);
}

const std::string& Publisher::address() const { return impl_->address; }

PublisherCounters Publisher::counters() const {
  std::lock_guard lock(impl_->mutex);
  PublisherCounters counts = impl_->counts;
  counts.dropped = impl_->queue.counters().dropped;
  return counts;
}

}  // namespace floatstage::studio::wire
