#include "tests/pipeline/export/folder_server.h"

#include <stdexcept>

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr int kPatience = 200;  // ms: for a request on an open connection, and to notice that it is over

bool is_readable(int socket) {
  pollfd wanted{socket, POLLIN, 0};
  return ::poll(&wanted, 1, kPatience) > 0;
}

std::string type_of(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".html" ? "text/html" : extension == ".css" ? "text/css" : "text/javascript";
}

// The answer to "GET /name HTTP/1.1".
std::string answer_to(const std::string& request, const std::filesystem::path& folder) {
  const std::size_t from = request.find('/'), to = request.find(' ', from);
  const std::filesystem::path file = folder / request.substr(from + 1, to - from - 1);
  const Result<std::string> content = read_file(file);
  if (!content) return "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
  return text("HTTP/1.1 200 OK\r\nContent-Type: ", type_of(file), "\r\nContent-Length: ", content->size(),
              "\r\nConnection: close\r\n\r\n", *content);
}

}  // namespace

FolderServer::FolderServer(std::filesystem::path folder) : folder_(std::move(folder)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
  if (socket_ < 0 || ::bind(socket_, any, size) != 0 || ::listen(socket_, 16) != 0 ||
      ::getsockname(socket_, any, &size) != 0)
    throw std::runtime_error("no port for a server");
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

FolderServer::~FolderServer() {
  done_ = true;
  thread_.join();
  ::close(socket_);
}

std::string FolderServer::url() const { return text("http://127.0.0.1:", port_, "/"); }

void FolderServer::serve() {
  while (!done_) {
    if (!is_readable(socket_)) continue;
    const int peer = ::accept(socket_, nullptr, nullptr);
    std::string request(4096, '\0');
    // Browsers open connections in advance: one without a request is closed.
    const ssize_t got = is_readable(peer) ? ::recv(peer, request.data(), request.size(), 0) : 0;
    if (got > 0) {
      request.resize(static_cast<std::size_t>(got));
      const std::string answer = answer_to(request, folder_);
      for (std::size_t sent = 0; sent < answer.size();) {
        const ssize_t n = ::send(peer, answer.data() + sent, answer.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) break;
        sent += static_cast<std::size_t>(n);
      }
    }
    ::close(peer);
  }
}

}  // namespace floatstage
