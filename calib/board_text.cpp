#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "calib/board.h"
#include "calib/marker_dictionary.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr std::string_view kTag = "floatstage-target:";
constexpr std::string_view kSpaces = " \t\r\n";

struct Unit {
  const char* name;
  double multiply, divide;  // one of them is 1: 40.5mm is the double nearest to 0.0405
};
constexpr Unit kUnits[] = {{"mm", 1, 1000}, {"cm", 1, 100}, {"in", 0.0254, 1}, {"m", 1, 1}};

// The words after the kind. The first complaint is kept; reading goes on with zeros.
class Words {
 public:
  explicit Words(std::string_view line) {
    for (std::size_t at = line.find_first_not_of(kSpaces); at != line.npos;
         at = line.find_first_not_of(kSpaces, at)) {
      const std::size_t end = std::min(line.find_first_of(kSpaces, at), line.size());
      const std::string_view word = line.substr(at, end - at);
      if (kind_.empty()) {
        kind_ = word;
      } else {
        const std::size_t equals = word.find('=');
        const std::string key(word.substr(0, equals));
        if (!values_.emplace(key, equals == word.npos ? "" : word.substr(equals + 1)).second)
          complain(text("'", key, "' is there twice"));
      }
      at = end;
    }
  }

  const std::string& kind() const { return kind_; }
  bool has(const char* key) const { return values_.contains(key); }

  std::string word(const char* key) {
    asked_.insert(key);
    const auto found = values_.find(key);
    if (found == values_.end() || found->second.empty()) {
      complain(text("'", key, "=…' is missing"));
      return {};
    }
    return found->second;
  }

  int integer(const char* key, std::optional<int> fallback = {}) {
    asked_.insert(key);
    if (!has(key) && fallback) return *fallback;
    const std::string value = word(key);
    int n = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), n);
    if (error != std::errc() || end != value.data() + value.size())
      complain(text("'", key, "=", value, "' is no whole number"));
    return n;
  }

  double length(const char* key) { return as_length(key, word(key)); }

  std::vector<double> lengths(const char* key) {
    std::vector<double> all;
    const std::string list = word(key);
    for (std::size_t at = 0; at <= list.size();) {
      const std::size_t comma = std::min(list.find(',', at), list.size());
      all.push_back(as_length(key, list.substr(at, comma - at)));
      at = comma + 1;
    }
    return all;
  }

  bool flag(const char* key) {
    asked_.insert(key);
    const auto found = values_.find(key);
    if (found == values_.end()) return false;
    if (!found->second.empty()) complain(text("'", key, "' takes no value"));
    return true;
  }

  std::optional<std::string> problem() {
    for (const auto& [key, value] : values_)
      if (!asked_.contains(key)) complain(text("'", key, "' is not a word of '", kind_, "'"));
    return problem_;
  }

 private:
  void complain(const std::string& what) {
    if (!problem_) problem_ = what;
  }

  double as_length(const char* key, const std::string& value) {
    double n = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), n);
    const std::string_view unit(end, static_cast<std::size_t>(value.data() + value.size() - end));
    if (error == std::errc() && std::isfinite(n))
      for (const Unit& u : kUnits)
        if (unit == u.name) return n * u.multiply / u.divide;
    complain(
        text("'", key, "=", value, "' is no length; write it with its unit, like 30mm, 3cm, 0.03m or 1.2in"));
    return 0;
  }

  std::string kind_;
  std::map<std::string, std::string> values_;
  std::set<std::string> asked_;
  std::optional<std::string> problem_;
};

std::string canonical(const std::string& dictionary) {
  const MarkerDictionary* known = find_dictionary(dictionary);
  return known ? known->name : dictionary;
}

CharucoBoard read_charuco(Words& w) {
  return {.columns = w.integer("columns"),
          .rows = w.integer("rows"),
          .square = w.length("square"),
          .marker = w.length("marker"),
          .dictionary = canonical(w.word("dictionary")),
          .first_marker = w.integer("first", 0),
          .inverted = w.flag("inverted"),
          .white_first = w.flag("white-first")};
}

int markers_of(const CharucoBoard& b) {
  const long long all = static_cast<long long>(b.columns) * b.rows;
  return static_cast<int>(std::clamp(b.white_first ? (all + 1) / 2 : all / 2, 0LL, 1'000'000LL));
}

std::optional<TargetDesign> read_kind(Words& w) {
  if (w.kind() == "chessboard")
    return Chessboard{
        .columns = w.integer("columns"), .rows = w.integer("rows"), .square = w.length("square")};
  if (w.kind() == "charuco") return read_charuco(w);
  if (w.kind() == "two-sided") {
    TwoSidedBoard b{.front = read_charuco(w), .thickness = w.length("thickness")};
    b.back_first_marker =
        w.integer("back-first", std::min(b.front.first_marker, 1'000'000) + markers_of(b.front));
    return b;
  }
  if (w.kind() == "apriltags")
    return AprilTagGrid{
        .columns = w.integer("columns"),
        .rows = w.integer("rows"),
        .tag = w.length("tag"),
        .gap = w.length("gap"),
        .dictionary = w.has("dictionary") ? canonical(w.word("dictionary")) : "apriltag_36h11",
        .first_tag = w.integer("first", 0),
        .border = w.integer("border", 1)};
  if (w.kind() == "wand") {
    Wand wand{.positions = w.lengths("positions")};
    if (w.has("ball")) {
      wand.ball = w.length("ball");
    } else {
      wand.tag = w.length("tag");
      wand.dictionary = canonical(w.word("dictionary"));
      wand.first_tag = w.integer("first", 0);
    }
    return wand;
  }
  return std::nullopt;
}

// Without an exponent, as short as it can be.
std::string plain_number(double value) {
  char digits[400];
  return {digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed).ptr};
}

// The shortest number of millimetres, or of metres where none will do, that is read back as the same double.
std::string millimetres(double metres) {
  for (const double per_metre : {1000.0, 1.0}) {
    for (int digits = 1; digits <= 17; ++digits) {
      char number[40];
      const auto end = std::to_chars(number, number + sizeof number, metres * per_metre,
                                     std::chars_format::general, digits)
                           .ptr;
      double back = 0;
      std::from_chars(number, end, back);
      if (back / per_metre == metres) return text(plain_number(back), per_metre > 1 ? "mm" : "m");
    }
  }
  return "0mm";
}

std::string charuco_words(const CharucoBoard& b) {
  return text(" columns=", b.columns, " rows=", b.rows, " square=", millimetres(b.square),
              " marker=", millimetres(b.marker), " dictionary=", b.dictionary,
              b.first_marker != 0 ? text(" first=", b.first_marker) : "", b.inverted ? " inverted" : "",
              b.white_first ? " white-first" : "");
}

std::string words_of(const Chessboard& b) {
  return text("chessboard columns=", b.columns, " rows=", b.rows, " square=", millimetres(b.square));
}
std::string words_of(const CharucoBoard& b) { return "charuco" + charuco_words(b); }
std::string words_of(const TwoSidedBoard& b) {
  return text("two-sided", charuco_words(b.front), " thickness=", millimetres(b.thickness),
              " back-first=", b.back_first_marker);
}
std::string words_of(const AprilTagGrid& g) {
  return text("apriltags columns=", g.columns, " rows=", g.rows, " tag=", millimetres(g.tag),
              " gap=", millimetres(g.gap), " dictionary=", g.dictionary,
              g.first_tag != 0 ? text(" first=", g.first_tag) : "",
              g.border != 1 ? text(" border=", g.border) : "");
}
std::string words_of(const Wand& w) {
  std::string positions;
  for (const double x : w.positions) positions += (positions.empty() ? "" : ",") + millimetres(x);
  if (w.ball > 0) return text("wand positions=", positions, " ball=", millimetres(w.ball));
  return text("wand positions=", positions, " tag=", millimetres(w.tag), " dictionary=", w.dictionary,
              w.first_tag != 0 ? text(" first=", w.first_tag) : "");
}

}  // namespace

Result<TargetDesign> parse_target(std::string_view line) {
  Words words(line);
  const std::optional<TargetDesign> target = read_kind(words);
  if (!target)
    return fail(ErrorCode::BadData,
                text("target '", line.substr(0, 80), "': begins with '", words.kind().substr(0, 40),
                     "'; known: chessboard, charuco, apriltags, two-sided, wand"));
  if (const std::optional<std::string> problem = words.problem())
    return fail(ErrorCode::BadData, text("target '", line.substr(0, 200), "': ", *problem));
  if (const Result<void> sound = check(*target); !sound)
    return fail(ErrorCode::BadData, text("target '", line.substr(0, 200), "': ", sound.error().message));
  return *target;
}

std::string to_text(const TargetDesign& target) {
  return std::visit([](const auto& t) { return words_of(t); }, target);
}

Result<TargetDesign> load_target(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  const std::size_t at = bytes->find(kTag);
  if (at == std::string::npos)
    return fail(ErrorCode::BadData, text(file.string(), ": holds no line '", kTag,
                                         " …'; give a print made by 'floatstage calibrate target'"));
  const std::size_t begin = at + kTag.size();
  const std::size_t end = std::min(bytes->find_first_of("\n\r<)", begin), bytes->size());
  Result<TargetDesign> target = parse_target(std::string_view(*bytes).substr(begin, end - begin));
  if (!target) return fail(target.error().code, text(file.string(), ": ", target.error().message));
  return target;
}

}  // namespace floatstage::calib
