#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/bounded_queue.h"

struct mg_connection;

namespace floatstage::studio {

/// The browsers that watch a node's page: one WebSocket each, over which everything goes. A viewer that does
/// not read loses the oldest messages, which are counted, and holds up nobody. Safe from any thread.
class PageViewers {
 public:
  /// `queue` messages wait for a viewer at most.
  explicit PageViewers(std::size_t queue) : queue_(queue) {}
  ~PageViewers() { close(); }

  struct Message {
    enum class Kind { Text, Binary } kind = Kind::Text;
    std::shared_ptr<const std::string> bytes;
  };

  void add(mg_connection* connection);
  /// Returns when nothing is sent over it any more.
  void remove(mg_connection* connection);
  void send(const Message& message);
  void close();
  std::size_t count() const;
  std::uint64_t dropped() const;

 private:
  struct Viewer {
    Viewer(mg_connection* c, std::size_t queue) : connection(c), messages(queue, QueuePolicy::DropOldest) {}
    mg_connection* connection;
    BoundedQueue<Message> messages;
    std::thread sender;
  };
  static void run(Viewer& viewer);
  static void end(Viewer& viewer);

  const std::size_t queue_;
  mutable std::mutex mutex_;
  std::list<std::unique_ptr<Viewer>> viewers_;
  std::uint64_t dropped_ = 0;  // by those who have left
};

}  // namespace floatstage::studio
