#include "tests/generality/score_table.h"

#include <cstdio>
#include <sstream>

namespace floatstage::generality {
namespace {

std::vector<std::string> parts_of(const std::string& line) {
  std::vector<std::string> parts;
  std::istringstream in(line);
  for (std::string part; std::getline(in, part, '|');) {
    const std::size_t from = part.find_first_not_of(' '), to = part.find_last_not_of(' ');
    parts.push_back(from == std::string::npos ? "" : part.substr(from, to - from + 1));
  }
  if (!parts.empty()) parts.erase(parts.begin());  // before the first bar
  return parts;
}

}  // namespace

Cell cell_of(const Outcome& o) {
  return {
      .has_mattes = o.made > 0, .said = !o.said.empty(), .mean = o.mean, .worst = o.made > 0 ? o.worst : 0};
}

std::string text_of(const Cell& c) {
  if (!c.has_mattes) return c.said ? "says so" : "nothing";
  char figures[40];
  std::snprintf(figures, sizeof figures, "%.2f / %.2f%s", c.mean, c.worst, c.said ? " said" : "");
  return figures;
}

ScoreTable read_table(const std::string& markdown) {
  ScoreTable table;
  std::vector<std::string> columns;
  std::istringstream in(markdown);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] != '|') {
      columns.clear();
      continue;
    }
    const std::vector<std::string> parts = parts_of(line);
    if (columns.empty()) {
      columns = parts;
      continue;
    }
    for (std::size_t i = 1; i < parts.size() && i < columns.size(); ++i) {
      Cell cell;
      if (std::sscanf(parts[i].c_str(), "%lf / %lf", &cell.mean, &cell.worst) == 2)
        cell.has_mattes = true;
      else if (parts[i] != "says so")
        continue;
      cell.said = !cell.has_mattes || parts[i].find("said") != std::string::npos;
      table[parts[0]][columns[i]] = cell;
    }
  }
  return table;
}

}  // namespace floatstage::generality
