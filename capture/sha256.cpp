#include "capture/sha256.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include <openssl/evp.h>
#include <unistd.h>

#include "core/check.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

class Hash {
 public:
  Hash() {
    FLOATSTAGE_CHECK(state_ && EVP_DigestInit_ex(state_.get(), EVP_sha256(), nullptr) == 1,
                     "libcrypto without SHA-256");
  }
  void add(std::string_view bytes) {
    FLOATSTAGE_CHECK(EVP_DigestUpdate(state_.get(), bytes.data(), bytes.size()) == 1, "libcrypto hashes");
  }
  std::string hex() {
    std::array<unsigned char, 32> digest;
    FLOATSTAGE_CHECK(EVP_DigestFinal_ex(state_.get(), digest.data(), nullptr) == 1, "libcrypto hashes");
    std::string hex;
    for (const unsigned char byte : digest) {
      hex += "0123456789abcdef"[byte >> 4];
      hex += "0123456789abcdef"[byte & 15];
    }
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> state_{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

}  // namespace

std::string sha256(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return hash.hex();
}

Result<FileHash> sha256_of_file(const std::filesystem::path& file,
                                const std::function<bool(std::uint64_t)>& go_on) {
  const Result<FileDescriptor> open = open_to_read(file);
  if (!open) return forward(open);
  Hash hash;
  FileHash of;
  std::vector<char> piece(std::size_t{1} << 20);
  for (;;) {
    const ssize_t n = ::read(open->get(), piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::Io, text("cannot read ", file.string(), ": ", std::strerror(errno)));
    if (n == 0) break;
    const auto bytes = static_cast<std::size_t>(n);
    hash.add({piece.data(), bytes});
    of.bytes += bytes;
    if (!go_on(bytes)) return fail(ErrorCode::Cancelled, text("interrupted in ", file.string()));
  }
  of.sha256 = hash.hex();
  return of;
}

}  // namespace floatstage::capture
