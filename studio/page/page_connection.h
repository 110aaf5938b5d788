#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include "studio/page/page_request.h"
#include "studio/page/page_sockets.h"

namespace floatstage::studio {

/// An answer to a request, ready to be sent.
struct PageAnswer {
  int status = 200;
  std::string type = "application/json", body;
  std::string more;  ///< further header lines, each with its CRLF
};

/// One connection of the page: reads one request within a few seconds, gives it away, writes the answer,
/// closes. All on the thread of the sockets, but for gone().
class PageConnection : public std::enable_shared_from_this<PageConnection> {
 public:
  using Request = beast::http::request<beast::http::string_body>;
  /// Gets the request when it is whole. Whoever is not known by then is a stranger.
  using Handler = std::function<void(const std::shared_ptr<PageConnection>&, const PageRequest&)>;

  explicit PageConnection(tcp::socket socket);
  /// `left`: it is no longer one of those who have not asked yet.
  void read(Handler handler, std::function<void()> left);
  void answer(const PageAnswer& answer);
  void close();

  /// Begins to look whether the other end goes away.
  void watch();
  /// Whether it has gone since watch(). Any thread.
  bool gone() const { return gone_; }

  bool wants_live() const;
  /// What a WebSocket is made of. Nothing may be asked of this afterwards.
  beast::tcp_stream take_stream() { return std::move(stream_); }
  Request take_request() { return parser_.release(); }

 private:
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  beast::http::request_parser<beast::http::string_body> parser_;
  std::string bytes_;  // of the answer
  std::function<void()> left_;
  std::atomic<bool> gone_{false};
};

}  // namespace floatstage::studio
