#include "studio/network/subscriber.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include "core/bounded_queue.h"
#include "core/log.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/view_message.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

using Clock = std::chrono::steady_clock;

// Cameras of a studio, four kinds each; a peer that invents serials does not fill our memory.
constexpr std::size_t kMostTopics = 8 * 1024;

struct Place {
  std::uint64_t session = 0, next = 0;
};

}  // namespace

struct Subscriber::Impl {
  Impl(const SubscriberOptions& o)
      : socket(context, zmq::socket_type::sub),
        monitor(context),
        queue(static_cast<std::size_t>(std::max(1, o.queue)), QueuePolicy::DropOldest) {}

  void run();
  void change_tiles();
  void take(std::string_view bytes);
  void count_place(const MessageHeader& header);  // under `mutex`
  void refuse(const Error& error);                // under `mutex`
  Result<Received> decode(const Message& message);

  zmq::context_t context;
  zmq::socket_t socket;
  SocketMonitor monitor;
  WakeUp wake;
  BoundedQueue<Received> queue;
  std::set<std::string> subscribed;  // the thread's own
  std::map<std::string, Place> places;
  Clock::time_point warned;

  mutable std::mutex mutex;  // over what follows
  std::set<std::string> wanted;
  SubscriberCounters counts;

  std::atomic<bool> stopping{false};
  std::thread thread;
};

void Subscriber::Impl::change_tiles() {
  std::set<std::string> now;
  {
    std::lock_guard lock(mutex);
    now = wanted;
  }
  for (const std::string& serial : subscribed)
    if (!now.contains(serial)) {
      socket.set(zmq::sockopt::unsubscribe, topic_of(MessageKind::Tile, serial));
      places.erase(topic_of(MessageKind::Tile, serial));
    }
  for (const std::string& serial : now)
    if (!subscribed.contains(serial))
      socket.set(zmq::sockopt::subscribe, topic_of(MessageKind::Tile, serial));
  subscribed = std::move(now);
}

void Subscriber::Impl::count_place(const MessageHeader& header) {
  const std::string topic = topic_of(header.kind, header.serial);
  const auto found = places.find(topic);
  if (found == places.end() && places.size() >= kMostTopics) return;
  Place& place = found == places.end() ? places[topic] : found->second;
  if (place.session == header.session && header.sequence > place.next)
    counts.missed += header.sequence - place.next;
  place = {header.session, header.sequence + 1};
}

void Subscriber::Impl::refuse(const Error& error) {
  ++(error.code == ErrorCode::Unsupported ? counts.other_version : counts.malformed);
  if (const auto now = Clock::now(); now - warned >= std::chrono::seconds(1)) {
    warned = now;
    log::warning(error.message);
  }
}

Result<Received> Subscriber::Impl::decode(const Message& message) {
  switch (message.header.kind) {
    case MessageKind::Outline:
    case MessageKind::Tile: {
      Result<CameraView> view = decode_view(message);
      if (!view) return forward(view);
      return Received(std::make_shared<const CameraView>(std::move(*view)));
    }
    case MessageKind::Scene: {
      Result<StudioScene> scene = decode_scene(message);
      if (!scene) return forward(scene);
      return Received(std::make_shared<const StudioScene>(std::move(*scene)));
    }
    case MessageKind::Status: {
      Result<NodeStatus> status = decode_status(message);
      if (!status) return forward(status);
      return Received(std::move(*status));
    }
    default:
      return fail(ErrorCode::BadData, "a publisher sends neither requests nor replies");
  }
}

void Subscriber::Impl::take(std::string_view bytes) {
  const Result<Message> message = open(bytes);
  Result<Received> received = message ? decode(*message) : Result<Received>(forward(message));
  {
    std::lock_guard lock(mutex);
    ++counts.messages;
    counts.bytes += bytes.size();
    if (!received) return refuse(received.error());
    count_place(message->header);
    switch (message->header.kind) {
      case MessageKind::Outline:
        ++counts.outlines, counts.outline_bytes += bytes.size();
        break;
      case MessageKind::Tile:
        ++counts.tiles, counts.tile_bytes += bytes.size();
        break;
      case MessageKind::Scene:
        ++counts.scenes, counts.scene_bytes += bytes.size();
        break;
      default:
        ++counts.statuses;
    }
  }
  queue.push(std::move(*received));
}

void Subscriber::Impl::run() {
  zmq::pollitem_t items[] = {{socket.handle(), 0, ZMQ_POLLIN, 0}, monitor.item(), wake.item()};
  while (!stopping) {
    wait_for(items, std::chrono::milliseconds(1000));
    wake.drain();
    change_tiles();
    const std::uint64_t refusals = monitor.read_refusals();
    if (refusals > 0) {
      std::lock_guard lock(mutex);
      counts.refused += refusals;
    }
    zmq::message_t message;
    // A flood must not keep us from looking at the rest.
    for (int burst = 0; burst < 64 && !stopping && socket.recv(message, zmq::recv_flags::dontwait); ++burst) {
      const bool one = !message.more();
      if (one) take(bytes_of(message));
      if (one) continue;
      while (message.more() && socket.recv(message, zmq::recv_flags::dontwait)) {
      }
      std::lock_guard lock(mutex);
      ++counts.messages;
      refuse({ErrorCode::BadData, "a message of several parts"});
    }
  }
}

Subscriber::Subscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Subscriber>> Subscriber::connect(const SubscriberOptions& options) {
  if (options.addresses.empty()) return fail(ErrorCode::InvalidArgument, "no address to listen to is given");
  auto impl = std::make_unique<Impl>(options);
  prepare(impl->socket, static_cast<std::int64_t>(kLargestMessage), Heartbeats::Taken);
  impl->socket.set(zmq::sockopt::rcvhwm, 64);
  become_client(impl->socket, options.keys);
  for (MessageKind kind : options.kinds) impl->socket.set(zmq::sockopt::subscribe, topic_of(kind));
  impl->monitor.watch(impl->socket, "subscriber");
  for (const std::string& address : options.addresses)
    if (Result<void> connected = connect_to(impl->socket, address, options.keys); !connected)
      return forward(connected);
  impl->thread = quiet_thread([i = impl.get()] { i->run(); });
  return std::unique_ptr<Subscriber>(new Subscriber(std::move(impl)));
}

Subscriber::~Subscriber() {
  impl_->stopping = true;
  impl_->queue.close();
  impl_->wake.signal();
  impl_->thread.join();
}

void Subscriber::want_tiles(std::set<std::string> serials) {
  {
    std::lock_guard lock(impl_->mutex);
    if (impl_->wanted == serials) return;
    impl_->wanted = std::move(serials);
  }
  impl_->wake.signal();
}

std::optional<Received> Subscriber::next(Nanoseconds timeout) { return impl_->queue.pop_for(timeout); }

SubscriberCounters Subscriber::counters() const {
  std::lock_guard lock(impl_->mutex);
  SubscriberCounters counts = impl_->counts;
  counts.dropped = impl_->queue.counters().dropped;
  return counts;
}

}  // namespace floatstage::studio::wire
