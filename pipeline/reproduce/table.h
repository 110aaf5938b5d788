#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace floatstage::pipeline {

/// What an experiment found: rows of words and numbers, the same in all files that it is written to.
struct Table {
  struct Row {
    std::vector<std::string> words;
    std::vector<double> numbers;  ///< NaN: nothing to say here
  };
  std::string title, setup;                 ///< one sentence each
  std::vector<std::string> words, numbers;  ///< the columns' names
  std::vector<Row> rows;
};

/// {title, setup, rows: [{<column>: …}]}.
nlohmann::json to_json(const Table& table);
std::string to_csv(const Table& table);
std::string to_markdown(const Table& table);

}  // namespace floatstage::pipeline
