#include "core/rig_io.h"

#include <algorithm>
#include <cmath>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage {
namespace {

using Json = nlohmann::ordered_json;

// The lowest format that holds a rig is written, so that older programs read what they can.
constexpr int kPlain = 1, kWithColorCurve = 2, kWithRationalLens = 3;
constexpr int kVersion = kWithRationalLens;  // what is read at most

int format_of(const Rig& rig) {
  int format = kPlain;
  for (const RigCamera& c : rig.cameras) {
    const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
    if (brown != nullptr && brown->rational()) return kWithRationalLens;
    if (c.color.has_curve()) format = kWithColorCurve;
  }
  return format;
}

Json lens_to_json(const Lens& lens) {
  if (const auto* b = std::get_if<BrownConrady>(&lens)) {
    Json json = {
        {"type", "brown-conrady"}, {"k1", b->k1}, {"k2", b->k2}, {"p1", b->p1}, {"p2", b->p2}, {"k3", b->k3}};
    if (b->rational()) json.update({{"k4", b->k4}, {"k5", b->k5}, {"k6", b->k6}});
    return json;
  }
  if (const auto* f = std::get_if<KannalaBrandt>(&lens))
    return {{"type", "kannala-brandt"}, {"k1", f->k1}, {"k2", f->k2}, {"k3", f->k3}, {"k4", f->k4}};
  return {{"type", "none"}};
}

Lens read_lens(JsonFields fields, JsonProblem& problem) {
  const std::string type = fields.string("type");
  Lens lens;
  if (type == "brown-conrady")
    lens = BrownConrady{.k1 = fields.number("k1"),
                        .k2 = fields.number("k2"),
                        .p1 = fields.number("p1"),
                        .p2 = fields.number("p2"),
                        .k3 = fields.number("k3"),
                        .k4 = fields.number("k4", 0.0),
                        .k5 = fields.number("k5", 0.0),
                        .k6 = fields.number("k6", 0.0)};
  else if (type == "kannala-brandt")
    lens = KannalaBrandt{.k1 = fields.number("k1"),
                         .k2 = fields.number("k2"),
                         .k3 = fields.number("k3"),
                         .k4 = fields.number("k4")};
  else if (type != "none")
    problem.note(fields.where(),
                 text("unknown lens type '", type, "'; known: none, brown-conrady, kannala-brandt"));
  fields.refuse_others();
  return lens;
}

Rigid3 read_transform(JsonFields fields) {
  const std::vector<double> q = fields.numbers("rotation_wxyz", 4), t = fields.numbers("translation", 3);
  fields.refuse_others();
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), Eigen::Vector3d(t[0], t[1], t[2])};
}

Json camera_to_json(const RigCamera& c) {
  const Eigen::Quaterniond& q = c.cam_from_world.rotation;
  const Eigen::Vector3d& t = c.cam_from_world.translation;
  Json color = Json::array();
  for (int r = 0; r < 3; ++r)
    color.push_back({c.color.matrix(r, 0), c.color.matrix(r, 1), c.color.matrix(r, 2)});
  Json camera = {{"serial", c.serial},
                 {"width", c.model.width},
                 {"height", c.model.height},
                 {"fx", c.model.fx},
                 {"fy", c.model.fy},
                 {"cx", c.model.cx},
                 {"cy", c.model.cy},
                 {"skew", c.model.skew},
                 {"lens", lens_to_json(c.model.lens)},
                 {"cam_from_world",
                  {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}, {"translation", {t.x(), t.y(), t.z()}}}},
                 {"color_matrix", std::move(color)}};
  const Eigen::Vector3d& d = c.color.decode;
  if (c.color.has_curve())
    camera["color_curve"] = {{"decode", {d.x(), d.y(), d.z()}}, {"encode", c.color.encode}};
  return camera;
}

RigCamera read_camera(const nlohmann::json& value, std::size_t index, std::string_view name,
                      JsonProblem& problem) {
  const bool named = value.is_object() && value.contains("serial") && value["serial"].is_string();
  JsonFields fields(value,
                    named ? text(name, ": camera '", value["serial"].get<std::string>(), "'")
                          : text(name, ": camera ", index),
                    problem);
  RigCamera c;
  c.serial = fields.string("serial");
  c.model = {.width = fields.integer("width"),
             .height = fields.integer("height"),
             .fx = fields.number("fx"),
             .fy = fields.number("fy"),
             .cx = fields.number("cx"),
             .cy = fields.number("cy"),
             .skew = fields.number("skew", 0.0),
             .lens = {}};
  if (const nlohmann::json* lens = fields.child("lens", false))
    c.model.lens = read_lens(JsonFields(*lens, fields.where() + ": lens", problem), problem);
  if (const nlohmann::json* transform = fields.child("cam_from_world"))
    c.cam_from_world = read_transform(JsonFields(*transform, fields.where() + ": cam_from_world", problem));
  if (fields.has("color_matrix")) {
    const std::vector<double> m = fields.numbers("color_matrix", 9);
    c.color.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data());
  }
  if (const nlohmann::json* curve = fields.child("color_curve", false)) {
    JsonFields curve_fields(*curve, fields.where() + ": color_curve", problem);
    const std::vector<double> d = curve_fields.numbers("decode", 3);
    c.color.decode = {d[0], d[1], d[2]};
    c.color.encode = curve_fields.number("encode");
    curve_fields.refuse_others();
  }
  fields.refuse_others();
  return c;
}

}  // namespace

Result<Rig> parse_rig(std::string_view bytes, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(bytes, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  const int version = fields.integer("floatstage_rig");
  if (!problem.first && (version < 1 || version > kVersion))
    return fail(ErrorCode::Unsupported,
                text(name, ": rig format ", version, " is not known here; this program reads formats 1 to ",
                     kVersion));
  Rig rig;
  if (const nlohmann::json* cameras = fields.list("cameras"))
    for (const nlohmann::json& camera : *cameras)
      rig.cameras.push_back(read_camera(camera, rig.cameras.size(), name, problem));
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  if (Result<void> ok = check(rig); !ok) return fail(ok.error().code, text(name, ": ", ok.error().message));
  return rig;
}

std::string to_json(const Rig& rig) {
  Json cameras = Json::array();
  for (const RigCamera& c : rig.cameras) cameras.push_back(camera_to_json(c));
  return print_json({{"floatstage_rig", format_of(rig)}, {"cameras", std::move(cameras)}});
}

Result<Rig> load_rig(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_rig(*bytes, file.string());
}

Result<void> save_rig(const Rig& rig, const std::filesystem::path& file) {
  // JSON has no NaN: a rig that we could not read back is never written.
  if (Result<void> ok = check(rig); !ok)
    return fail(ok.error().code, text(file.string(), ": not written: ", ok.error().message));
  return write_file(file, to_json(rig));
}

}  // namespace floatstage
