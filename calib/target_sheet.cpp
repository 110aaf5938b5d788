#include "calib/target_sheet.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include <opencv2/aruco.hpp>

#include "calib/board_face.h"
#include "calib/marker_dictionary.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Eigen::Vector2d;
using Cell = std::pair<int, int>;

constexpr double kCaptionRoom = 0.012;  // metres below the pattern, for the line and the ruler

// The outlines of the dark cells: edges between dark and light, dark on the right hand, linked at their ends.
// One shape instead of many touching ones: viewers show hairs of paper between shapes that touch.
std::vector<std::vector<Cell>> outlines(const cv::Mat& light) {
  auto dark = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < light.cols && y < light.rows && light.at<std::uint8_t>(y, x) == 0;
  };
  std::multimap<Cell, Cell> edges;
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      if (!dark(x, y)) continue;
      if (!dark(x, y - 1)) edges.insert({{x, y}, {x + 1, y}});
      if (!dark(x + 1, y)) edges.insert({{x + 1, y}, {x + 1, y + 1}});
      if (!dark(x, y + 1)) edges.insert({{x + 1, y + 1}, {x, y + 1}});
      if (!dark(x - 1, y)) edges.insert({{x, y + 1}, {x, y}});
    }
  }
  std::vector<std::vector<Cell>> loops;
  while (!edges.empty()) {
    std::vector<Cell> loop;
    for (auto at = edges.begin(); at != edges.end(); at = edges.find(loop.back())) {
      const auto [from, to] = *at;
      const std::size_t n = loop.size();
      const bool straight = n >= 2 && ((loop[n - 2].first == to.first && from.first == to.first) ||
                                       (loop[n - 2].second == to.second && from.second == to.second));
      if (loop.empty()) loop.push_back(from);
      if (straight)
        loop.back() = to;
      else
        loop.push_back(to);
      edges.erase(at);
    }
    loop.pop_back();  // the first again
    loops.push_back(std::move(loop));
  }
  return loops;
}

class Drawing {
 public:
  Drawing(Sheet& sheet, bool inverted) : sheet_(sheet), inverted_(inverted) {}

  // The place of a face's lower left corner on the sheet; from there y goes up.
  void set_origin(double x, double y) { origin_ = {x, y}; }

  void rectangle(double x, double y, double width, double height, bool black = true) {
    add(black, {{at(x, y + height), at(x + width, y + height), at(x + width, y), at(x, y)}});
  }

  void disc(double x, double y, double radius, bool black) {
    sheet_.inks.push_back({.black = black != inverted_, .center = at(x, y), .radius = radius});
  }

  void marker(const FaceMarker& m, const MarkerDictionary& kind, int border) {
    const int across = kind.cells + 2 * border;
    cv::Mat light;
    cv::aruco::getPredefinedDictionary(kind.opencv)->drawMarker(m.id, across, light, border);
    const double cell = (m.corners[1].x() - m.corners[0].x()) / across;
    std::vector<std::vector<Vector2d>> loops;
    for (const auto& outline : outlines(light)) {
      auto& loop = loops.emplace_back();
      for (const auto& [x, y] : outline)
        loop.push_back(at(m.corners[0].x() + x * cell, m.corners[0].y() - y * cell));
    }
    add(true, std::move(loops));
  }

 private:
  Vector2d at(double x, double y) const { return {origin_.x() + x, origin_.y() - y}; }
  void add(bool black, std::vector<std::vector<Vector2d>> loops) {
    sheet_.inks.push_back({.black = black != inverted_, .loops = std::move(loops)});
  }

  Sheet& sheet_;
  bool inverted_;
  Vector2d origin_ = Vector2d::Zero();
};

// x right, y down, z into the paper, as seen from a frame with x right, y up whose origin is at `origin` on
// the paper.
Rigid3 face_from_sheet(const Vector2d& origin) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())),
          {-origin.x(), origin.y(), 0}};
}

void draw_face(Drawing& drawing, const BoardFace& face) {
  for (const Eigen::Vector4d& b : face.black) drawing.rectangle(b[0], b[1], b[2], b[3]);
  if (face.dictionary.empty()) return;
  const MarkerDictionary* kind = find_dictionary(face.dictionary);
  FLOATSTAGE_CHECK(kind, "target was not checked: dictionary " + face.dictionary);
  for (const FaceMarker& m : face.markers) drawing.marker(m, *kind, face.border);
}

Sheet board_sheet(const BoardFace& face, double margin) {
  const double surround =
      face.inverted ? face.square / 3 : 0;  // the dark of an inverted print goes on around it
  const double around = std::max(margin, 0.005 + surround);
  Sheet sheet{.width = face.width + 2 * around, .height = face.height + 2 * around + kCaptionRoom};
  const Vector2d origin(around, around + face.height);
  Drawing drawing(sheet, face.inverted);
  drawing.set_origin(origin.x(), origin.y());
  if (face.inverted)
    drawing.rectangle(-surround, -surround, face.width + 2 * surround, face.height + 2 * surround, false);
  draw_face(drawing, face);
  sheet.target_from_sheet = face.target_from_face * face_from_sheet(origin);
  return sheet;
}

Sheet wand_sheet(const Wand& wand, double margin) {
  const double size = std::max(wand.ball, wand.tag), around = std::max(margin, size / 2);
  Sheet sheet{.width = wand.positions.back() + size + 2 * around, .height = size + 2 * around + kCaptionRoom};
  const Vector2d origin(around + size / 2, around + size / 2);
  Drawing drawing(sheet, false);
  drawing.set_origin(origin.x(), origin.y());
  if (wand.ball > 0) {
    drawing.rectangle(-size, -size, wand.positions.back() + 2 * size, 2 * size);
    for (const double x : wand.positions) drawing.disc(x, 0, wand.ball / 2, false);
  }
  for (const BoardFace& face : board_faces(wand)) {
    drawing.set_origin(origin.x() + face.target_from_face.translation.x(),
                       origin.y() - face.target_from_face.translation.y());
    draw_face(drawing, face);
  }
  sheet.target_from_sheet = face_from_sheet(origin);
  return sheet;
}

}  // namespace

std::vector<Sheet> target_sheets(const TargetDesign& target, double margin) {
  std::vector<Sheet> sheets;
  if (const Wand* wand = std::get_if<Wand>(&target))
    sheets.push_back(wand_sheet(*wand, margin));
  else
    for (const BoardFace& face : board_faces(target)) sheets.push_back(board_sheet(face, margin));
  if (sheets.size() == 2) {
    sheets[0].name = "front";
    sheets[1].name = "back";
  }
  for (Sheet& sheet : sheets) sheet.caption = to_text(target);
  return sheets;
}

Result<std::vector<std::filesystem::path>> write_sheets(const TargetDesign& target,
                                                        const std::filesystem::path& file) {
  if (const Result<void> sound = check(target); !sound) return forward(sound);
  const std::vector<Sheet> sheets = target_sheets(target);
  std::vector<std::filesystem::path> written;
  if (file.extension() == ".pdf") {
    if (const Result<void> ok = write_file(file, to_pdf(sheets)); !ok) return forward(ok);
    return std::vector{file};
  }
  if (file.extension() != ".svg")
    return fail(ErrorCode::InvalidArgument,
                text(file.string(), ": a target is printed to a .pdf or a .svg file"));
  for (const Sheet& sheet : sheets) {
    std::filesystem::path name = file;
    if (!sheet.name.empty()) name.replace_filename(text(file.stem().string(), '-', sheet.name, ".svg"));
    if (const Result<void> ok = write_file(name, to_svg(sheet)); !ok) return forward(ok);
    written.push_back(std::move(name));
  }
  return written;
}

}  // namespace floatstage::calib
