#include "studio/network/subscriber.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/bounded_queue.h"
#include "core/log.h"
#include "core/rig.h"
#include "core/text.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/view_message.h"
#include "studio/messages/watch_message.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

using Clock = std::chrono::steady_clock;

// Cameras of a studio, four kinds each; a peer that invents serials does not fill our memory.
constexpr std::size_t kMostTopics = 8 * 1024;

constexpr std::chrono::milliseconds kSayAgain{500};
constexpr int kBurst = 16;
constexpr int kWaitingWatches = 4, kGoodByeMs = 50;

using Topic = std::pair<MessageKind, std::string>;
struct Place {
  std::uint64_t session = 0, next = 0;
};

// The connection to one publisher: what is told to one must not be another's turn.
struct Line {
  Line(zmq::context_t& context) : socket(context, zmq::socket_type::dealer), monitor(context) {}
  zmq::socket_t socket;
  SocketMonitor monitor;
  bool told = false;  // the watch as it is now
};

}  // namespace

struct Subscriber::Impl {
  Impl(const SubscriberOptions& o)
      : queue(static_cast<std::size_t>(std::max(1, o.queue)), QueuePolicy::DropOldest) {}

  Result<void> join(const std::string& address, const std::optional<StudioKeys>& keys);
  void run();
  void change_tiles();
  void say_watch();
  void look_who_came();
  void read(Line& line);
  void take(std::string_view bytes);
  void count_place(const MessageHeader& header);  // under `mutex`
  void refuse(const Error& error);                // under `mutex`
  Result<Received> decode(const Message& message);

  zmq::context_t context;
  WakeUp wake;
  BoundedQueue<Received> queue;
  // The thread's own.
  std::vector<std::unique_ptr<Line>> lines;
  Watch watch;
  std::string sealed_watch;
  Clock::time_point said;
  std::map<Topic, Place> places;
  Clock::time_point warned;

  mutable std::mutex mutex;  // over what follows
  std::set<std::string> wanted;
  SubscriberCounters counts;

  std::atomic<bool> stopping{false};
  std::thread thread;
};

Result<void> Subscriber::Impl::join(const std::string& address, const std::optional<StudioKeys>& keys) {
  auto line = std::make_unique<Line>(context);
  prepare(line->socket, static_cast<std::int64_t>(kLargestMessage), Heartbeats::Taken);
  line->socket.set(zmq::sockopt::rcvhwm, 64);
  line->socket.set(zmq::sockopt::sndhwm, kWaitingWatches);
  line->socket.set(zmq::sockopt::linger, kGoodByeMs);
  line->socket.set(zmq::sockopt::immediate, true);  // no watch waits for a publisher that is not there
  become_client(line->socket, keys);
  line->monitor.watch(line->socket, text("line", lines.size()));
  if (Result<void> connected = connect_to(line->socket, address, keys); !connected) return connected;
  lines.push_back(std::move(line));
  return {};
}

void Subscriber::Impl::change_tiles() {
  std::set<std::string> now;
  {
    std::lock_guard lock(mutex);
    now = wanted;
  }
  if (now == watch.tiles) return;
  for (const std::string& serial : watch.tiles)
    if (!now.contains(serial)) places.erase({MessageKind::Tile, serial});
  watch.tiles = std::move(now);
  sealed_watch = *encode_watch(watch);
  for (const auto& line : lines) line->told = false;
}

void Subscriber::Impl::say_watch() {
  const bool again = Clock::now() - said >= kSayAgain;
  if (again) said = Clock::now();
  for (const auto& line : lines) {
    if (line->told && !again) continue;
    static_cast<void>(line->socket.get(zmq::sockopt::events));  // or it may not know yet who came
    line->told = line->socket.send(zmq::buffer(sealed_watch), zmq::send_flags::dontwait).has_value();
  }
}

void Subscriber::Impl::count_place(const MessageHeader& header) {
  const Topic topic(header.kind, header.serial);
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
      return fail(ErrorCode::BadData, text("message: a publisher sends no ", name_of(message.header.kind)));
  }
}

void Subscriber::Impl::take(std::string_view bytes) {
  const Result<Message> message = open(bytes);
  const bool asked_for = message && watch.covers(message->header.kind, message->header.serial);
  if (message && !asked_for && message->header.kind == MessageKind::Tile) return;  // it was on its way
  Result<Received> received =
      !message ? Result<Received>(forward(message))
      : asked_for
          ? decode(*message)
          : fail(ErrorCode::BadData, text("message: nobody asked for a ", name_of(message->header.kind)));
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

void Subscriber::Impl::look_who_came() {
  std::uint64_t refused = 0;
  for (const auto& line : lines) {
    if (line->monitor.read() > 0) line->told = false;
    refused += line->monitor.refused();
  }
  std::lock_guard lock(mutex);
  counts.refused = refused;
}

void Subscriber::Impl::read(Line& line) {
  zmq::message_t message;
  // A flood must not keep us from looking at the rest.
  for (int burst = 0; burst < kBurst && !stopping && line.socket.recv(message, zmq::recv_flags::dontwait);
       ++burst) {
    const bool one = !message.more();
    if (one) take(bytes_of(message));
    if (one) continue;
    while (message.more() && line.socket.recv(message, zmq::recv_flags::dontwait)) {
    }
    std::lock_guard lock(mutex);
    ++counts.messages;
    refuse({ErrorCode::BadData, "a message of several parts"});
  }
}

void Subscriber::Impl::run() {
  std::vector<zmq::pollitem_t> items = {wake.item()};
  for (const auto& line : lines) {
    items.push_back({line->socket.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back(line->monitor.item());
  }
  while (!stopping) {
    wait_for(items, kSayAgain);
    wake.drain();
    change_tiles();
    look_who_came();
    say_watch();
    for (const auto& line : lines) read(*line);
  }
  // Good-bye: nobody cuts out textures for who has left.
  sealed_watch = *encode_watch({});
  for (const auto& line : lines) line->told = false;
  say_watch();
}

Subscriber::Subscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Subscriber>> Subscriber::connect(const SubscriberOptions& options) {
  if (options.addresses.empty()) return fail(ErrorCode::InvalidArgument, "no address to listen to is given");
  auto impl = std::make_unique<Impl>(options);
  impl->watch.kinds = {options.kinds.begin(), options.kinds.end()};
  Result<std::string> sealed = encode_watch(impl->watch);
  if (!sealed) return forward(sealed);
  impl->sealed_watch = std::move(*sealed);
  for (const std::string& address : options.addresses)
    if (Result<void> joined = impl->join(address, options.keys); !joined) return forward(joined);
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
  std::erase_if(serials,
                [](const std::string& s) { return !is_usable_serial(s) || s.size() > kLongestSerial; });
  while (serials.size() > kMostWatched) serials.erase(std::prev(serials.end()));
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
