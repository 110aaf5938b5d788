#include "tests/support/http_client.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <utility>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage {
namespace {

constexpr int kPatienceSeconds = 60;

int connected_to(int port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience = {kPatienceSeconds, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

void send_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

bool receive_more(int fd, std::string& into) {
  char buffer[65536];
  const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
  if (got <= 0) return false;
  into.append(buffer, static_cast<std::size_t>(got));
  return true;
}

std::string request_text(std::string_view method, std::string_view path, int port,
                         const std::vector<std::string>& headers, std::string_view body) {
  std::string request = text(method, " ", path, " HTTP/1.1\r\nHost: 127.0.0.1:", port, "\r\n");
  for (const std::string& header : headers) request += header + "\r\n";
  if (!body.empty() || method == "POST") request += text("Content-Length: ", body.size(), "\r\n");
  return request + "\r\n" + std::string(body);
}

std::size_t announced_length(const std::string& headers) {
  std::string lower = headers;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::size_t at = lower.find("content-length:");
  return at == std::string::npos ? std::string::npos : std::strtoull(lower.c_str() + at + 15, nullptr, 10);
}

int status_of(const std::string& headers) { return headers.size() > 12 ? std::atoi(headers.c_str() + 9) : 0; }

}  // namespace

HttpAnswer http_request(int port, std::string_view method, std::string_view path,
                        const std::vector<std::string>& headers, std::string_view body) {
  HttpAnswer answer;
  const int fd = connected_to(port);
  if (fd < 0) return answer;
  send_all(fd, request_text(method, path, port, headers, body));
  std::string all;
  std::size_t end = std::string::npos;
  while ((end = all.find("\r\n\r\n")) == std::string::npos && receive_more(fd, all)) {
  }
  if (end != std::string::npos) {
    answer.headers = all.substr(0, end + 4);
    answer.status = status_of(answer.headers);
    answer.body = all.substr(end + 4);
    const std::size_t length = announced_length(answer.headers);
    while (answer.body.size() < length && receive_more(fd, answer.body)) {
    }
  }
  ::close(fd);
  return answer;
}

OpenConnection::OpenConnection(int port, std::string_view bytes) : fd_(connected_to(port)) {
  if (fd_ >= 0) send_all(fd_, bytes);
}

OpenConnection::OpenConnection(OpenConnection&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

OpenConnection::~OpenConnection() {
  if (fd_ >= 0) ::close(fd_);
}

bool OpenConnection::is_closed() const {
  char byte;
  return fd_ < 0 || ::recv(fd_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0 || errno == ECONNRESET;
}

WebSocketClient::WebSocketClient(int port, std::string_view path, const std::vector<std::string>& headers) {
  fd_ = connected_to(port);
  if (fd_ < 0) return;
  std::vector<std::string> all = {"Upgrade: websocket", "Connection: Upgrade",
                                  "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version: 13"};
  all.insert(all.end(), headers.begin(), headers.end());
  send_all(fd_, request_text("GET", path, port, all, {}));
  std::size_t end = std::string::npos;
  while ((end = rest_.find("\r\n\r\n")) == std::string::npos && receive_more(fd_, rest_)) {
  }
  if (end == std::string::npos) return;
  status_ = status_of(rest_);
  rest_.erase(0, end + 4);
}

WebSocketClient::~WebSocketClient() {
  if (fd_ >= 0) ::close(fd_);
}

bool WebSocketClient::read_exactly(std::size_t bytes, std::string& into) {
  while (rest_.size() < bytes)
    if (!receive_more(fd_, rest_)) return false;
  into = rest_.substr(0, bytes);
  rest_.erase(0, bytes);
  return true;
}

// A ping's answer; what a client sends is masked, here by zeros.
void WebSocketClient::answer(const std::string& ping) {
  std::string pong = {static_cast<char>(0x8a), static_cast<char>(0x80 | ping.size()), 0, 0, 0, 0};
  send_all(fd_, pong + ping);
}

// RFC 6455, section 5.2; a server masks nothing.
WebSocketClient::Message WebSocketClient::next() {
  std::string head, extended, payload;
  for (;;) {
    if (!read_exactly(2, head)) return {};
    std::uint64_t length = static_cast<unsigned char>(head[1]) & 0x7f;
    const std::size_t more = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (more > 0) {
      if (!read_exactly(more, extended)) return {};
      length = 0;
      for (const char c : extended) length = length << 8 | static_cast<unsigned char>(c);
    }
    if (!read_exactly(length, payload)) return {};
    const int kind = head[0] & 0xf;
    if (kind == 1 || kind == 2) return {kind, payload};
    if (kind == 8) return {};
    if (kind == 9) answer(payload);
  }
}

}  // namespace floatstage
