#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include "studio/page/page_sockets.h"

namespace floatstage::studio {

/// The browsers that watch a node's page: one WebSocket each, over which everything goes. A viewer that does
/// not read loses the oldest messages, which are counted, and holds up nobody. One thread's, but for the
/// counters.
class PageViewers {
 public:
  using Request = beast::http::request<beast::http::string_body>;
  struct Message {
    enum class Kind { Text, Binary } kind = Kind::Text;
    std::shared_ptr<const std::string> bytes;
  };

  /// `queue` messages wait for a viewer at most.
  explicit PageViewers(std::size_t queue) : queue_(queue) {}

  /// Makes a viewer of who asked for `upgrade` over `stream`.
  void add(beast::tcp_stream stream, Request upgrade);
  void send(const Message& message);
  void close();
  std::size_t count() const { return count_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  class Viewer;
  void remove(const std::shared_ptr<Viewer>& viewer);

  const std::size_t queue_;
  std::set<std::shared_ptr<Viewer>> viewers_;
  std::atomic<std::size_t> count_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace floatstage::studio
