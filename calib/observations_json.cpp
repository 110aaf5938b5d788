#include <algorithm>
#include <cmath>

#include "calib/observations.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

constexpr const char* kKinds[] = {"board", "wand", "markers"};
constexpr const char* kLenses[] = {"none", "brown-conrady", "kannala-brandt"};
constexpr const char* kPriors[] = {"unknown", "start", "fixed"};

template <class Enum, std::size_t N>
Enum one_of(const char* const (&names)[N], JsonFields& fields, const char* key, JsonProblem& problem) {
  const std::string word = fields.string(key);
  std::string all;
  for (std::size_t i = 0; i < N; ++i) {
    if (word == names[i]) return static_cast<Enum>(i);
    all += text(i ? ", " : "", names[i]);
  }
  problem.note(fields.where(), text("'", key, "' is '", word, "'; known: ", all));
  return Enum{};
}

template <class Enum, std::size_t N>
const char* name_in(const char* const (&names)[N], Enum value) {
  return names[static_cast<std::size_t>(value)];
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json transform_json(const Rigid3& t) {
  const Eigen::Quaterniond& q = t.rotation;
  return {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}, {"translation", vector_json(t.translation)}};
}

Rigid3 read_transform(JsonFields& parent, const char* key, JsonProblem& problem) {
  const nlohmann::json* value = parent.child(key);
  if (!value) return {};
  JsonFields fields(*value, text(parent.where(), ": ", key), problem);
  const std::vector<double> q = fields.numbers("rotation_wxyz", 4), t = fields.numbers("translation", 3);
  fields.refuse_others();
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), Eigen::Vector3d(t[0], t[1], t[2])};
}

// What is known of the cameras is a rig of its own, written and read as rig.json is.
Json camera_json(const CalibrationCamera& c) {
  Json out = {{"serial", c.serial},
              {"width", c.width},
              {"height", c.height},
              {"lens", name_in(kLenses, c.lens)},
              {"intrinsics", name_in(kPriors, c.intrinsics)},
              {"pose", name_in(kPriors, c.pose)}};
  if (c.found) out["found"] = transform_json(*c.found);
  // Only what was chosen, so that older programs read what they can solve.
  if (c.terms.radial) out["radial"] = *c.terms.radial;
  if (!c.terms.tangential) out["tangential"] = false;
  if (c.terms.skew) out["skew"] = true;
  if (c.same_lens_as) out["same_lens_as"] = *c.same_lens_as;
  if (c.plain_lens) out["plain_lens"] = true;
  return out;
}

Rig known_rig(const Observations& o) {
  Rig rig;
  for (const CalibrationCamera& c : o.cameras) {
    if (c.intrinsics == Prior::Unknown && c.pose == Prior::Unknown) continue;
    CameraModel model = c.model;
    if (c.intrinsics == Prior::Unknown)
      model = {.width = c.width, .height = c.height, .fx = 1, .fy = 1, .cx = 0, .cy = 0, .lens = {}};
    rig.cameras.push_back({c.serial, model, c.pose == Prior::Unknown ? Rigid3{} : c.cam_from_world, {}});
  }
  return rig;
}

Json target_json(const Target& t) {
  Json points = Json::array(), lengths = Json::array();
  for (const TargetPoint& p : t.points) {
    Json row = {p.id, p.position.x(), p.position.y(), p.position.z()};
    if (!p.normal.isZero(0)) row.insert(row.end(), {p.normal.x(), p.normal.y(), p.normal.z()});
    points.push_back(std::move(row));
  }
  for (const TargetLength& l : t.lengths) lengths.push_back({l.a, l.b, l.metres, l.sigma});
  Json out = {{"name", t.name},
              {"kind", name_in(kKinds, t.kind)},
              {"static", t.is_static},
              {"points", std::move(points)},
              {"lengths", std::move(lengths)}};
  if (t.grid) out["grid"] = {t.grid->columns, t.grid->rows, t.grid->pitch};
  if (t.positions_sigma) out["positions_sigma"] = *t.positions_sigma;
  return out;
}

Json view_json(const TargetView& v) {
  Json points = Json::array();
  for (const SeenPoint& p : v.points) points.push_back({p.id, p.pixel.x(), p.pixel.y(), p.sigma});
  return {{"camera", v.camera},
          {"target", v.target},
          {"frame", v.frame},
          {"time_ns", v.time.ns},
          {"points", std::move(points)}};
}

Json gauge_json(const Gauge& gauge) {
  if (const auto* floor = std::get_if<FloorBoard>(&gauge))
    return {{"type", "floor-board"},
            {"target", floor->target},
            {"frame", floor->frame},
            {"height", floor->height}};
  if (const auto* hand = std::get_if<HandSet>(&gauge))
    return {{"type", "hand-set"},
            {"camera", hand->camera},
            {"cam_from_world", transform_json(hand->cam_from_world)}};
  return {{"type", "own"}};
}

// A row of numbers whose first `ids` are whole; empty after a complaint.
std::vector<double> row_of(const nlohmann::json& value, std::size_t ids,
                           std::initializer_list<std::size_t> sizes, const std::string& where,
                           JsonProblem& problem) {
  std::vector<double> row;
  bool good = value.is_array() && std::find(sizes.begin(), sizes.end(), value.size()) != sizes.end();
  for (std::size_t i = 0; good && i < value.size(); ++i) {
    good = value[i].is_number() &&
           (i >= ids || (value[i].is_number_integer() && std::abs(value[i].get<double>()) < 2e9));
    if (good) row.push_back(value[i].get<double>());
  }
  if (good) return row;
  problem.note(where, "a row of numbers is expected that begins with whole ids; see docs/formats.md");
  return {};
}

CalibrationCamera read_camera(const nlohmann::json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  CalibrationCamera c;
  c.serial = fields.string("serial");
  c.width = fields.integer("width");
  c.height = fields.integer("height");
  c.lens = one_of<LensKind>(kLenses, fields, "lens", problem);
  c.intrinsics = one_of<Prior>(kPriors, fields, "intrinsics", problem);
  c.pose = one_of<Prior>(kPriors, fields, "pose", problem);
  if (fields.has("found")) c.found = read_transform(fields, "found", problem);
  if (fields.has("radial")) c.terms.radial = std::clamp(fields.integer("radial"), 0, 6);
  if (fields.has("tangential")) c.terms.tangential = fields.boolean("tangential");
  if (fields.has("skew")) c.terms.skew = fields.boolean("skew");
  if (fields.has("same_lens_as")) c.same_lens_as = fields.integer("same_lens_as");
  if (fields.has("plain_lens")) c.plain_lens = fields.boolean("plain_lens");
  fields.refuse_others();
  return c;
}

Target read_target(const nlohmann::json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  Target t;
  t.name = fields.string("name");
  t.kind = one_of<TargetKind>(kKinds, fields, "kind", problem);
  t.is_static = fields.boolean("static");
  if (const nlohmann::json* points = fields.list("points"))
    for (const nlohmann::json& p : *points)
      if (const std::vector<double> r = row_of(p, 1, {4, 7}, where + ": points", problem); !r.empty()) {
        t.points.push_back({static_cast<int>(r[0]), {r[1], r[2], r[3]}, Eigen::Vector3d::Zero()});
        if (r.size() == 7) t.points.back().normal = {r[4], r[5], r[6]};
      }
  if (const nlohmann::json* lengths = fields.list("lengths"))
    for (const nlohmann::json& l : *lengths)
      if (const std::vector<double> r = row_of(l, 2, {4}, where + ": lengths", problem); !r.empty())
        t.lengths.push_back({static_cast<int>(r[0]), static_cast<int>(r[1]), r[2], r[3]});
  if (const nlohmann::json* grid = fields.child("grid", false))
    if (const std::vector<double> r = row_of(*grid, 2, {3}, where + ": grid", problem); !r.empty())
      t.grid = TargetGrid{static_cast<int>(r[0]), static_cast<int>(r[1]), r[2]};
  if (fields.has("positions_sigma")) t.positions_sigma = fields.number("positions_sigma");
  fields.refuse_others();
  return t;
}

TargetView read_view(const nlohmann::json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  TargetView v;
  v.camera = fields.integer("camera");
  v.target = fields.integer("target");
  v.frame = fields.integer("frame");
  if (const nlohmann::json* ns = fields.child("time_ns")) {
    if (ns->is_number_integer())
      v.time.ns = ns->get<std::int64_t>();
    else
      problem.note(where, "'time_ns' is not a whole number");
  }
  if (const nlohmann::json* points = fields.list("points"))
    for (const nlohmann::json& p : *points)
      if (const std::vector<double> r = row_of(p, 1, {4}, where + ": points", problem); !r.empty())
        v.points.push_back({static_cast<int>(r[0]), {r[1], r[2]}, r[3]});
  fields.refuse_others();
  return v;
}

Gauge read_gauge(const nlohmann::json& value, const std::string& where, JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  const std::string type = fields.string("type");
  Gauge gauge;
  if (type == "floor-board")
    gauge = FloorBoard{fields.integer("target"), fields.integer("frame"), fields.number("height")};
  else if (type == "hand-set")
    gauge = HandSet{fields.integer("camera"), read_transform(fields, "cam_from_world", problem)};
  else if (type != "own")
    problem.note(where, text("'type' is '", type, "'; known: own, floor-board, hand-set"));
  fields.refuse_others();
  return gauge;
}

// `known` is null where nothing is.
Result<void> add_known(Observations& o, const nlohmann::json* known, std::string_view name) {
  const Result<Rig> rig = known ? parse_rig(known->dump(), text(name, ": known")) : Result<Rig>(Rig{});
  if (!rig) return forward(rig);
  for (CalibrationCamera& c : o.cameras) {
    if (c.intrinsics == Prior::Unknown && c.pose == Prior::Unknown) continue;
    const int index = camera_index(*rig, c.serial);
    if (index < 0)
      return fail(ErrorCode::BadData, text(name, ": camera '", c.serial, "' is not among the known ones"));
    const RigCamera& from = rig->cameras[static_cast<std::size_t>(index)];
    if (c.intrinsics != Prior::Unknown) c.model = from.model;
    if (c.pose != Prior::Unknown) c.cam_from_world = from.cam_from_world;
  }
  return {};
}

}  // namespace

std::string to_json(const Observations& o) {
  Json cameras = Json::array(), targets = Json::array(), views = Json::array();
  for (const CalibrationCamera& c : o.cameras) cameras.push_back(camera_json(c));
  for (const Target& t : o.targets) targets.push_back(target_json(t));
  for (const TargetView& v : o.views) views.push_back(view_json(v));
  // Compact: a capture has hundreds of thousands of points.
  Json document = {{"floatstage_observations", kVersion}, {"cameras", std::move(cameras)}};
  if (const Rig known = known_rig(o); !known.cameras.empty()) document["known"] = Json::parse(to_json(known));
  document["targets"] = std::move(targets);
  for (const CameraDistance& d : o.distances)
    document["camera_distances"].push_back({d.a, d.b, d.metres, d.sigma});
  document["gauge"] = gauge_json(o.gauge);
  document["views"] = std::move(views);
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Observations> parse_observations(std::string_view bytes, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(bytes, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  const int version = fields.integer("floatstage_observations");
  if (!problem.first && version != kVersion)
    return fail(ErrorCode::Unsupported,
                text(name, ": format ", version, " of observations is not known here; this program reads ",
                     kVersion));
  Observations o;
  if (const nlohmann::json* cameras = fields.list("cameras"))
    for (const nlohmann::json& c : *cameras)
      o.cameras.push_back(read_camera(c, text(name, ": camera ", o.cameras.size()), problem));
  if (const nlohmann::json* targets = fields.list("targets"))
    for (const nlohmann::json& t : *targets)
      o.targets.push_back(read_target(t, text(name, ": target ", o.targets.size()), problem));
  if (const nlohmann::json* views = fields.list("views"))
    for (const nlohmann::json& v : *views)
      o.views.push_back(read_view(v, text(name, ": view ", o.views.size()), problem));
  if (fields.has("camera_distances"))
    if (const nlohmann::json* distances = fields.list("camera_distances"))
      for (const nlohmann::json& d : *distances)
        if (const std::vector<double> r = row_of(d, 2, {4}, text(name, ": camera_distances"), problem);
            !r.empty())
          o.distances.push_back({static_cast<int>(r[0]), static_cast<int>(r[1]), r[2], r[3]});
  if (const nlohmann::json* gauge = fields.child("gauge"))
    o.gauge = read_gauge(*gauge, text(name, ": gauge"), problem);
  const nlohmann::json* known = fields.child("known", false);
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  if (Result<void> ok = add_known(o, known, name); !ok) return forward(ok);
  if (Result<void> ok = check(o); !ok) return fail(ok.error().code, text(name, ": ", ok.error().message));
  return o;
}

Result<Observations> load_observations(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_observations(*bytes, file.string());
}

Result<void> save_observations(const Observations& observations, const std::filesystem::path& file) {
  if (Result<void> ok = check(observations); !ok)
    return fail(ok.error().code, text(file.string(), ": not written: ", ok.error().message));
  return write_file(file, to_json(observations));
}

}  // namespace floatstage::calib
