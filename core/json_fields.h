#pragma once

// Reads JSON strictly. Not a public header, since it names nlohmann-json: for the .cpp files of core, of
// stages that have files of their own, and of the floors. Whatever is read from a file or a peer is parsed
// here.

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/result.h"

namespace floatstage {

/// The first thing that was wrong while a document was read. Reading goes on with defaults after it, so that
/// readers need to ask only once, at the end.
struct JsonProblem {
  std::optional<std::string> first;
  void note(const std::string& where, const std::string& what);
};

/// Nothing of ours nests deeper: a document asks the machine's stack for every level.
constexpr int kDeepestJson = 16;
/// The largest documents are records of long takes: 100 bytes a camera and frame.
constexpr std::size_t kLargestJson = std::size_t{1} << 28;

/// Parses a document; BadData with its name and the byte where it stops making sense, or because it is deeper
/// than kDeepestJson or longer than `most`.
Result<nlohmann::json> parse_json(std::string_view text, std::string_view name_for_errors,
                                  std::size_t most = kLargestJson);

/// The text of a document, indented, with invalid UTF-8 replaced instead of refused.
std::string print_json(const nlohmann::ordered_json& document);

/// One JSON object whose keys must all be known: a misspelt optional key is an error, not a silent default.
/// `where` begins every complaint: "rig.json: camera 'left'". The value must outlive the reader.
class JsonFields {
 public:
  JsonFields(const nlohmann::json& value, std::string where, JsonProblem& problem);

  double number(const char* key, std::optional<double> fallback = std::nullopt);
  int integer(const char* key);  ///< in the range of int
  bool boolean(const char* key);
  std::string string(const char* key);
  /// Exactly `count` numbers, row by row where they are nested in lists of lists. Zeros after a complaint.
  std::vector<double> numbers(const char* key, std::size_t count);
  /// The value itself, or null when it is absent and `required` is false.
  const nlohmann::json* child(const char* key, bool required = true);
  const nlohmann::json* list(const char* key);
  bool has(const char* key) const { return value_ && value_->contains(key); }

  /// Complains about keys that nobody asked for. Call it last.
  void refuse_others();

  const std::string& where() const { return where_; }

 private:
  void complain(const std::string& what) { problem_.note(where_, what); }
  const nlohmann::json* value_ = nullptr;  // null when it was no object
  std::string where_;
  JsonProblem& problem_;
  std::set<std::string> asked_;
};

}  // namespace floatstage
