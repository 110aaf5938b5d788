#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "calib/target_sheet.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr double kPointsPerMillimetre = 72 / 25.4;
constexpr const char* kMillimetreMatrix = "2.834645669291339 0 0 -2.834645669291339 0 ";
constexpr int kRulerMillimetres = 50;
constexpr double kTextMillimetres = 2.2;

// Millimetres with a ten-thousandth: 0.1 µm is finer than any printer, and the same text on every machine.
std::string mm(double metres) {
  const double rounded = std::round(metres * 1e7) / 1e4;
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, rounded == 0 ? 0.0 : rounded).ptr;
  return {digits, end};
}

std::string points(double metres) { return mm(metres * kPointsPerMillimetre); }

std::string tagged(const Sheet& sheet) { return text("floatstage-target: ", sheet.caption); }

// What is printed besides the pattern, in millimetres: a ruler at the lower left, the line beside it.
struct Legend {
  double x, y;
  int ruler;
  std::string words;
};

Legend legend(const Sheet& sheet) {
  const int longest = static_cast<int>(sheet.width * 1000) / 2;
  const int ruler = std::clamp(longest / 10 * 10, 10, kRulerMillimetres);
  return {.x = 5,
          .y = sheet.height * 1000 - 5,
          .ruler = ruler,
          .words = text(ruler, " mm  ", sheet.name.empty() ? "" : sheet.name + "  ", sheet.caption)};
}

std::string path(const Ink& ink, char move, char line, bool command_first) {
  std::string d;
  for (const auto& loop : ink.loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const char command = i == 0 ? move : line;
      const std::string xy = mm(loop[i].x()) + " " + mm(loop[i].y());
      d += command_first ? command + xy : xy + " " + command + "\n";
    }
    d += command_first ? "Z" : "h\n";
  }
  return d;
}

// A circle of four cubic curves: nowhere off by more than 0.03 % of the radius.
std::string pdf_circle(const Ink& ink) {
  constexpr double k = 0.5522847498;
  const double x = ink.center.x(), y = ink.center.y(), r = ink.radius;
  std::string d = mm(x + r) + " " + mm(y) + " m\n";
  const double turn[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  for (int i = 0; i < 4; ++i) {
    const double* a = turn[i];
    const double* b = turn[(i + 1) % 4];
    for (const auto& [u, v] : {std::pair{a[0] + k * b[0], a[1] + k * b[1]},
                               std::pair{b[0] + k * a[0], b[1] + k * a[1]}, std::pair{b[0], b[1]}})
      d += mm(x + r * u) + " " + mm(y + r * v) + " ";
    d += "c\n";
  }
  return d + "h\n";
}

std::string page_content(const Sheet& sheet) {
  const double height = sheet.height * 1000 * kPointsPerMillimetre;
  std::string s = text("q\n", kMillimetreMatrix, points(sheet.height), " cm\n");
  for (const Ink& ink : sheet.inks)
    s += (ink.black ? "0 g\n" : "1 g\n") + (ink.radius > 0 ? pdf_circle(ink) : path(ink, 'm', 'l', false)) +
         "f*\n";
  const Legend l = legend(sheet);
  s += text("0 g 0.15 w\n", l.x, " ", l.y, " m ", l.x + l.ruler, " ", l.y, " l S\n");
  for (int i = 0; i <= l.ruler; i += 10)
    s += text(l.x + i, " ", l.y - 1.5, " m ", l.x + i, " ", l.y, " l S\n");
  s += "Q\n";
  const double size = kTextMillimetres * kPointsPerMillimetre;
  s += text("BT /F1 ", size, " Tf ", l.x * kPointsPerMillimetre, " ",
            height - (l.y + 2.5) * kPointsPerMillimetre, " Td (", l.words, ") Tj ET\n");
  return s;
}

}  // namespace

std::string to_svg(const Sheet& sheet) {
  const std::string w = mm(sheet.width), h = mm(sheet.height);
  std::string s =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w +
      "mm\" height=\"" + h + "mm\" viewBox=\"0 0 " + w + " " + h + "\">\n<metadata>" + tagged(sheet) +
      "</metadata>\n<rect width=\"" + w + "\" height=\"" + h + "\" fill=\"white\"/>\n";
  for (const Ink& ink : sheet.inks) {
    const char* fill = ink.black ? "black" : "white";
    if (ink.radius > 0)
      s += "<circle cx=\"" + mm(ink.center.x()) + "\" cy=\"" + mm(ink.center.y()) + "\" r=\"" +
           mm(ink.radius) + "\" fill=\"" + fill + "\"/>\n";
    else
      s += "<path fill-rule=\"evenodd\" fill=\"" + std::string(fill) + "\" d=\"" + path(ink, 'M', 'L', true) +
           "\"/>\n";
  }
  const Legend l = legend(sheet);
  s += text("<path stroke=\"black\" stroke-width=\"0.15\" d=\"M", l.x, " ", l.y, "h", l.ruler);
  for (int i = 0; i <= l.ruler; i += 10) s += text("M", l.x + i, " ", l.y, "v-1.5");
  s += text("\"/>\n<text x=\"", l.x, "\" y=\"", l.y + 2.5, "\" font-family=\"sans-serif\" font-size=\"",
            kTextMillimetres, "\">", l.words, "</text>\n</svg>\n");
  return s;
}

std::string to_pdf(const std::vector<Sheet>& sheets) {
  FLOATSTAGE_CHECK(!sheets.empty(), "no sheets");
  std::vector<std::string> objects;
  std::string kids;
  constexpr int kFirstPage = 5;
  for (std::size_t i = 0; i < sheets.size(); ++i) kids += text(i == 0 ? "" : " ", kFirstPage + 2 * i, " 0 R");
  objects.push_back("<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>");
  objects.push_back(text("<< /Type /Pages /Count ", sheets.size(), " /Kids [", kids, "] >>"));
  objects.push_back("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  objects.push_back("<< /Title (Floatstage calibration target) /Subject (" + tagged(sheets.front()) + ") >>");
  for (const Sheet& sheet : sheets) {
    const std::string content = page_content(sheet);
    objects.push_back(text("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 ", points(sheet.width), " ",
                           points(sheet.height), "] /Resources << /Font << /F1 3 0 R >> >> /Contents ",
                           objects.size() + 2, " 0 R >>"));
    objects.push_back(text("<< /Length ", content.size(), " >>\nstream\n", content, "endstream"));
  }
  std::string pdf = "%PDF-1.4\n", table;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    char line[32];
    std::snprintf(line, sizeof line, "%010zu 00000 n \n", pdf.size());
    table += line;
    pdf += text(i + 1, " 0 obj\n", objects[i], "\nendobj\n");
  }
  const std::size_t at = pdf.size();
  return pdf + text("xref\n0 ", objects.size() + 1, "\n0000000000 65535 f \n", table, "trailer\n<< /Size ",
                    objects.size() + 1, " /Root 1 0 R /Info 4 0 R >>\nstartxref\n", at, "\n%%EOF\n");
}

}  // namespace floatstage::calib
