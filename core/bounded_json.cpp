#include "core/bounded_json.h"

#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr int kDeepestJson = 16;

// A document asks the machine's stack for every level when it is copied or taken apart.
bool is_deep(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted && c == '\\')
      ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '[' || c == '{') && ++depth > kDeepestJson)
      return true;
    else if (!quoted && (c == ']' || c == '}'))
      --depth;
  }
  return false;
}

}  // namespace

Result<nlohmann::json> parse_bounded(std::string_view json, std::string_view name_for_errors,
                                     std::size_t longest) {
  if (json.size() > longest || is_deep(json))
    return fail(ErrorCode::BadData, text(name_for_errors, ": larger or deeper than any of ours"));
  return parse_json(json, name_for_errors);
}

}  // namespace floatstage
