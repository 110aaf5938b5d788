#include "studio/page/page_connection.h"

#include <boost/asio/write.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "core/text.h"

namespace floatstage::studio {
namespace {

constexpr auto kTimeToAsk = std::chrono::seconds(5), kTimeToRead = std::chrono::seconds(30);
constexpr std::uint32_t kLongestHead = 8192;
constexpr std::uint64_t kLongestBody = 4096;

constexpr const char* kPageHeaders =
    "Content-Security-Policy: default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self' blob: "
    "data:; "
    "connect-src 'self' ws: wss:; base-uri 'none'; frame-ancestors 'none'; form-action 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n";

std::string as_text(const PageAnswer& answer) {
  const beast::string_view reason =
      beast::http::obsolete_reason(beast::http::int_to_status(static_cast<unsigned>(answer.status)));
  return text("HTTP/1.1 ", answer.status, " ", std::string(reason), "\r\nContent-Type: ", answer.type,
              "\r\nContent-Length: ", answer.body.size(), "\r\n", kPageHeaders, answer.more,
              "Connection: close\r\n\r\n", answer.body);
}

PageRequest request_of(const PageConnection::Request& message) {
  namespace http = beast::http;
  const auto header = [&](http::field name) { return std::string(message[name]); };
  PageRequest request;
  request.method = std::string(message.method_string());
  request.host = header(http::field::host);
  request.origin = header(http::field::origin);
  request.authorization = header(http::field::authorization);
  request.cookies = header(http::field::cookie);
  read_target({message.target().data(), message.target().size()}, request);
  return request;
}

// The other end, or its time: not what it said.
bool has_gone(beast::error_code error) {
  return error && (error == beast::http::error::end_of_stream || error == beast::error::timeout ||
                   error.category() == net::error::get_system_category());
}

}  // namespace

PageConnection::PageConnection(tcp::socket socket) : stream_(std::move(socket)) {
  parser_.header_limit(kLongestHead);
  parser_.body_limit(kLongestBody);
}

void PageConnection::read(Handler handler, std::function<void()> left) {
  left_ = std::move(left);
  stream_.expires_after(kTimeToAsk);
  beast::http::async_read(
      stream_, buffer_, parser_,
      [self = shared_from_this(), handler = std::move(handler)](beast::error_code error, std::size_t) {
        std::exchange(self->left_, nullptr)();
        if (has_gone(error)) return self->close();
        if (error) return self->answer({400, "text/plain; charset=utf-8", "This is no request.\n", {}});
        handler(self, request_of(self->parser_.get()));
      });
}

void PageConnection::answer(const PageAnswer& answer) {
  bytes_ = as_text(answer);
  stream_.expires_after(kTimeToRead);
  net::async_write(stream_, net::buffer(bytes_), [self = shared_from_this()](beast::error_code, std::size_t) {
    beast::error_code ignored;
    self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    self->close();
  });
}

void PageConnection::close() {
  gone_ = true;
  beast::error_code ignored;
  stream_.socket().close(ignored);
}

void PageConnection::watch() {
  stream_.socket().async_wait(tcp::socket::wait_read, [self = shared_from_this()](beast::error_code error) {
    if (error) return;
    char byte;
    beast::error_code why;
    const std::size_t heard =
        self->stream_.socket().receive(net::buffer(&byte, 1), tcp::socket::message_peek, why);
    if (why || heard == 0) self->gone_ = true;
  });
}

bool PageConnection::wants_live() const { return beast::websocket::is_upgrade(parser_.get()); }

}  // namespace floatstage::studio
