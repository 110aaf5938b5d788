#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "studio/page/page_request.h"
#include "studio/page/page_settings.h"

namespace floatstage::studio {

/// The token that opens a node's page: the first line of the file, or a new random one of 128 bits. NotFound
/// or Io for the file; InvalidArgument for one that others can read, and for a token of fewer than 16 or
/// other than letters, digits, '-' and '_'.
Result<std::string> page_token(const std::filesystem::path& file);

/// Who may use a node's page: whoever knows its token (as `Authorization: Bearer`, or as `?token=`, which a
/// browser exchanges for a session's cookie), at a name that is the studio's own, and from no other site.
/// A session is a time at which it ends and an HMAC-SHA256 of it under the token (RFC 2104): the cookie does
/// not tell the token, and outlives a restart of a node whose token is in a file. Safe from any thread.
class PageAccess {
 public:
  using Clock = std::chrono::system_clock;
  static constexpr std::chrono::hours kSession = std::chrono::hours(7 * 24);

  /// `port` names the cookie: cookies do not know ports, and two nodes of one machine need two.
  PageAccess(std::string token, int port, std::vector<std::string> names);

  enum class Verdict {
    Welcome,
    Stranger,   ///< no token, a wrong one, or a session that has ended
    OtherSite,  ///< another site's page asks in its reader's name (Origin)
    OtherName,  ///< a name that somebody else may have pointed here (Host; DNS rebinding)
  };
  Verdict judge(const PageRequest& request, Clock::time_point now = Clock::now()) const;
  /// The value of Set-Cookie for one who knows the token.
  std::string new_session(Clock::time_point now = Clock::now()) const;

 private:
  bool is_ours(std::string_view host) const;
  bool knows_token(const PageRequest& request, Clock::time_point now) const;
  bool is_session(std::string_view cookie, Clock::time_point now) const;
  std::string signature(std::string_view ends) const;

  const std::string token_, cookie_;
  std::vector<std::string> names_;
};

}  // namespace floatstage::studio
