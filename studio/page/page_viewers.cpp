#include "studio/page/page_viewers.h"

#include <deque>

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>

namespace floatstage::studio {
namespace {

// A browser answers a ping; one that does not for so long has gone, or never reads.
constexpr auto kSilence = std::chrono::seconds(20);
constexpr std::size_t kLongestMessage = 1024;  // nothing is expected

}  // namespace

class PageViewers::Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(PageViewers& all, beast::tcp_stream stream) : all_(all), socket_(std::move(stream)) {}

  void begin(Request upgrade) {
    beast::get_lowest_layer(socket_).expires_never();
    beast::websocket::stream_base::timeout patience =
        beast::websocket::stream_base::timeout::suggested(beast::role_type::server);
    patience.handshake_timeout = kSilence;
    patience.idle_timeout = kSilence;
    patience.keep_alive_pings = true;
    socket_.set_option(patience);
    socket_.read_message_max(kLongestMessage);
    upgrade_ = std::move(upgrade);
    socket_.async_accept(upgrade_, [self = shared_from_this()](beast::error_code error) {
      if (error) return self->end();
      self->open_ = true;
      self->listen();
      self->write();
    });
  }

  void push(const Message& message) {
    if (waiting_.size() >= all_.queue_) {
      waiting_.pop_front();
      ++all_.dropped_;
    }
    waiting_.push_back(message);
    if (open_) write();
  }

  void close() {
    open_ = false;
    beast::error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

 private:
  // What it sends is thrown away; that it closes is what matters.
  void listen() {
    socket_.async_read(heard_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return self->end();
      self->heard_.clear();
      self->listen();
    });
  }

  void write() {
    if (writing_.bytes || waiting_.empty()) return;
    writing_ = std::move(waiting_.front());
    waiting_.pop_front();
    socket_.binary(writing_.kind == Message::Kind::Binary);
    socket_.async_write(net::buffer(*writing_.bytes),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          self->writing_ = {};
                          if (error) return self->end();
                          self->write();
                        });
  }

  void end() {
    if (!std::exchange(ended_, true)) all_.remove(shared_from_this());
  }

  PageViewers& all_;
  beast::websocket::stream<beast::tcp_stream> socket_;
  Request upgrade_;
  beast::flat_buffer heard_;
  std::deque<Message> waiting_;
  Message writing_;
  bool open_ = false, ended_ = false;
};

void PageViewers::add(beast::tcp_stream stream, Request upgrade) {
  const auto viewer = std::make_shared<Viewer>(*this, std::move(stream));
  viewers_.insert(viewer);
  count_ = viewers_.size();
  viewer->begin(std::move(upgrade));
}

void PageViewers::remove(const std::shared_ptr<Viewer>& viewer) {
  viewer->close();
  viewers_.erase(viewer);
  count_ = viewers_.size();
}

void PageViewers::send(const Message& message) {
  for (const auto& viewer : viewers_) viewer->push(message);
}

void PageViewers::close() {
  for (const auto& viewer : viewers_) viewer->close();
  viewers_.clear();
  count_ = 0;
}

}  // namespace floatstage::studio
