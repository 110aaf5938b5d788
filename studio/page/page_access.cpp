#include "studio/page/page_access.h"

#include <algorithm>
#include <charconv>

#include <arpa/inet.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/random.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

constexpr std::size_t kShortestToken = 16;

bool is_token_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

std::string hex(const unsigned char* bytes, std::size_t count) {
  std::string digits;
  for (std::size_t i = 0; i < count; ++i) {
    digits += "0123456789abcdef"[bytes[i] >> 4];
    digits += "0123456789abcdef"[bytes[i] & 15];
  }
  return digits;
}

// Takes the same time wherever they differ.
bool same_secret(std::string_view given, std::string_view wanted) {
  unsigned difference = given.size() == wanted.size() ? 0 : 1;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    difference |=
        static_cast<unsigned char>(wanted[i]) ^ static_cast<unsigned char>(i < given.size() ? given[i] : 0);
  return difference == 0;
}

std::string lower(std::string_view text) {
  std::string small(text);
  std::transform(small.begin(), small.end(), small.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return small;
}

// "studio:8470" → "studio", "[::1]:8470" → "::1".
std::string_view without_port(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    const bool whole = end != std::string_view::npos && (end + 1 == host.size() || host[end + 1] == ':');
    return whole ? host.substr(1, end - 1) : std::string_view();
  }
  return host.substr(0, host.rfind(':'));
}

bool is_address(const std::string& host) {
  unsigned char bytes[sizeof(in6_addr)];
  return ::inet_pton(AF_INET, host.c_str(), bytes) == 1 || ::inet_pton(AF_INET6, host.c_str(), bytes) == 1;
}

std::int64_t unix_seconds(PageAccess::Clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

}  // namespace

Result<std::string> page_token(const std::filesystem::path& file) {
  if (file.empty()) {
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
      return fail(ErrorCode::Io, "the system gives no random numbers for a token");
    return hex(bytes, sizeof bytes);
  }
  const Result<std::string> text_of_file = read_file(file);
  if (!text_of_file) return forward(text_of_file);
  std::error_code error;
  const std::filesystem::perms rights = std::filesystem::status(file, error).permissions();
  if (error || (rights & std::filesystem::perms::others_all) != std::filesystem::perms::none)
    return fail(
        ErrorCode::InvalidArgument,
        text(file.string(), ": others of this machine can read this token, or write one; chmod o-rwx"));
  const std::string token = text_of_file->substr(0, text_of_file->find_first_of("\r\n"));
  if (token.size() < kShortestToken || !std::all_of(token.begin(), token.end(), is_token_letter))
    return fail(ErrorCode::InvalidArgument,
                text(file.string(), ": its first line is no token; use at least ", kShortestToken,
                     " letters, digits, '-' and '_', for example of: openssl rand -hex 16"));
  return token;
}

PageAccess::PageAccess(std::string token, int port, std::vector<std::string> names)
    : token_(std::move(token)), cookie_(text("floatstage_", port)), names_(std::move(names)) {
  for (std::string& name : names_) name = lower(name);
  names_.push_back("localhost");
  char machine[256] = "";
  if (::gethostname(machine, sizeof machine - 1) == 0 && machine[0] != 0) {
    names_.push_back(lower(machine));
    names_.push_back(lower(machine) + ".local");
  }
}

PageAccess::Verdict PageAccess::judge(const PageRequest& request, Clock::time_point now) const {
  if (!is_ours(request.host)) return Verdict::OtherName;
  // Programs send no Origin; browsers send it with every order and every live connection.
  if (!request.origin.empty()) {
    const std::size_t scheme = request.origin.find("://");
    if (scheme == std::string::npos || lower(request.origin.substr(scheme + 3)) != lower(request.host))
      return Verdict::OtherSite;
  }
  return knows_token(request, now) ? Verdict::Welcome : Verdict::Stranger;
}

bool PageAccess::is_ours(std::string_view host) const {
  const std::string name = lower(without_port(host));
  return is_address(name) || std::find(names_.begin(), names_.end(), name) != names_.end();
}

bool PageAccess::knows_token(const PageRequest& request, Clock::time_point now) const {
  constexpr std::string_view kBearer = "Bearer ";
  if (request.authorization.starts_with(kBearer))
    return same_secret(std::string_view(request.authorization).substr(kBearer.size()), token_);
  if (const std::string given = request.query_value("token"); !given.empty())
    return same_secret(given, token_);
  return is_session(request.cookie(cookie_), now);
}

std::string PageAccess::signature(std::string_view ends) const {
  const std::string signed_text = text(cookie_, "=", ends);
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  ::HMAC(EVP_sha256(), token_.data(), static_cast<int>(token_.size()),
         reinterpret_cast<const unsigned char*>(signed_text.data()), signed_text.size(), digest, &size);
  return hex(digest, size);
}

bool PageAccess::is_session(std::string_view cookie, Clock::time_point now) const {
  const std::size_t dash = cookie.find('-');
  if (dash == std::string_view::npos) return false;
  const std::string_view ends = cookie.substr(0, dash);
  if (!same_secret(cookie.substr(dash + 1), signature(ends))) return false;
  std::int64_t seconds = 0;
  std::from_chars(ends.data(), ends.data() + ends.size(), seconds);  // it is ours: it was signed
  return unix_seconds(now) < seconds;
}

std::string PageAccess::new_session(Clock::time_point now) const {
  const std::string ends = std::to_string(unix_seconds(now + kSession));
  return text(cookie_, "=", ends, "-", signature(ends),
              "; Path=/; HttpOnly; SameSite=Strict; Max-Age=", std::chrono::seconds(kSession).count());
}

}  // namespace floatstage::studio
