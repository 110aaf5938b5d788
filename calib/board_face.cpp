#include "calib/board_face.h"

#include <numbers>
#include <utility>

namespace floatstage::calib {
namespace {

using Eigen::Vector2d;

FaceMarker marker_at(int id, double left, double bottom, double side) {
  return {id,
          {Vector2d(left, bottom + side), Vector2d(left + side, bottom + side), Vector2d(left + side, bottom),
           Vector2d(left, bottom)}};
}

// Squares, inner corners and, where there are markers, what is in the white squares. Rows count from the top.
BoardFace squares(int columns, int rows, double square, bool white_first, int first_point) {
  BoardFace face{.width = columns * square, .height = rows * square, .square = square};
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      if (((r + c) % 2 == 0) != white_first)
        face.black.emplace_back(c * square, (rows - 1 - r) * square, square, square);
  for (int r = 1; r < rows; ++r)
    for (int c = 1; c < columns; ++c)
      face.points.push_back(
          {first_point + (r - 1) * (columns - 1) + c - 1, {c * square, (rows - r) * square}});
  return face;
}

BoardFace charuco_face(const CharucoBoard& b, int first_marker, int first_point) {
  BoardFace face = squares(b.columns, b.rows, b.square, b.white_first, first_point);
  face.dictionary = b.dictionary;
  face.inverted = b.inverted;
  const double margin = (b.square - b.marker) / 2;
  int id = first_marker;
  for (int r = 0; r < b.rows; ++r)
    for (int c = 0; c < b.columns; ++c)
      if (((r + c) % 2 == 0) == b.white_first)
        face.markers.push_back(
            marker_at(id++, c * b.square + margin, (b.rows - 1 - r) * b.square + margin, b.marker));
  return face;
}

std::vector<BoardFace> faces(const Chessboard& b) { return {squares(b.columns, b.rows, b.square, false, 0)}; }

std::vector<BoardFace> faces(const CharucoBoard& b) { return {charuco_face(b, b.first_marker, 0)}; }

std::vector<BoardFace> faces(const TwoSidedBoard& b) {
  BoardFace front = charuco_face(b.front, b.front.first_marker, 0);
  BoardFace back = charuco_face(b.front, b.back_first_marker, static_cast<int>(front.points.size()));
  back.target_from_face = {Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY())),
                           {back.width, 0, -b.thickness}};
  return {std::move(front), std::move(back)};
}

std::vector<BoardFace> faces(const AprilTagGrid& g) {
  const double pitch = g.tag + g.gap;
  BoardFace face{.width = g.columns * pitch + g.gap,
                 .height = g.rows * pitch + g.gap,
                 .dictionary = g.dictionary,
                 .border = g.border};
  for (int r = 0; r <= g.rows; ++r)
    for (int c = 0; c <= g.columns; ++c) face.black.emplace_back(c * pitch, r * pitch, g.gap, g.gap);
  for (int r = 0; r < g.rows; ++r) {
    for (int c = 0; c < g.columns; ++c) {
      const int index = r * g.columns + c;
      const double x = g.gap + c * pitch, y = g.gap + r * pitch;
      face.markers.push_back(marker_at(g.first_tag + index, x, y, g.tag));
      const Vector2d corners[] = {{x, y}, {x + g.tag, y}, {x + g.tag, y + g.tag}, {x, y + g.tag}};
      for (int k = 0; k < 4; ++k) face.points.push_back({4 * index + k, corners[k]});
    }
  }
  return {std::move(face)};
}

std::vector<BoardFace> faces(const Wand& w) {
  std::vector<BoardFace> all;
  if (w.tag <= 0) return all;
  for (std::size_t i = 0; i < w.positions.size(); ++i) {
    const int number = static_cast<int>(i);
    BoardFace face{.width = w.tag, .height = w.tag, .dictionary = w.dictionary};
    face.target_from_face.translation = {w.positions[i] - w.tag / 2, -w.tag / 2, 0};
    face.markers.push_back(marker_at(w.first_tag + number, 0, 0, w.tag));
    face.points.push_back({number, {w.tag / 2, w.tag / 2}});
    all.push_back(std::move(face));
  }
  return all;
}

}  // namespace

std::vector<BoardFace> board_faces(const TargetDesign& target) {
  return std::visit([](const auto& t) { return faces(t); }, target);
}

std::vector<Eigen::Vector3d> target_points(const TargetDesign& design) {
  std::vector<Eigen::Vector3d> points;
  for (const TargetPoint& p : make_target(design, "").points) points.push_back(p.position);
  return points;
}

Target make_target(const TargetDesign& design, std::string name, double length_sigma) {
  Target target;
  target.name = std::move(name);
  if (const Wand* wand = std::get_if<Wand>(&design)) {
    target.kind = TargetKind::Wand;
    const int count = static_cast<int>(wand->positions.size());
    for (int a = 0; a < count; ++a) {
      target.points.push_back({.id = a, .position = {wand->positions[static_cast<std::size_t>(a)], 0, 0}});
      for (int b = 0; b < a; ++b)
        target.lengths.push_back(
            {b, a,
             wand->positions[static_cast<std::size_t>(a)] - wand->positions[static_cast<std::size_t>(b)],
             length_sigma});
    }
    return target;
  }
  for (const BoardFace& face : board_faces(design))
    for (const FacePoint& p : face.points)
      target.points.push_back(
          {.id = p.id,
           .position = face.target_from_face * Eigen::Vector3d(p.position.x(), p.position.y(), 0),
           .normal = face.target_from_face.rotation * Eigen::Vector3d::UnitZ()});
  if (const auto* b = std::get_if<Chessboard>(&design))
    target.grid = {b->columns - 1, b->rows - 1, b->square};
  if (const auto* b = std::get_if<CharucoBoard>(&design))
    target.grid = {b->columns - 1, b->rows - 1, b->square};
  return target;
}

}  // namespace floatstage::calib
