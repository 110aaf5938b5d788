#include "studio/network/keys.h"

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::studio::wire {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLetters = 40;
constexpr std::string_view kTitle =
    "# Keys of a Floatstage studio: copy this file to its machines, and to no other.\n";

// The letters after `name = "` on a line of its own.
std::string value_of(std::string_view bytes, std::string_view name) {
  const std::string begin = text("\n", name, " = \"");
  const std::size_t at = bytes.find(begin);
  if (at == std::string_view::npos) return "";
  const std::string_view rest = bytes.substr(at + begin.size());
  // A quotation mark is none of Z85's letters.
  const std::size_t end = rest.find('"');
  return end == kLetters ? std::string(rest.substr(0, end)) : "";
}

bool belong_together(const StudioKeys& keys) {
  char derived[kLetters + 1] = {};
  return zmq_curve_public(derived, keys.secret_key.c_str()) == 0 && keys.public_key == derived;
}

struct HostAndPort {
  std::string host, port;
};

// ZeroMQ reads more into an address than it shows: a source before ';', several in a row, an interface's
// name.
std::optional<HostAndPort> split_address(const std::string& address) {
  constexpr std::string_view kTcp = "tcp://";
  if (!address.starts_with(kTcp)) return std::nullopt;
  const std::size_t colon = address.rfind(':');
  if (colon < kTcp.size() + 1) return std::nullopt;
  HostAndPort parts{address.substr(kTcp.size(), colon - kTcp.size()), address.substr(colon + 1)};
  const bool is_v6 = parts.host.size() > 2 && parts.host.front() == '[' && parts.host.back() == ']';
  if (is_v6) parts.host = parts.host.substr(1, parts.host.size() - 2);
  const std::string allowed = is_v6 ? "0123456789abcdefABCDEF:.%" : "";
  for (const char c : parts.host)
    if (is_v6 ? allowed.find(c) == std::string::npos
              : !std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_' && c != '*')
      return std::nullopt;
  unsigned port = 0;
  const auto [end, error] = std::from_chars(parts.port.data(), parts.port.data() + parts.port.size(), port);
  const bool any = parts.port == "*";
  if (!any && (error != std::errc() || end != parts.port.data() + parts.port.size() || port > 65535))
    return std::nullopt;
  return parts;
}

bool is_loopback(const sockaddr& address) {
  if (address.sa_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24 == 127;
  return address.sa_family == AF_INET6 &&
         IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

// A number, or "localhost" where it means nothing else: another name may lead elsewhere the next time it is
// looked up.
bool is_local(const std::string& host) {
  addrinfo wanted = {};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = host == "localhost" ? 0 : AI_NUMERICHOST;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), nullptr, &wanted, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owned(found, &::freeaddrinfo);
  for (const addrinfo* each = found; each; each = each->ai_next)
    if (!is_loopback(*each->ai_addr)) return false;
  return found != nullptr;
}

}  // namespace

Result<StudioKeys> make_keys() {
  char public_key[kLetters + 1], secret_key[kLetters + 1];
  if (zmq_curve_keypair(public_key, secret_key) != 0)
    return fail(ErrorCode::Unsupported, "this build of ZeroMQ knows no CURVE; install one with libsodium");
  return StudioKeys{public_key, secret_key};
}

Result<void> save_keys(const StudioKeys& keys, const fs::path& file) {
  const std::string bytes =
      text(kTitle, "public = \"", keys.public_key, "\"\nsecret = \"", keys.secret_key, "\"\n");
  // Never readable by others, not even before it is complete.
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (fd < 0 && errno == EEXIST)
    return fail(ErrorCode::AlreadyExists,
                text(file.string(), ": is there already; keys are never written over, name another file"));
  const bool written = fd >= 0 &&
                       ::write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()) &&
                       ::fsync(fd) == 0;
  const int reason = errno;
  if (fd >= 0) ::close(fd);
  if (written) return {};
  if (fd >= 0) ::unlink(file.c_str());
  return fail(ErrorCode::Io, text(file.string(), ": cannot be written: ", std::strerror(reason)));
}

Result<StudioKeys> load_keys(const fs::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  struct stat facts = {};
  if (::stat(file.c_str(), &facts) == 0 && (facts.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return fail(ErrorCode::InvalidArgument,
                text(file.string(), ": others may read these keys; make new ones, or `chmod 600 ",
                     file.string(), "` where nobody has"));
  StudioKeys keys{value_of(*bytes, "public"), value_of(*bytes, "secret")};
  if (keys.public_key.empty() || keys.secret_key.empty() || !belong_together(keys))
    return fail(ErrorCode::BadData,
                text(file.string(), ": holds no keys; make some with `floatstage keys --out FILE`"));
  return keys;
}

Result<void> check_address(const std::string& address, const std::optional<StudioKeys>& keys) {
  const std::optional<HostAndPort> parts = split_address(address);
  if (!parts)
    return fail(ErrorCode::InvalidArgument,
                text("'", address,
                     "': an address is tcp://<host>:<port>, one host and one port, for example "
                     "tcp://127.0.0.1:5570"));
  if (keys || is_local(parts->host)) return {};
  return fail(ErrorCode::InvalidArgument,
              text("'", address,
                   "': leaves this machine, and without keys everybody there could listen and command; make ",
                   "keys with `floatstage keys --out studio.keys`, copy them to the studio's machines and "
                   "name them, or ",
                   "stay on 127.0.0.1"));
}

}  // namespace floatstage::studio::wire
