#include "calib/formats/opencv_yaml.h"

#include "calib/formats/text_lines.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr std::string_view kBlank = " \t";

std::string_view trimmed(std::string_view s) {
  const std::size_t first = s.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlank) - first + 1);
}

std::string unquoted(std::string_view s) {
  if (s.size() >= 2 && (s.front() == '"' || s.front() == '\'') && s.back() == s.front())
    s = s.substr(1, s.size() - 2);
  return std::string(s);
}

bool is_indented(const TextLine& line) { return kBlank.find(line.whole.front()) != std::string_view::npos; }

}  // namespace

/// Goes once over the lines; a line that no entry takes is an error, so it always ends.
class OpenCvYamlParser {
 public:
  OpenCvYamlParser(std::string_view text, std::string_view name) : lines_(text, name) {}

  Result<std::map<std::string, OpenCvYaml::Entry>> parse() {
    advance();
    if (!line_ || !line_->whole.starts_with("%YAML"))
      return lines_.bad("does not begin with %YAML; it should be written by OpenCV's FileStorage");
    advance();
    if (line_ && trimmed(line_->whole) == "---") advance();
    while (line_ && trimmed(line_->whole) != "...")
      if (Result<void> ok = parse_entry(); !ok) return forward(ok);
    return std::move(entries_);
  }

 private:
  void advance() { line_ = lines_.next_filled('#'); }

  // Cuts the current line at its colon.
  Result<std::pair<std::string, std::string_view>> key_and_value() {
    const std::size_t colon = line_->whole.find(':');
    if (colon == std::string_view::npos) return lines_.bad("'key: value' should stand here");
    return std::pair(unquoted(trimmed(line_->whole.substr(0, colon))),
                     trimmed(line_->whole.substr(colon + 1)));
  }

  Result<void> parse_entry() {
    if (is_indented(*line_)) return lines_.bad("this belongs to no entry; the file may be damaged");
    const auto pair = key_and_value();
    if (!pair) return forward(pair);
    const auto& [key, value] = *pair;
    OpenCvYaml::Entry entry;
    entry.line = line_->number;
    Result<void> ok;
    if (value.empty()) {
      ok = parse_dashes(entry);
    } else if (value.front() == '[') {
      entry.is_list = true;
      ok = parse_brackets(value, entry.items);
    } else if (value == "!!opencv-matrix") {
      ok = parse_matrix(entry);
    } else if (value.front() == '!') {
      return lines_.bad(text(key, " is of a kind that is not supported: ", value.substr(0, 40)));
    } else {
      entry.scalar = unquoted(value);
      advance();
    }
    if (!ok) return ok;
    if (!entries_.emplace(key, std::move(entry)).second)
      return lines_.bad(text(key, " is here a second time"));
    return {};
  }

  Result<void> parse_dashes(OpenCvYaml::Entry& entry) {
    entry.is_list = true;
    advance();
    while (line_ && line_->words[0] == "-") {
      const std::string_view rest = trimmed(line_->whole);
      entry.items.push_back(unquoted(trimmed(rest.substr(1))));
      advance();
    }
    return {};
  }

  // [ a, b,\n c ], which may go over several lines. Leaves the line after it current.
  Result<void> parse_brackets(std::string_view value, std::vector<std::string>& items) {
    value.remove_prefix(1);
    for (;;) {
      const std::size_t end = value.find(']');
      std::string_view part = trimmed(value.substr(0, end));
      while (!part.empty()) {
        const std::size_t comma = part.find(',');
        items.push_back(unquoted(trimmed(part.substr(0, comma))));
        part = comma == std::string_view::npos ? std::string_view{} : trimmed(part.substr(comma + 1));
      }
      if (end != std::string_view::npos) {
        if (!trimmed(value.substr(end + 1)).empty()) return lines_.bad("something stands behind ']'");
        advance();
        return {};
      }
      advance();
      if (!line_) return lines_.cut_off("']'");
      value = trimmed(line_->whole);
    }
  }

  Result<void> parse_matrix(OpenCvYaml::Entry& entry) {
    entry.is_matrix = true;
    bool has_data = false;
    advance();
    while (line_ && is_indented(*line_)) {
      const auto pair = key_and_value();
      if (!pair) return forward(pair);
      const auto& [key, value] = *pair;
      if (key == "data") {
        if (has_data || value.empty() || value.front() != '[')
          return lines_.bad("data should be one list in [ ]");
        has_data = true;
        if (Result<void> ok = parse_brackets(value, entry.items); !ok) return ok;
      } else {
        entry.of_matrix[key] = unquoted(value);
        advance();
      }
    }
    return {};
  }

  TextLines lines_;
  std::optional<TextLine> line_;
  std::map<std::string, OpenCvYaml::Entry> entries_;
};

Result<OpenCvYaml> OpenCvYaml::parse(std::string_view content, std::string_view name) {
  auto entries = OpenCvYamlParser(content, name).parse();
  if (!entries) return forward(entries);
  OpenCvYaml yaml;
  yaml.name_ = name;
  yaml.entries_ = std::move(*entries);
  return yaml;
}

Unexpected OpenCvYaml::bad(const std::string& key, const std::string& what) const {
  const auto entry = entries_.find(key);
  const std::string place = entry == entries_.end() ? name_ : text(name_, ": line ", entry->second.line);
  return fail(ErrorCode::BadData, text(place, ": ", key, " ", what));
}

Result<std::vector<double>> OpenCvYaml::data(const std::string& key, long& rows, long& cols) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return bad(key, "is missing");
  if (!entry->second.is_matrix) return bad(key, "is not a matrix");
  const auto whole = [&](const char* of) {
    const auto found = entry->second.of_matrix.find(of);
    return found == entry->second.of_matrix.end() ? std::nullopt : parse_integer(found->second);
  };
  const std::optional<long> r = whole("rows"), c = whole("cols");
  const std::vector<std::string>& items = entry->second.items;
  constexpr long kMost = 1000;  // a side: no calibration has more, and the product cannot overflow
  if (!r || !c || *r < 1 || *c < 1 || *r > kMost || *c > kMost || *r * *c != static_cast<long>(items.size()))
    return bad(key, text("holds ", items.size(), " numbers, which are not its rows times its cols"));
  std::vector<double> values;
  for (const std::string& item : items) {
    const std::optional<double> value = parse_number(item);
    if (!value) return bad(key, text("holds '", item.substr(0, 40), "', which is not a finite number"));
    values.push_back(*value);
  }
  rows = *r;
  cols = *c;
  return values;
}

Result<std::vector<double>> OpenCvYaml::matrix(const std::string& key, int rows, int cols) const {
  long r = 0, c = 0;
  Result<std::vector<double>> values = data(key, r, c);
  if (values && (r != rows || c != cols))
    return bad(key, text("should be ", rows, "×", cols, " numbers, but is ", r, "×", c));
  return values;
}

Result<std::vector<double>> OpenCvYaml::vector(const std::string& key) const {
  long r = 0, c = 0;
  Result<std::vector<double>> values = data(key, r, c);
  if (values && r != 1 && c != 1) return bad(key, text("should be one row or column, but is ", r, "×", c));
  return values;
}

Result<double> OpenCvYaml::number(const std::string& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return bad(key, "is missing");
  const std::optional<double> value = parse_number(entry->second.scalar);
  if (!value) return bad(key, "is not a finite number");
  return *value;
}

Result<std::vector<std::string>> OpenCvYaml::list(const std::string& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end() || !entry->second.is_list || entry->second.items.empty())
    return bad(key, "is missing or is not a list of names");
  return entry->second.items;
}

}  // namespace floatstage::calib
