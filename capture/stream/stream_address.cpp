#include "capture/stream/stream_address.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <vector>

extern "C" {
#include <libavformat/avio.h>
#include <libavutil/opt.h>
}

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

using Kind = StreamAddress::Kind;

constexpr const char* kUsage =
    "say srt://127.0.0.1:9000?mode=listener, srt://HOST:PORT, udp://HOST:PORT, rtp://HOST:PORT, "
    "rtsp://HOST:PORT/NAME, file:OUT.ts or v4l2:/dev/videoN";

Unexpected wrong(const std::string& shown, const std::string& what) {
  return fail(ErrorCode::InvalidArgument, text("--stream ", shown, ": ", what));
}

std::string after(const std::string& url, std::size_t n) { return url.substr(std::min(n, url.size())); }

// The value of an option is nobody's business where it is a secret, nor is what stands before the host.
std::string without_secrets(const std::string& url) {
  std::string shown = url;
  if (const std::size_t at = shown.find("passphrase="); at != std::string::npos) {
    const std::size_t begin = at + std::strlen("passphrase="), end = shown.find('&', begin);
    shown.replace(begin, (end == std::string::npos ? shown.size() : end) - begin, "…");
  }
  const std::size_t host = shown.find("://"), path = shown.find_first_of("/?", host + 3);
  const std::size_t user = host == std::string::npos ? host : shown.substr(0, path).rfind('@');
  if (user != std::string::npos && user > host) shown.replace(host + 3, user - host - 3, "…");
  return shown;
}

struct Given {
  std::string name, value;
};

std::vector<Given> options_of(const std::string& url) {
  std::vector<Given> all;
  const std::size_t question = url.find('?');
  for (std::string rest = question == std::string::npos ? "" : after(url, question + 1); !rest.empty();) {
    const std::string item = rest.substr(0, rest.find('&'));
    rest = after(rest, item.size() + 1);
    const std::size_t equals = item.find('=');
    all.push_back({item.substr(0, equals), equals == std::string::npos ? "" : after(item, equals + 1)});
  }
  return all;
}

// HOST:PORT of "srt://user@HOST:PORT/…?…".
Result<void> read_host(StreamAddress& a) {
  std::string host = after(a.url, a.url.find("://") + 3);
  host = host.substr(0, host.find_first_of("/?"));
  if (const std::size_t user = host.rfind('@'); user != std::string::npos) host = after(host, user + 1);
  const std::size_t colon = host.rfind(':'), bracket = host.rfind(']');
  const bool has_port = colon != std::string::npos && (bracket == std::string::npos || colon > bracket);
  const std::string port = has_port ? after(host, colon + 1) : "";
  host = has_port ? host.substr(0, colon) : host;
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  a.host = host;
  if (!has_port && a.kind == Kind::Rtsp) {
    a.port = 554;
  } else {
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), a.port);
    if (error != std::errc() || end != port.data() + port.size() || a.port < 1 || a.port > 65'535)
      return wrong(a.shown, text("it needs a port from 1 to 65535 behind the host; ", kUsage));
  }
  return {};
}

Result<void> read_options(StreamAddress& a, const char* protocol) {
  const AVClass* kind = avio_protocol_get_class(protocol);
  if (kind == nullptr)
    return fail(ErrorCode::Unsupported, text("--stream ", a.shown, ": this libavformat has no ", protocol));
  for (const Given& option : options_of(a.url)) {
    if (av_opt_find(&kind, option.name.c_str(), nullptr, 0, AV_OPT_SEARCH_FAKE_OBJ) == nullptr)
      return wrong(a.shown, text(protocol, " has no option '", option.name,
                                 "'; `ffmpeg -h protocol=", protocol, "` lists them"));
    if (a.kind != Kind::Srt) continue;
    if (option.name == "passphrase") {
      if (option.value.size() < 10 || option.value.size() > 79)
        return wrong(a.shown, "a passphrase has 10 to 79 characters");
      a.encrypted = true;
    }
    if (option.name == "mode") {
      if (option.value != "listener" && option.value != "caller" && option.value != "rendezvous")
        return wrong(a.shown, "mode is listener (players call), caller or rendezvous");
      a.listens = option.value == "listener";
    }
  }
  return {};
}

struct AddressesDeleter {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, AddressesDeleter>;

Result<Addresses> look_up(const StreamAddress& a) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = a.host.empty() ? AI_PASSIVE : 0;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(a.port);
  const int error = ::getaddrinfo(a.host.empty() ? nullptr : a.host.c_str(), port.c_str(), &hints, &found);
  if (error != 0)
    return fail(ErrorCode::NotFound, text("--stream ", a.shown, ": there is no host '", a.host, "' (",
                                          ::gai_strerror(error), "); check its name"));
  return Addresses(found);
}

bool is_loopback(const sockaddr& address) {
  if (address.sa_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24 == 127;
  return address.sa_family == AF_INET6 &&
         IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

}  // namespace

Result<StreamAddress> parse_stream_address(const std::string& url) {
  StreamAddress a;
  a.url = url;
  a.shown = without_secrets(url);
  for (const auto& [word, kind] : {std::pair("file:", Kind::File), std::pair("v4l2:", Kind::V4l2)}) {
    if (!url.starts_with(word)) continue;
    a.kind = kind;
    a.path = after(url, std::strlen(word));
    if (a.path.empty()) return wrong(a.shown, text("it names no path; ", kUsage));
    return a;
  }
  constexpr std::array<std::pair<const char*, Kind>, 4> kNetwork = {
      {{"srt", Kind::Srt}, {"udp", Kind::Udp}, {"rtp", Kind::Rtp}, {"rtsp", Kind::Rtsp}}};
  for (const auto& [word, kind] : kNetwork) {
    if (!url.starts_with(text(word, "://"))) continue;
    a.kind = kind;
    if (Result<void> ok = read_host(a); !ok) return forward(ok);
    if (kind != Kind::Rtsp)
      if (Result<void> ok = read_options(a, word); !ok) return forward(ok);
    if (a.host.empty() && !a.listens)
      return wrong(a.shown, kind == Kind::Srt
                                ? "it names no host to call; to be called by players, add ?mode=listener"
                                : text("it names no host; ", kUsage));
    return a;
  }
  return wrong(a.shown, text("no such kind of stream; ", kUsage));
}

Result<bool> is_loopback(const StreamAddress& address) {
  const Result<Addresses> all = look_up(address);
  if (!all) return forward(all);
  for (const addrinfo* one = all->get(); one != nullptr; one = one->ai_next)
    if (!is_loopback(*one->ai_addr)) return false;
  return true;
}

Result<void> check_port_is_free(const StreamAddress& address) {
  const Result<Addresses> all = look_up(address);
  if (!all) return forward(all);
  const addrinfo& first = **all;
  const FileDescriptor probe(::socket(first.ai_family, first.ai_socktype | SOCK_CLOEXEC, 0));
  if (probe && ::bind(probe.get(), first.ai_addr, first.ai_addrlen) == 0) return {};
  const int error = errno;
  if (error == EADDRINUSE)
    return fail(ErrorCode::Io, text("--stream ", address.shown, ": another program has port ", address.port,
                                    "; choose another"));
  return fail(ErrorCode::Io, text("--stream ", address.shown, ": it cannot listen there (",
                                  std::strerror(error), "); is it an address of this machine?"));
}

}  // namespace floatstage::capture
