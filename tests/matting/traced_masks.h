#pragma once

#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/file.h"
#include "core/image.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {

/// A mask from polygons that somebody traced: "+" begins one that is added, "-" one that is taken away, "#" a
/// comment; "x,y" in px, the picture's corner at 0,0. A pixel is in where its middle is.
inline Image traced_mask(const std::filesystem::path& file, int width, int height) {
  using Polygon = std::vector<std::pair<double, double>>;
  std::vector<std::pair<std::uint8_t, Polygon>> polygons;
  const Result<std::string> all = read_file(file);
  EXPECT_THAT(all, IsOk());
  std::istringstream lines(all ? *all : "");
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      double x = 0, y = 0;
      if (word == "+" || word == "-")
        polygons.push_back({static_cast<std::uint8_t>(word == "+" ? 255 : 0), {}});
      else if (!polygons.empty() && std::sscanf(word.c_str(), "%lf,%lf", &x, &y) == 2)
        polygons.back().second.push_back({x, y});
      else
        ADD_FAILURE() << file << ": '" << word << "'";
    }
  }
  Image mask(width, height, 1);
  for (const auto& [value, p] : polygons)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        bool in = false;
        for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++)
          if ((p[i].second > y + 0.5) != (p[j].second > y + 0.5) &&
              x + 0.5 < (p[j].first - p[i].first) * (y + 0.5 - p[i].second) / (p[j].second - p[i].second) +
                            p[i].first)
            in = !in;
        if (in) *mask.at(x, y) = value;
      }
  return mask;
}

}  // namespace floatstage::matting
