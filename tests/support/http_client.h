#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace floatstage {

/// What a server answered.
struct HttpAnswer {
  int status = 0;  ///< 0: there was no answer
  std::string headers, body;
};

/// One HTTP/1.1 request to 127.0.0.1:`port`, without any library: `method`, path with query, header lines
/// ("Name: value"), body. Waits until the server closes or has sent all that it announced.
HttpAnswer http_request(int port, std::string_view method, std::string_view path,
                        const std::vector<std::string>& headers = {}, std::string_view body = {});

/// A connection to 127.0.0.1:`port` that has sent some bytes and waits.
class OpenConnection {
 public:
  OpenConnection(int port, std::string_view bytes);
  ~OpenConnection();
  OpenConnection(OpenConnection&& other) noexcept;
  OpenConnection& operator=(OpenConnection&&) = delete;

  /// Whether the server has closed it, or it never was open.
  bool is_closed() const;

 private:
  int fd_;
};

/// A WebSocket client, to read what a page reads: each message with its kind (1 text, 2 binary). Pings are
/// answered while somebody reads.
class WebSocketClient {
 public:
  WebSocketClient(int port, std::string_view path, const std::vector<std::string>& headers = {});
  ~WebSocketClient();
  WebSocketClient(const WebSocketClient&) = delete;
  WebSocketClient& operator=(const WebSocketClient&) = delete;

  /// Of the upgrade: 101 when it is open.
  int status() const { return status_; }
  struct Message {
    int kind = 0;  ///< 0: the server has gone
    std::string bytes;
  };
  Message next();

 private:
  bool read_exactly(std::size_t bytes, std::string& into);
  void answer(const std::string& ping);
  int fd_ = -1;
  int status_ = 0;
  std::string rest_;
};

}  // namespace floatstage
