#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/generality/methods.h"

namespace floatstage::generality {

/// A cell as the table shows it. "0.97 / 0.95": mean and worst IoU. "says so": no matte, and a sentence why.
/// A "said" after figures: there are mattes, and a sentence that doubts them or says which are missing.
struct Cell {
  bool has_mattes = false, said = false;
  double mean = 0, worst = 0;
};

Cell cell_of(const Outcome& outcome);
std::string text_of(const Cell& cell);

/// Rows by name, cells by column.
using ScoreTable = std::map<std::string, std::map<std::string, Cell>>;

/// Reads a table of docs/: the first line with bars names the columns, "said" is read from the cells. Rows
/// that do not parse are left out.
ScoreTable read_table(const std::string& markdown);

}  // namespace floatstage::generality
