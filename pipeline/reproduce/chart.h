#pragma once

#include <string>
#include <vector>

namespace floatstage::pipeline {

/// A simple chart of lines. Values on the x axis stand evenly spaced, whatever they are.
struct Chart {
  struct Line {
    std::string name;
    std::vector<double> values;  ///< one a place on the x axis; NaN: a gap
  };
  std::string title, x_name, y_name;
  std::vector<std::string> places;
  std::vector<Line> lines;
};

/// As SVG: readable without scripts, on white.
std::string to_svg(const Chart& chart);

}  // namespace floatstage::pipeline
