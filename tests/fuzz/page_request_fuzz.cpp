#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "studio/page/page_access.h"

// What a stranger may say to a node's page: Host, Origin, Authorization, Cookie and the target, a line each.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage::studio;
  static const PageAccess access("a-token-that-no-seed-knows", 8470, {"stage.local"});
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  PageRequest request;
  for (std::string* line : {&request.host, &request.origin, &request.authorization, &request.cookies}) {
    const std::size_t end = rest.find('\n');
    *line = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  read_target(rest, request);
  FLOATSTAGE_CHECK(access.judge(request) != PageAccess::Verdict::Welcome, "nobody guesses the token");
  return 0;
}
