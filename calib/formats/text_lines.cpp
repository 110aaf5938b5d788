#include "calib/formats/text_lines.h"

#include <charconv>
#include <cmath>

#include "core/text.h"

namespace floatstage::calib {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

std::vector<std::string_view> cut_at_blanks(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && is_blank(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !is_blank(line[i])) ++i;
    if (i > begin) words.push_back(line.substr(begin, i - begin));
  }
  return words;
}

// from_chars does not know the leading '+' that some writers put.
std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

constexpr std::size_t kLongestQuote = 40;  // of a bad word in a message

}  // namespace

std::optional<TextLine> TextLines::next() {
  if (position_ >= text_.size()) return std::nullopt;
  const std::size_t end = text_.find_first_of("\r\n", position_);
  TextLine line;
  line.number = ++line_;
  line.whole = text_.substr(position_, end == std::string_view::npos ? end : end - position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
  if (end != std::string_view::npos && text_[end] == '\r' && position_ < text_.size() &&
      text_[position_] == '\n')
    ++position_;
  line.words = cut_at_blanks(line.whole);
  return line;
}

std::optional<TextLine> TextLines::next_filled(char comment) {
  while (std::optional<TextLine> line = next()) {
    if (line->words.empty() || (comment != 0 && line->words[0][0] == comment)) continue;
    return line;
  }
  return std::nullopt;
}

Unexpected TextLines::bad(const std::string& what) const {
  return fail(ErrorCode::BadData, text(name_, ": line ", line_, ": ", what));
}

Unexpected TextLines::cut_off(const std::string& what) const {
  return fail(ErrorCode::BadData, text(name_, ": ends after line ", line_, ", but ", what,
                                       " should follow; the file is cut off"));
}

std::optional<double> parse_number(std::string_view word) {
  word = without_plus(word);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<long> parse_integer(std::string_view word) {
  word = without_plus(word);
  long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

Result<std::vector<double>> numbers(const TextLines& lines, const TextLine& line, std::size_t first,
                                    std::size_t count, const std::string& what) {
  if (line.words.size() < first + count)
    return lines.bad(text(what, " needs ", count, " numbers, but ",
                          line.words.size() > first ? line.words.size() - first : 0, " are here"));
  std::vector<double> values;
  values.reserve(count);
  for (std::size_t i = first; i < first + count; ++i) {
    const std::optional<double> value = parse_number(line.words[i]);
    if (!value)
      return lines.bad(
          text("'", line.words[i].substr(0, kLongestQuote), "' in ", what, " is not a finite number"));
    values.push_back(*value);
  }
  return values;
}

std::string to_text(double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  FLOATSTAGE_CHECK(error == std::errc(), "a double fits 32 characters");
  return std::string(buffer, end);
}

}  // namespace floatstage::calib
