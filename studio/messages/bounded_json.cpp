#include "studio/messages/bounded_json.h"

#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::size_t kLongestJson = 1 << 20;

}  // namespace

Result<nlohmann::json> parse_bounded(std::string_view json, std::string_view name_for_errors) {
  return parse_json(json, name_for_errors, kLongestJson);
}

}  // namespace floatstage::studio::wire
