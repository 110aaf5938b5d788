#include "pipeline/reproduce/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr double kWidth = 640, kHeight = 400, kLeft = 64, kRight = 150, kTop = 40, kBottom = 56;  // px
// Told apart with and without colour vision (Okabe and Ito).
constexpr std::array<const char*, 7> kColors = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                "#e69f00", "#56b4e9", "#000000"};

std::string escaped(const std::string& words) {
  std::string out;
  for (const char c : words) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}

std::string words_at(double x, double y, const std::string& words, const char* more = "") {
  return text("<text x=\"", x, "\" y=\"", y, "\" ", more, ">", escaped(words), "</text>\n");
}

// A step of 1, 2 or 5 times a power of ten that cuts the range into four to nine pieces.
double nice_step(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 4)));
  for (const double times : {5.0, 2.0})
    if (range / (times * power) >= 4) return times * power;
  return power;
}

}  // namespace

std::string to_svg(const Chart& chart) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Chart::Line& line : chart.lines)
    for (const double v : line.values)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (!(low <= high)) low = 0, high = 1;
  if (high - low < 1e-6) low -= 0.5, high += 0.5;
  const double step = nice_step(high - low);
  low = std::floor(low / step) * step, high = std::ceil(high / step) * step;
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  const auto places = static_cast<double>(std::max<std::size_t>(chart.places.size(), 2) - 1);
  auto x_of = [&](std::size_t i) {
    return std::round(10 * (kLeft + (right - kLeft) * static_cast<double>(i) / places)) / 10;
  };
  auto y_of = [&](double v) {
    return std::round(10 * (bottom - (bottom - kTop) * (v - low) / (high - low))) / 10;
  };
  std::string svg = text("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ", kWidth, " ", kHeight,
                         "\" font-family=\"sans-serif\" font-size=\"12\">\n",
                         "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n");
  svg += words_at(kLeft, 22, chart.title, "font-size=\"14\"");
  for (double v = low; v <= high + step / 2; v += step) {
    const double shown = std::round(v / step) * step;
    svg += text("<path d=\"M", kLeft, " ", y_of(v), "H", right, "\" stroke=\"#ddd\"/>\n");
    svg +=
        words_at(kLeft - 8, y_of(v) + 4, text(std::abs(shown) < step / 2 ? 0 : shown), "text-anchor=\"end\"");
  }
  for (std::size_t i = 0; i < chart.places.size(); ++i)
    svg += words_at(x_of(i), bottom + 18, chart.places[i], "text-anchor=\"middle\"");
  svg += words_at((kLeft + right) / 2, kHeight - 14, chart.x_name, "text-anchor=\"middle\"");
  svg +=
      words_at(16, (kTop + bottom) / 2, chart.y_name,
               text("text-anchor=\"middle\" transform=\"rotate(-90 16 ", (kTop + bottom) / 2, ")\"").c_str());
  for (std::size_t l = 0; l < chart.lines.size(); ++l) {
    const Chart::Line& line = chart.lines[l];
    const char* color = kColors[l % kColors.size()];
    std::string path;
    bool pen_is_down = false;
    for (std::size_t i = 0; i < line.values.size(); ++i) {
      if (!std::isfinite(line.values[i])) {
        pen_is_down = false;
        continue;
      }
      path += text(pen_is_down ? "L" : "M", x_of(i), " ", y_of(line.values[i]));
      pen_is_down = true;
      svg += text("<circle cx=\"", x_of(i), "\" cy=\"", y_of(line.values[i]), "\" r=\"3\" fill=\"", color,
                  "\"/>\n");
    }
    svg += text("<path d=\"", path, "\" fill=\"none\" stroke-width=\"2\" stroke=\"", color, "\"/>\n");
    const double y = kTop + 8 + 18 * static_cast<double>(l);
    svg += text("<path d=\"M", right + 12, " ", y, "h18\" stroke-width=\"2\" stroke=\"", color, "\"/>\n");
    svg += words_at(right + 36, y + 4, line.name);
  }
  return svg + "</svg>\n";
}

}  // namespace floatstage::pipeline
