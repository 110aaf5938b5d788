#include "studio/page/page_request.h"

#include <cctype>

namespace floatstage::studio {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

std::string decoded(std::string_view text, bool plus_is_space) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size();
    const int high = escape ? hex_digit(text[i + 1]) : -1, low = escape ? hex_digit(text[i + 2]) : -1;
    if (high >= 0 && low >= 0) {
      plain += static_cast<char>(16 * high + low);
      i += 2;
    } else {
      plain += plus_is_space && text[i] == '+' ? ' ' : text[i];
    }
  }
  return plain;
}

/// Takes what stands before the next `mark` off the front of `text`.
std::string_view next_part(std::string_view& text, char mark) {
  const std::size_t end = text.find(mark);
  const std::string_view part = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  return part;
}

}  // namespace

void read_target(std::string_view target, PageRequest& request) {
  target = target.substr(0, target.find('#'));
  request.path = decoded(next_part(target, '?'), false);
  while (!target.empty()) {
    std::string_view pair = next_part(target, '&');
    const std::string name = decoded(next_part(pair, '='), true);
    if (!name.empty()) request.query.emplace(name, decoded(pair, true));
  }
}

std::string PageRequest::query_value(const std::string& name) const {
  const auto found = query.find(name);
  return found == query.end() ? "" : found->second;
}

std::string PageRequest::cookie(std::string_view name) const {
  std::string_view rest = cookies;
  while (!rest.empty()) {
    std::string_view pair = next_part(rest, ';');
    while (!pair.empty() && pair.front() == ' ') pair.remove_prefix(1);
    if (next_part(pair, '=') == name) return std::string(pair);
  }
  return "";
}

}  // namespace floatstage::studio
