#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage::calib {

/// The part of YAML that OpenCV's FileStorage writes: after %YAML, top-level keys with a scalar, a list ("-
/// a" lines or [ a, b ]) or an !!opencv-matrix of one channel. Anything else is BadData with its line.
class OpenCvYaml {
 public:
  static Result<OpenCvYaml> parse(std::string_view text, std::string_view name);

  bool has(const std::string& key) const { return entries_.contains(key); }
  /// A matrix of exactly `rows`×`cols`, row by row. All of these say which entry is missing or wrong, and its
  /// line.
  Result<std::vector<double>> matrix(const std::string& key, int rows, int cols) const;
  /// A matrix of one row or one column.
  Result<std::vector<double>> vector(const std::string& key) const;
  Result<double> number(const std::string& key) const;
  /// A list of strings, at least one; without their quotes.
  Result<std::vector<std::string>> list(const std::string& key) const;

  /// "<name>: line <n>: <key> <what>".
  Unexpected bad(const std::string& key, const std::string& what) const;

 private:
  struct Entry {
    int line = 0;
    std::string scalar;
    std::vector<std::string> items;                // of a list, or a matrix' data
    std::map<std::string, std::string> of_matrix;  // rows, cols, dt
    bool is_list = false, is_matrix = false;
  };
  friend class OpenCvYamlParser;

  Result<std::vector<double>> data(const std::string& key, long& rows, long& cols) const;

  std::string name_;
  std::map<std::string, Entry> entries_;
};

}  // namespace floatstage::calib
