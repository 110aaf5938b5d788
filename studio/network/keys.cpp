#include "studio/network/keys.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
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

bool is_local(std::string_view host) {
  return host.starts_with("127.") || host == "localhost" || host == "[::1]";
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
  constexpr std::string_view kTcp = "tcp://";
  const bool tcp = address.starts_with(kTcp);
  const std::size_t colon = address.rfind(':');
  if (!tcp || colon < kTcp.size() + 1)
    return fail(ErrorCode::InvalidArgument,
                text("'", address, "': an address is tcp://<host>:<port>, for example tcp://127.0.0.1:5570"));
  const std::string host = address.substr(kTcp.size(), colon - kTcp.size());
  if (keys || is_local(host)) return {};
  return fail(ErrorCode::InvalidArgument,
              text("'", address,
                   "': leaves this machine, and without keys everybody there could listen and command; make ",
                   "keys with `floatstage keys --out studio.keys`, copy them to the studio's machines and "
                   "name them, or ",
                   "stay on 127.0.0.1"));
}

}  // namespace floatstage::studio::wire
