#include "core/json_fields.h"

#include <cmath>
#include <limits>

#include "core/text.h"

namespace floatstage {
namespace {

bool collect(const nlohmann::json& value, std::vector<double>& out) {
  if (value.is_number()) {
    out.push_back(value.get<double>());
    return true;
  }
  if (!value.is_array()) return false;
  for (const nlohmann::json& row : value) {
    if (!row.is_array()) {
      if (!collect(row, out)) return false;
      continue;
    }
    for (const nlohmann::json& item : row)
      if (!item.is_number() || !collect(item, out)) return false;  // two levels: a matrix, nothing deeper
  }
  return true;
}

// The parser needs no stack for depth, but copying a document and taking it apart do.
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

void JsonProblem::note(const std::string& where, const std::string& what) {
  if (!first) first = where + ": " + what;
}

Result<nlohmann::json> parse_json(std::string_view bytes, std::string_view name, std::size_t most) {
  if (bytes.size() > most)
    return fail(ErrorCode::BadData, text(name, ": ", bytes.size(), " bytes, more than any of ours"));
  if (is_deep(bytes))
    return fail(ErrorCode::BadData,
                text(name, ": nested deeper than ", kDeepestJson, " lists; this was not written by us"));
  try {
    return nlohmann::json::parse(bytes.begin(), bytes.end());
  } catch (const nlohmann::json::parse_error& e) {
    return fail(ErrorCode::BadData,
                text(name, ": not JSON at byte ", e.byte, "; the file is cut off or was edited by mistake"));
  } catch (const nlohmann::json::exception& e) {  // a number too large for a double
    return fail(ErrorCode::BadData, text(name, ": not usable as JSON (", e.what(), ")"));
  }
}

std::string print_json(const nlohmann::ordered_json& document) {
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

JsonFields::JsonFields(const nlohmann::json& value, std::string where, JsonProblem& problem)
    : where_(std::move(where)), problem_(problem) {
  if (value.is_object())
    value_ = &value;
  else
    complain("expected an object {…}");
}

const nlohmann::json* JsonFields::child(const char* key, bool required) {
  asked_.insert(key);
  if (!value_) return nullptr;
  const auto found = value_->find(key);
  if (found != value_->end()) return &*found;
  if (required) complain(text("'", key, "' is missing"));
  return nullptr;
}

double JsonFields::number(const char* key, std::optional<double> fallback) {
  const nlohmann::json* v = child(key, !fallback);
  if (!v) return fallback.value_or(0);
  if (!v->is_number()) {
    complain(text("'", key, "' is not a number"));
    return 0;
  }
  return v->get<double>();
}

int JsonFields::integer(const char* key) {
  const nlohmann::json* v = child(key);
  if (!v) return 0;
  const bool fits = v->is_number_integer() &&
                    !(v->is_number_unsigned() && v->get<std::uint64_t>() > std::numeric_limits<int>::max()) &&
                    v->get<std::int64_t>() >= std::numeric_limits<int>::min() &&
                    v->get<std::int64_t>() <= std::numeric_limits<int>::max();
  if (!fits) {
    complain(text("'", key, "' is not a whole number of usual size"));
    return 0;
  }
  return v->get<int>();
}

bool JsonFields::boolean(const char* key) {
  const nlohmann::json* v = child(key);
  if (v && !v->is_boolean()) complain(text("'", key, "' is neither true nor false"));
  return v && v->is_boolean() && v->get<bool>();
}

std::string JsonFields::string(const char* key) {
  const nlohmann::json* v = child(key);
  if (v && !v->is_string()) complain(text("'", key, "' is not a string"));
  return v && v->is_string() ? v->get<std::string>() : std::string();
}

std::vector<double> JsonFields::numbers(const char* key, std::size_t count) {
  const nlohmann::json* v = child(key);
  std::vector<double> out;
  if (v && (!collect(*v, out) || out.size() != count))
    complain(text("'", key, "' is not a list of ", count, " numbers"));
  out.resize(count, 0.0);
  return out;
}

const nlohmann::json* JsonFields::list(const char* key) {
  const nlohmann::json* v = child(key);
  if (v && !v->is_array()) {
    complain(text("'", key, "' is not a list [...]"));
    return nullptr;
  }
  return v;
}

void JsonFields::refuse_others() {
  if (!value_) return;
  for (const auto& [key, unused] : value_->items())
    if (!asked_.contains(key)) complain(text("unknown key '", key, "'; is it misspelt?"));
}

}  // namespace floatstage
