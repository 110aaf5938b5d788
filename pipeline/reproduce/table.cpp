#include "pipeline/reproduce/table.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

std::string shown(double value, const char* unknown) {
  if (!std::isfinite(value)) return unknown;
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3f", value);
  return digits;
}

// A line of all cells, each followed by `between` but the last.
template <class Word, class Number>
std::string line(const std::vector<Word>& words, const std::vector<Number>& numbers, const char* before,
                 const char* between, const char* after) {
  std::string out = before;
  const char* next = "";
  for (const Word& word : words) out += next + std::string(word), next = between;
  for (const Number& number : numbers) out += next + std::string(number), next = between;
  return out + after + "\n";
}

std::vector<std::string> shown(const std::vector<double>& numbers, const char* unknown) {
  std::vector<std::string> out;
  for (const double n : numbers) out.push_back(shown(n, unknown));
  return out;
}

}  // namespace

nlohmann::json to_json(const Table& table) {
  nlohmann::json j = {{"title", table.title}, {"setup", table.setup}, {"rows", nlohmann::json::array()}};
  for (const Table::Row& row : table.rows) {
    nlohmann::json r;
    for (std::size_t i = 0; i < row.words.size(); ++i) r[table.words[i]] = row.words[i];
    for (std::size_t i = 0; i < row.numbers.size(); ++i)
      r[table.numbers[i]] = std::isfinite(row.numbers[i]) ? nlohmann::json(row.numbers[i]) : nlohmann::json();
    j["rows"].push_back(std::move(r));
  }
  return j;
}

std::string to_csv(const Table& table) {
  std::string csv = line(table.words, table.numbers, "", ",", "");
  for (const Table::Row& row : table.rows) csv += line(row.words, shown(row.numbers, ""), "", ",", "");
  return csv;
}

std::string to_markdown(const Table& table) {
  const std::vector<std::string> rules(table.words.size(), "---"), right(table.numbers.size(), "---:");
  std::string md = text("## ", table.title, "\n\n", table.setup, "\n\n") +
                   line(table.words, table.numbers, "| ", " | ", " |") +
                   line(rules, right, "| ", " | ", " |");
  for (const Table::Row& row : table.rows) md += line(row.words, shown(row.numbers, "–"), "| ", " | ", " |");
  return md;
}

}  // namespace floatstage::pipeline
