#include "core/matte_edits.h"

#include <algorithm>
#include <cmath>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kVersion = 2, kWithoutSubjects = 1;
constexpr double kFarthest = 1e6;  // px: no photograph is larger

const char* name_of(MatteLabel label) {
  return label == MatteLabel::Foreground ? "foreground" : "background";
}

MatteLabel read_label(JsonFields& fields, JsonProblem& problem) {
  const std::string name = fields.string("label");
  if (name != "foreground" && name != "background")
    problem.note(fields.where(), text("the label '", name, "' is neither foreground nor background"));
  return name == "foreground" ? MatteLabel::Foreground : MatteLabel::Background;
}

std::vector<Eigen::Vector2d> read_points(JsonFields& fields, const char* key, std::size_t least,
                                         JsonProblem& problem) {
  std::vector<Eigen::Vector2d> points;
  const json* list = fields.list(key);
  if (!list) return points;
  for (const json& p : *list) {
    if (!p.is_array() || p.size() != 2 || !p[0].is_number() || !p[1].is_number()) {
      problem.note(fields.where(), text("'", key, "' must be a list of [x, y]"));
      return points;
    }
    points.emplace_back(p[0].get<double>(), p[1].get<double>());
    if (!(points.back().cwiseAbs().maxCoeff() <= kFarthest))
      problem.note(fields.where(), text("a point of '", key, "' lies far outside any photograph"));
  }
  if (points.size() < least)
    problem.note(fields.where(), text("'", key, "' needs at least ", least, " points"));
  return points;
}

int read_frame(JsonFields& fields, const char* key, JsonProblem& problem) {
  const int frame = fields.integer(key);
  if (frame < 0) problem.note(fields.where(), text("'", key, "' is negative"));
  return frame;
}

std::string read_subject(JsonFields& fields, MatteLabel label, JsonProblem& problem) {
  std::string name = fields.string("subject");
  if (!is_usable_label(name))
    problem.note(fields.where(),
                 text("'", name, "' cannot be a subject: letters, digits, '-' and '_', at most 64"));
  if (label == MatteLabel::Background)
    problem.note(fields.where(), text("the subject '", name, "' is marked as background"));
  return name;
}

MatteStroke read_stroke(const json& value, int version, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  MatteStroke stroke;
  stroke.label = read_label(fields, problem);
  stroke.radius = fields.number("radius", stroke.radius);
  if (!(stroke.radius > 0 && stroke.radius <= kFarthest)) problem.note(where, "the radius must be positive");
  stroke.points = read_points(fields, "points", 1, problem);
  if (version > kWithoutSubjects && fields.has("subject"))
    stroke.subject = read_subject(fields, stroke.label, problem);
  fields.refuse_others();
  return stroke;
}

MatteKeyframe read_keyframe(const json& value, int version, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  MatteKeyframe keyframe;
  keyframe.frame = read_frame(fields, "frame", problem);
  const std::string here = text(where, ", frame ", keyframe.frame);
  if (const json* strokes = fields.list("strokes"))
    for (const json& s : *strokes)
      keyframe.strokes.push_back(
          read_stroke(s, version, text(here, ", stroke ", keyframe.strokes.size()), problem));
  fields.refuse_others();
  return keyframe;
}

MatteMask read_mask(const json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  MatteMask mask;
  mask.label = read_label(fields, problem);
  if (fields.has("brush")) {
    mask.polygon = read_points(fields, "brush", 1, problem);
    mask.radius = fields.number("radius");
    if (!(mask.radius > 0 && mask.radius <= kFarthest)) problem.note(where, "the radius must be positive");
  } else {
    mask.polygon = read_points(fields, "polygon", 3, problem);
  }
  if (fields.has("first")) mask.first = read_frame(fields, "first", problem);
  if (fields.has("last")) mask.last = read_frame(fields, "last", problem);
  if (mask.last && *mask.last < mask.first) problem.note(where, "the mask ends before it begins");
  fields.refuse_others();
  return mask;
}

CameraEdits read_camera(const json& value, int version, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  CameraEdits edits;
  if (const json* keyframes = fields.has("keyframes") ? fields.list("keyframes") : nullptr)
    for (const json& k : *keyframes) {
      edits.keyframes.push_back(read_keyframe(k, version, where, problem));
      const std::size_t n = edits.keyframes.size();
      if (n > 1 && edits.keyframes[n - 1].frame <= edits.keyframes[n - 2].frame)
        problem.note(where, text("the keyframes are not in the order of their frames at ",
                                 edits.keyframes[n - 1].frame));
    }
  if (const json* masks = fields.has("masks") ? fields.list("masks") : nullptr)
    for (const json& m : *masks)
      edits.masks.push_back(read_mask(m, text(where, ", mask ", edits.masks.size()), problem));
  fields.refuse_others();
  return edits;
}

ordered_json points_json(const std::vector<Eigen::Vector2d>& points) {
  ordered_json list = ordered_json::array();
  for (const Eigen::Vector2d& p : points) list.push_back({p.x(), p.y()});
  return list;
}

bool has_subjects(const MatteEdits& edits) {
  for (const auto& [serial, camera] : edits.cameras)
    for (const MatteKeyframe& k : camera.keyframes)
      for (const MatteStroke& s : k.strokes)
        if (!s.subject.empty()) return true;
  return false;
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

// Calls set(x, y) for the pixels of `map` in the box that lie in the picture.
template <class F>
void for_pixels(const Image& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high, F&& set) {
  const int x0 = std::max(0, static_cast<int>(std::floor(std::max(low.x(), 0.0))));
  const int y0 = std::max(0, static_cast<int>(std::floor(std::max(low.y(), 0.0))));
  const int x1 = static_cast<int>(std::min(high.x(), map.width - 1.0)),
            y1 = static_cast<int>(std::min(high.y(), map.height - 1.0));
  for (int y = y0; y <= y1 && high.y() >= 0; ++y)
    for (int x = x0; x <= x1 && high.x() >= 0; ++x) set(x, y);
}

}  // namespace

MatteEffort effort_of(const CameraEdits& edits) {
  MatteEffort effort;
  effort.keyframes = static_cast<int>(edits.keyframes.size());
  effort.masks = static_cast<int>(edits.masks.size());
  for (const MatteKeyframe& k : edits.keyframes)
    for (const MatteStroke& s : k.strokes) ++(s.points.size() == 1 ? effort.clicks : effort.scribbles);
  return effort;
}

CameraEdits without_subjects(CameraEdits edits) {
  for (MatteKeyframe& k : edits.keyframes)
    for (MatteStroke& s : k.strokes) s.subject.clear();
  return edits;
}

Result<MatteEdits> parse_matte_edits(std::string_view bytes, std::string_view name) {
  const Result<json> document = parse_json(bytes, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  const int version = fields.integer("floatstage_edits");
  if (!problem.first && version != kVersion && version != kWithoutSubjects)
    return fail(ErrorCode::Unsupported,
                text(name, ": edits format ", version, " is not known here; this program reads formats ",
                     kWithoutSubjects, " and ", kVersion));
  MatteEdits edits;
  if (const json* cameras = fields.child("cameras")) {
    if (!cameras->is_object())
      problem.note(std::string(name), "'cameras' must be an object of serials");
    else
      for (const auto& [serial, value] : cameras->items())
        edits.cameras[serial] = read_camera(value, version, text(name, ": camera '", serial, "'"), problem);
  }
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return edits;
}

std::string to_json(const MatteEdits& edits) {
  ordered_json j = {{"floatstage_edits", has_subjects(edits) ? kVersion : kWithoutSubjects},
                    {"cameras", ordered_json::object()}};
  for (const auto& [serial, camera] : edits.cameras) {
    ordered_json out = {{"keyframes", ordered_json::array()}, {"masks", ordered_json::array()}};
    for (const MatteKeyframe& k : camera.keyframes) {
      ordered_json strokes = ordered_json::array();
      for (const MatteStroke& s : k.strokes) {
        ordered_json stroke = {
            {"label", name_of(s.label)}, {"radius", s.radius}, {"points", points_json(s.points)}};
        if (!s.subject.empty()) stroke["subject"] = s.subject;
        strokes.push_back(std::move(stroke));
      }
      out["keyframes"].push_back({{"frame", k.frame}, {"strokes", strokes}});
    }
    for (const MatteMask& m : camera.masks) {
      ordered_json mask = {{"label", name_of(m.label)}};
      if (m.radius > 0) mask["radius"] = m.radius;
      mask[m.radius > 0 ? "brush" : "polygon"] = points_json(m.polygon);
      mask["first"] = m.first;
      if (m.last) mask["last"] = *m.last;
      out["masks"].push_back(std::move(mask));
    }
    j["cameras"][serial] = std::move(out);
  }
  return print_json(j);
}

Result<MatteEdits> load_matte_edits(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return MatteEdits();
  if (!bytes) return forward(bytes);
  return parse_matte_edits(*bytes, file.string());
}

Result<void> save_matte_edits(const MatteEdits& edits, const std::filesystem::path& file) {
  return write_file(file, to_json(edits));
}

void paint_strokes(const std::vector<MatteStroke>& strokes, double scale, Image& map) {
  for (const MatteStroke& stroke : strokes) {
    const std::uint8_t value = stroke.label == MatteLabel::Foreground ? 255 : 0;
    const double radius = stroke.radius * scale;
    for (std::size_t i = 0; i < stroke.points.size(); ++i) {
      const Eigen::Vector2d a = stroke.points[i] * scale,
                            b = stroke.points[std::min(i + 1, stroke.points.size() - 1)] * scale;
      const Eigen::Vector2d margin(radius + 1, radius + 1);
      for_pixels(map, a.cwiseMin(b) - margin, a.cwiseMax(b) + margin, [&](int x, int y) {
        if (distance_to_segment({x + 0.5, y + 0.5}, a, b) <= radius) *map.at(x, y) = value;
      });
      for_pixels(map, a, a, [&](int x, int y) { *map.at(x, y) = value; });
    }
  }
}

bool holds_in(const MatteMask& mask, int frame) {
  return frame >= mask.first && (!mask.last || frame <= *mask.last);
}

void paint_masks(const std::vector<MatteMask>& masks, int frame, double scale, Image& map) {
  for (const MatteMask& mask : masks) {
    if (!holds_in(mask, frame)) continue;
    if (mask.radius > 0) {
      paint_strokes({{mask.label, mask.radius, mask.polygon}}, scale, map);
      continue;
    }
    const std::uint8_t value = mask.label == MatteLabel::Foreground ? 255 : 0;
    for (int y = 0; y < map.height; ++y) {
      // Where the row's centre line crosses the outline; between the first and second crossing is inside, and
      // so on.
      std::vector<double> crossings;
      const double level = (y + 0.5) / scale;
      for (std::size_t i = 0; i < mask.polygon.size(); ++i) {
        const Eigen::Vector2d &a = mask.polygon[i], &b = mask.polygon[(i + 1) % mask.polygon.size()];
        if ((a.y() <= level) == (b.y() <= level)) continue;
        crossings.push_back(scale * (a.x() + (level - a.y()) / (b.y() - a.y()) * (b.x() - a.x())));
      }
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
        const double left = std::max(0.0, std::ceil(crossings[i] - 0.5)),
                     right = std::min(map.width - 1.0, crossings[i + 1] - 0.5);
        for (int x = static_cast<int>(left); x <= right; ++x) *map.at(x, y) = value;
      }
    }
  }
}

}  // namespace floatstage
