// Polygons of labelling programs: labelme's JSON of a picture and COCO's of many
// (https://github.com/wkentaro/labelme, https://cocodataset.org/#format-data).
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/json_fields.h"
#include "core/text.h"
#include "pipeline/import/contours.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;
using nlohmann::json;
using Polygon = std::vector<Vector2d>;

constexpr double kBeyond = 1;             // px by which a point may leave the picture: a hand slips
constexpr int kLargestSide = 32768;       // px, as of PNGs
constexpr std::size_t kMostPoints = 1e5;  // of a picture
constexpr double kNoArea = 1e-6;          // px²

double area_of(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return 0.5 * std::abs(twice);
}

/// The points of one polygon, told apart, moved to our origin; what is wrong with them, a clause.
Result<Polygon> polygon_of(const std::vector<double>& numbers, const PictureContours& picture,
                           ContourOrigin origin) {
  const auto wrong = [](const std::string& what) { return fail(ErrorCode::BadData, what); };
  if (numbers.size() % 2 != 0) return wrong(text("has ", numbers.size(), " numbers, x without y"));
  const double shift = origin == ContourOrigin::Centre ? 0.5 : 0;
  Polygon out;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    const Vector2d p(numbers[i] + shift, numbers[i + 1] + shift);
    if (!(p.x() >= -kBeyond && p.y() >= -kBeyond && p.x() <= picture.width + kBeyond &&
          p.y() <= picture.height + kBeyond))
      return wrong(text("has the point (", numbers[i], ", ", numbers[i + 1], ") outside its picture of ",
                        picture.width, "x", picture.height,
                        "; are these the contours of a picture of another size?"));
    if (out.empty() || p != out.back()) out.push_back(p);
  }
  while (out.size() > 1 && out.front() == out.back()) out.pop_back();
  if (out.size() < 3) return wrong(text("has ", out.size(), " points; a polygon has three at least"));
  return out;
}

/// Collects a picture's shapes; remembers the first that is wrong.
class Shapes {
 public:
  Shapes(const PictureContours& picture, const ContourOptions& options)
      : picture_(picture), options_(options) {}

  bool counts(const std::string& label) const {
    return options_.labels.empty() ||
           std::find(options_.labels.begin(), options_.labels.end(), label) != options_.labels.end();
  }

  Result<void> add(ContourShape& shape, const std::vector<double>& numbers) {
    points_ += numbers.size() / 2;
    if (points_ > kMostPoints)
      return fail(ErrorCode::BadData, text("is one of more than ", kMostPoints, " points of one picture"));
    Result<Polygon> polygon = polygon_of(numbers, picture_, options_.origin);
    if (!polygon) return forward(polygon);
    // Written twice it would be a hole in itself.
    if (std::find(shape.polygons.begin(), shape.polygons.end(), *polygon) == shape.polygons.end())
      shape.polygons.push_back(std::move(*polygon));
    return {};
  }

 private:
  const PictureContours& picture_;
  const ContourOptions& options_;
  std::size_t points_ = 0;
};

Result<void> check_shape(const ContourShape& shape) {
  const std::optional<Vector2d> at = crossing_of(shape.polygons);
  if (!at) {
    for (const Polygon& polygon : shape.polygons)
      if (area_of(polygon) < kNoArea) return fail(ErrorCode::BadData, "encloses nothing; delete it");
    return {};
  }
  const auto tenths = [](double v) { return std::round(10 * v) / 10; };
  return fail(ErrorCode::BadData, text("crosses itself near (", tenths(at->x()), ", ", tenths(at->y()),
                                       "), so that inside and outside are not known; draw it anew there"));
}

Result<void> check_size(const PictureContours& picture, const std::string& where) {
  if (picture.width >= 1 && picture.height >= 1 && picture.width <= kLargestSide &&
      picture.height <= kLargestSide)
    return {};
  return fail(ErrorCode::BadData,
              text(where, ": a picture of ", picture.width, "x", picture.height, " pixels cannot be"));
}

/// Numbers of a list, or a list of lists of two; nothing where there is anything else.
std::optional<std::vector<double>> numbers_of(const json& list, bool pairs) {
  if (!list.is_array()) return std::nullopt;
  std::vector<double> out;
  for (const json& item : list) {
    if (pairs) {
      if (!item.is_array() || item.size() != 2 || !item[0].is_number() || !item[1].is_number())
        return std::nullopt;
      out.push_back(item[0].get<double>()), out.push_back(item[1].get<double>());
    } else {
      if (!item.is_number()) return std::nullopt;
      out.push_back(item.get<double>());
    }
  }
  return out;
}

}  // namespace

Result<PictureContours> parse_labelme(std::string_view content, std::string_view name,
                                      const ContourOptions& options) {
  const Result<json> root = parse_json(content, name);
  if (!root) return forward(root);
  JsonProblem problem;
  JsonFields file(*root, std::string(name), problem);
  if (file.has("annotations") && !file.has("shapes"))
    return fail(ErrorCode::BadData,
                text(name, ": is COCO's JSON of many pictures, not labelme's of one; give the file itself"));
  PictureContours out;
  if (file.has("imagePath") && root->at("imagePath").is_string())
    out.picture = root->at("imagePath").get<std::string>();
  out.width = file.integer("imageWidth");
  out.height = file.integer("imageHeight");
  const json* const list = file.list("shapes");
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  if (Result<void> ok = check_size(out, std::string(name)); !ok) return forward(ok);
  Shapes shapes(out, options);
  std::map<std::pair<std::string, std::string>, std::size_t> groups;
  for (std::size_t i = 0; i < list->size(); ++i) {
    JsonFields fields((*list)[i], text(name, ": shape ", i), problem);
    const std::string label = fields.string("label");
    const json* const points = fields.child("points");
    if (problem.first) break;
    if (!shapes.counts(label)) continue;
    const std::string where = text(name, ": shape ", i, " ('", label, "') ");
    const json* const type = fields.child("shape_type", false);
    if (type != nullptr && *type != "polygon")
      return fail(ErrorCode::BadData, text(where,
                                           "is no polygon; delete it, or name the labels that count with "
                                           "--contour-labels"));
    const std::optional<std::vector<double>> numbers = numbers_of(*points, true);
    if (!numbers) return fail(ErrorCode::BadData, text(where, "has points that are not pairs of numbers"));
    const json* const group = fields.child("group_id", false);
    const bool grouped = group != nullptr && !group->is_null();
    const auto [entry, is_new] =
        groups.try_emplace({label, grouped ? group->dump() : text("alone ", i)}, out.shapes.size());
    if (is_new) out.shapes.push_back({label, {}});
    ContourShape& shape = out.shapes[entry->second];
    Result<void> ok = shapes.add(shape, *numbers);
    if (!ok) return fail(ok.error().code, where + ok.error().message);
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  for (const ContourShape& shape : out.shapes)
    if (Result<void> ok = check_shape(shape); !ok)
      return fail(ok.error().code, text(name, ": '", shape.label, "' ", ok.error().message));
  return out;
}

namespace {

Result<std::map<int, std::string>> categories_of(JsonFields& file, const ContourOptions& options,
                                                 JsonProblem& problem) {
  std::map<int, std::string> names;
  std::string known;
  const json* const list = file.list("categories");
  for (std::size_t i = 0; list != nullptr && !problem.first && i < list->size(); ++i) {
    JsonFields fields((*list)[i], text(file.where(), ": category ", i), problem);
    const int id = fields.integer("id");
    names[id] = fields.string("name");
    known += text(i > 0 ? ", " : "", names[id]);
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  for (const std::string& label : options.labels)
    if (std::none_of(names.begin(), names.end(), [&](const auto& n) { return n.second == label; }))
      return fail(ErrorCode::InvalidArgument,
                  text(file.where(), ": has no category '", label, "'; it has ", known));
  return names;
}

}  // namespace

Result<std::vector<PictureContours>> parse_coco(std::string_view content, std::string_view name,
                                                const ContourOptions& options) {
  const Result<json> root = parse_json(content, name);
  if (!root) return forward(root);
  JsonProblem problem;
  JsonFields file(*root, std::string(name), problem);
  if (file.has("shapes") && !file.has("annotations"))
    return fail(ErrorCode::BadData,
                text(name,
                     ": is labelme's JSON of one picture, not COCO's of many; give the folder that it "
                     "lies in"));
  const json *const images = file.list("images"), *const annotations = file.list("annotations");
  const Result<std::map<int, std::string>> categories = categories_of(file, options, problem);
  if (!categories) return forward(categories);
  std::vector<PictureContours> out;
  std::map<int, std::size_t> picture_of;
  std::set<std::string> files;
  for (std::size_t i = 0; i < images->size(); ++i) {
    JsonFields fields((*images)[i], text(name, ": image ", i), problem);
    const int id = fields.integer("id");
    PictureContours picture{
        fields.string("file_name"), fields.integer("width"), fields.integer("height"), {}};
    if (problem.first) return fail(ErrorCode::BadData, *problem.first);
    if (Result<void> ok = check_size(picture, fields.where()); !ok) return forward(ok);
    if (!picture_of.emplace(id, out.size()).second || !files.insert(picture.picture).second)
      return fail(ErrorCode::BadData, text(fields.where(), ": its id ", id, " or its name '", picture.picture,
                                           "' is another image's too"));
    out.push_back(std::move(picture));
  }
  std::vector<Shapes> shapes;
  shapes.reserve(out.size());
  for (const PictureContours& picture : out) shapes.emplace_back(picture, options);
  for (std::size_t i = 0; i < annotations->size(); ++i) {
    JsonFields fields((*annotations)[i], text(name, ": annotation ", i), problem);
    const int image = fields.integer("image_id"), category = fields.integer("category_id");
    const json* const segmentation = fields.child("segmentation");
    if (problem.first) return fail(ErrorCode::BadData, *problem.first);
    const auto picture = picture_of.find(image);
    const auto label = categories->find(category);
    if (picture == picture_of.end() || label == categories->end())
      return fail(ErrorCode::BadData, text(fields.where(), ": is of image ", image, " and category ",
                                           category, ", which are not both in the file"));
    if (!shapes[picture->second].counts(label->second)) continue;
    const std::string where = text(fields.where(), " (of ", out[picture->second].picture, ") ");
    if (!segmentation->is_array())
      return fail(ErrorCode::BadData,
                  text(where,
                       "is a run-length mask, no polygons; export polygons, or masks as PNG for "
                       "--mattes"));
    ContourShape shape{label->second, {}};
    for (const json& list : *segmentation) {
      const std::optional<std::vector<double>> numbers = numbers_of(list, false);
      if (!numbers) return fail(ErrorCode::BadData, where + "has a polygon that is no list of numbers");
      Result<void> ok = shapes[picture->second].add(shape, *numbers);
      if (!ok) return fail(ok.error().code, where + ok.error().message);
    }
    if (Result<void> ok = check_shape(shape); !ok) return fail(ok.error().code, where + ok.error().message);
    if (!shape.polygons.empty()) out[picture->second].shapes.push_back(std::move(shape));
  }
  return out;
}

}  // namespace floatstage::pipeline
