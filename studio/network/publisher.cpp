#include "studio/network/publisher.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <variant>

#include "core/bounded_queue.h"
#include "core/log.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

using Told = std::variant<std::shared_ptr<const CameraView>, std::shared_ptr<const StudioScene>, NodeStatus>;

// A subscription is one byte and a topic.
constexpr std::int64_t kLongestFromSubscriber = 4096;
constexpr int kBurst = 16;
constexpr std::size_t kLongestTopic = kHeaderBytes, kMostTopics = 4096;

}  // namespace

struct Publisher::Impl {
  Impl(const PublisherOptions& o)
      : options(o),
        socket(context, zmq::socket_type::xpub),
        monitor(context),
        door(context, o.keys),
        queue(static_cast<std::size_t>(std::max(1, o.queue)), QueuePolicy::DropOldest) {}

  void run();
  void read_subscriptions();
  void send(const Told& told);
  void send(Result<std::string> message, std::uint64_t PublisherCounters::*count,
            std::uint64_t PublisherCounters::*bytes);
  bool is_wanted(const std::string& topic) const;  // under `mutex`

  const PublisherOptions options;
  zmq::context_t context;
  zmq::socket_t socket;
  SocketMonitor monitor;
  DoorKeeper door;
  WakeUp wake;
  std::string address;
  const std::uint64_t session = draw_session();
  BoundedQueue<Told> queue;
  std::map<std::string, std::uint64_t> sequences;  // by topic; the thread's own

  mutable std::mutex mutex;  // over what follows
  std::set<std::string> topics;
  PublisherCounters counts;

  std::atomic<bool> stopping{false};
  std::thread thread;
};

void Publisher::Impl::read_subscriptions() {
  zmq::message_t message;
  while (socket.recv(message, zmq::recv_flags::dontwait)) {
    const std::string_view bytes = bytes_of(message);
    std::lock_guard lock(mutex);
    const bool subscribes = !bytes.empty() && bytes[0] == 1, leaves = !bytes.empty() && bytes[0] == 0;
    if (leaves)
      topics.erase(std::string(bytes.substr(1)));
    else if (subscribes && bytes.size() <= kLongestTopic && topics.size() < kMostTopics)
      topics.emplace(bytes.substr(1));
    else
      ++counts.malformed;
  }
}

bool Publisher::Impl::is_wanted(const std::string& topic) const {
  return std::any_of(topics.begin(), topics.end(),
                     [&](const std::string& asked) { return topic.starts_with(asked); });
}

void Publisher::Impl::send(Result<std::string> message, std::uint64_t PublisherCounters::*count,
                           std::uint64_t PublisherCounters::*bytes) {
  if (!message) {
    log::warning(message.error().message);
    std::lock_guard lock(mutex);
    ++counts.unsendable;
    return;
  }
  // The topic of a message is what it begins with, up to the zero after its serial.
  const std::string topic(message->c_str());
  stamp(*message, session, sequences[topic]++);
  auto* owned = new std::string(std::move(*message));
  zmq::message_t sent(
      owned->data(), owned->size(), [](void*, void* string) { delete static_cast<std::string*>(string); },
      owned);
  const std::size_t size = sent.size();
  socket.send(sent, zmq::send_flags::dontwait);
  std::lock_guard lock(mutex);
  ++(counts.*count);
  counts.*bytes += size;
}

void Publisher::Impl::send(const Told& told) {
  if (const auto* view = std::get_if<std::shared_ptr<const CameraView>>(&told)) {
    send(encode_outline(**view), &PublisherCounters::outlines, &PublisherCounters::outline_bytes);
    if (!(*view)->tile) return;
    bool wanted = false;
    {
      std::lock_guard lock(mutex);
      wanted = is_wanted(topic_of(MessageKind::Tile, (*view)->serial));
    }
    if (!wanted) return;
    send(encode_tile(**view, options.tiles), &PublisherCounters::tiles, &PublisherCounters::tile_bytes);
    std::lock_guard lock(mutex);
    ++counts.tiles_by_camera[(*view)->serial];
  } else if (const auto* scene = std::get_if<std::shared_ptr<const StudioScene>>(&told)) {
    send(encode_scene(**scene), &PublisherCounters::scenes, &PublisherCounters::scene_bytes);
  } else {
    send(encode_status(std::get<NodeStatus>(told)), &PublisherCounters::statuses,
         &PublisherCounters::status_bytes);
  }
}

void Publisher::Impl::run() {
  zmq::pollitem_t items[] = {{socket.handle(), 0, ZMQ_POLLIN, 0}, door.item(), monitor.item(), wake.item()};
  while (!stopping) {
    wait_for(items, std::chrono::milliseconds(1000));
    wake.drain();
    door.answer_all();
    read_subscriptions();
    const std::uint64_t refusals = monitor.read_refusals();
    if (refusals > 0) {
      std::lock_guard lock(mutex);
      counts.refused += refusals;
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
  prepare(impl->socket, kLongestFromSubscriber, Heartbeats::Given);
  impl->socket.set(zmq::sockopt::rcvhwm, 0);  // subscriptions never wait in ZeroMQ: see Heartbeats
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
  return impl_->is_wanted(topic_of(MessageKind::Tile, serial));
}

const std::string& Publisher::address() const { return impl_->address; }

PublisherCounters Publisher::counters() const {
  std::lock_guard lock(impl_->mutex);
  PublisherCounters counts = impl_->counts;
  counts.dropped = impl_->queue.counters().dropped;
  return counts;
}

}  // namespace floatstage::studio::wire
