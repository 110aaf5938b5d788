#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage::calib {

/// One line of a text file, cut at blanks. Views into the reader's text.
struct TextLine {
  int number = 0;  ///< from 1
  std::string_view whole;
  std::vector<std::string_view> words;
};

/// Walks over a text line by line and knows where it is, so that every complaint names file and line. Accepts
/// the line ends of every system. Borrows `text`, which must outlive it.
class TextLines {
 public:
  TextLines(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  /// The next line, blank or not; nothing at the end.
  std::optional<TextLine> next();
  /// The next line with a word in it; lines that begin with `comment` are passed over (0: there are no
  /// comments).
  std::optional<TextLine> next_filled(char comment = 0);

  /// "<name>: line <n>: <what>", n being the line read last.
  Unexpected bad(const std::string& what) const;
  /// "<name>: ends after line <n>, but <what> should follow; the file is cut off".
  Unexpected cut_off(const std::string& what) const;

 private:
  std::string_view text_;
  std::string name_;
  std::size_t position_ = 0;
  int line_ = 0;
};

/// A finite decimal number that is the whole word; independent of the locale. NaN and infinities are refused.
std::optional<double> parse_number(std::string_view word);
std::optional<long> parse_integer(std::string_view word);

/// `count` numbers of `line` from word `first` on; the error says which word is wrong and that it belongs to
/// `what`.
Result<std::vector<double>> numbers(const TextLines& lines, const TextLine& line, std::size_t first,
                                    std::size_t count, const std::string& what);

/// Shortest decimal that reads back as the same double.
std::string to_text(double value);

}  // namespace floatstage::calib
