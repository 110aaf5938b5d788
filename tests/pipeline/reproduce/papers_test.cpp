// What experiments are written down as: tables, sheets, charts.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/reproduce/chart.h"
#include "pipeline/reproduce/sheet.h"
#include "pipeline/reproduce/table.h"

namespace floatstage::pipeline {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Table small_table() {
  return {"A title",
          "Set up so.",
          {"method"},
          {"psnr", "at"},
          {{{"linear"}, {24.5, kNaN}}, {{"floating"}, {26.9, 50}}}};
}

TEST(ExperimentTable, SaysTheSameInEveryFile) {
  EXPECT_EQ(to_csv(small_table()), "method,psnr,at\nlinear,24.500,\nfloating,26.900,50.000\n");
  EXPECT_EQ(
      to_markdown(small_table()),
      "## A title\n\nSet up so.\n\n| method | psnr | at |\n| --- | ---: | ---: |\n| linear | 24.500 | – |\n"
      "| floating | 26.900 | 50.000 |\n");
  const nlohmann::json j = to_json(small_table());
  EXPECT_EQ(j.at("rows").at(1).at("method"), "floating");
  EXPECT_EQ(j.at("rows").at(1).at("psnr"), 26.9);
  EXPECT_TRUE(j.at("rows").at(0).at("at").is_null());
}

TEST(ExperimentChart, HasALineAMethodAndAGapWhereNothingIsKnown) {
  const std::string svg = to_svg(
      {"T < U", "px", "dB", {"0", "1", "2"}, {{"linear", {20, kNaN, 22}}, {"floating", {25, 24, 23}}}});
  EXPECT_THAT(svg, HasSubstr("T &lt; U"));
  EXPECT_THAT(svg, HasSubstr(">floating</text>"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  std::size_t dots = 0, moves = 0;
  for (std::size_t at = 0; (at = svg.find("<circle", at)) != std::string::npos; ++at) ++dots;
  for (std::size_t at = 0; (at = svg.find("fill=\"none\"", at)) != std::string::npos; ++at) ++moves;
  EXPECT_EQ(dots, 5u);
  EXPECT_EQ(moves, 2u);
}

TEST(ExperimentChart, OfOneValueOrNoneIsDrawnToo) {
  EXPECT_THAT(to_svg({"t", "x", "y", {"1"}, {{"linear", {20}}}}), Not(HasSubstr("nan")));
  EXPECT_THAT(to_svg({"t", "x", "y", {}, {{"linear", {}}}}), Not(HasSubstr("inf")));
}

TEST(ExperimentSheet, PutsRowsBelowOneAnotherAndNamesIntoThem) {
  const Image white(60, 50, 3, 255), black(40, 30, 3, 0);
  const Image sheet = sheet_of({{{"a", white}, {"b", black}}, {{"c", black}}});
  EXPECT_EQ(sheet.width, 60 + 4 + 40);
  EXPECT_EQ(sheet.height, 50 + 4 + 30);
  EXPECT_EQ(*sheet.at(59, 49), 255);
  EXPECT_EQ(*sheet.at(64, 29), 0);
  EXPECT_EQ(*sheet.at(64, 49), 40) << "below the smaller one";
  EXPECT_NE(*sheet.at(1, 1), 255) << "the label's strip";
  EXPECT_TRUE(sheet_of({}).empty());
}

TEST(ExperimentSheet, LooksCloselyWhereAPictureIsWrong) {
  Image truth(200, 120, 3, 100), picture = truth;
  for (int y = 60; y < 90; ++y)
    for (int x = 130; x < 160; ++x) picture.at(x, y)[1] = 220;
  const PictureWindow window = worst_window(picture, truth, Image(200, 120, 1, 255), 48);
  EXPECT_LE(window.x, 130);
  EXPECT_GE(window.x + window.width, 160);
  EXPECT_LE(window.y, 60);
  EXPECT_GE(window.y + window.height, 90);
  EXPECT_EQ(cut(picture, window, 3).width, 144);
  EXPECT_EQ(window_about(Image(30, 20, 1)).width, 30) << "an empty mask is about all";
  EXPECT_EQ(worst_window(Image(30, 20, 3), Image(30, 20, 3), Image(30, 20, 1), 48).width, 20);
}

}  // namespace
}  // namespace floatstage::pipeline
