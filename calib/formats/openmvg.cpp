// sfm_data.json of OpenMVG (its cereal archive): views, intrinsics and extrinsics by number. A pose is a
// rotation and a centre; pixels count from the first one's centre, where its undistortion reads whole
// numbers.
#include <cstdint>
#include <map>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Json = nlohmann::json;

// The coefficients under `key`; nothing where there are none.
std::vector<double> coefficients(JsonFields& data, const char* key, std::size_t count) {
  return data.has(key) ? data.numbers(key, count) : std::vector<double>();
}

Result<Lens> lens_of(JsonFields& data, const std::string& type) {
  if (type == "pinhole") return Lens{};
  if (type == "pinhole_radial_k1") {
    const std::vector<double> k = data.numbers("disto_k1", 1);
    return Lens(BrownConrady{.k1 = k[0]});
  }
  if (type == "pinhole_radial_k3") {
    const std::vector<double> k = data.numbers("disto_k3", 3);
    return Lens(BrownConrady{.k1 = k[0], .k2 = k[1], .k3 = k[2]});
  }
  if (type == "pinhole_brown_t2") {
    const std::vector<double> k = data.numbers("disto_t2", 5);
    return Lens(BrownConrady{k[0], k[1], k[3], k[4], k[2]});
  }
  if (type == "fisheye") {
    const std::vector<double> k = coefficients(data, data.has("fisheye") ? "fisheye" : "disto_fisheye4", 4);
    if (k.size() == 4) return Lens(KannalaBrandt{k[0], k[1], k[2], k[3]});
    return fail(ErrorCode::BadData, "a fisheye without its four coefficients");
  }
  return fail(ErrorCode::Unsupported, text("the camera type '", type,
                                           "' is not supported; there are pinhole, pinhole_radial_k1, "
                                           "pinhole_radial_k3, pinhole_brown_t2, fisheye"));
}

// A number of the archive, which are unsigned and of 32 bits; what is none of them is that of nothing.
std::uint32_t id_of(double number) {
  constexpr std::uint32_t kNothing = 0xffffffffU;
  return number >= 0 && number <= kNothing ? static_cast<std::uint32_t>(number) : kNothing;
}

// OpenMVG writes a type's name once, where its number is first used.
class TypeNames {
 public:
  std::string of(JsonFields& value) {
    constexpr std::uint32_t kFirst = 0x80000000U;
    const std::uint32_t id = id_of(value.number("polymorphic_id", 0));
    if (value.has("polymorphic_name")) return names_[id & ~kFirst] = value.string("polymorphic_name");
    const auto found = names_.find(id & ~kFirst);
    return found == names_.end() ? std::string() : found->second;
  }

 private:
  std::map<std::uint32_t, std::string> names_;
};

// What lies under "value" / "ptr_wrapper" / "data", or under "value" itself.
const Json* data_of(JsonFields& entry, JsonProblem& problem, const std::string& where) {
  const Json* value = entry.child("value");
  for (const char* key : {"ptr_wrapper", "data"}) {
    if (!value || !value->is_object()) break;
    if (value->contains(key)) value = &(*value)[key];
  }
  if (!value || !value->is_object()) problem.note(where, "its value is no object");
  return problem.first ? nullptr : value;
}

Result<std::map<std::uint32_t, CameraModel>> intrinsics_of(JsonFields& file, const std::string& name,
                                                           JsonProblem& problem) {
  std::map<std::uint32_t, CameraModel> models;
  TypeNames types;
  const Json* const list = file.list("intrinsics");
  for (std::size_t i = 0; list && !problem.first && i < list->size(); ++i) {
    const std::string where = text(name, ": intrinsic ", i);
    JsonFields entry((*list)[i], where, problem);
    const std::uint32_t key = id_of(entry.number("key"));
    const Json* const value = entry.child("value");
    if (problem.first) break;
    JsonFields typed(*value, where, problem);
    const std::string type = types.of(typed);
    const Json* const found = data_of(entry, problem, where);
    if (!found) break;
    // Distorted cameras hold a plain one in older files, beside their own numbers in newer.
    JsonFields data(found->contains("value0") && (*found)["value0"].is_object() ? (*found)["value0"] : *found,
                    where, problem);
    JsonFields own(*found, where, problem);
    CameraModel model;
    model.width = data.integer("width");
    model.height = data.integer("height");
    const double f = data.number("focal_length");
    const std::vector<double> center = data.numbers("principal_point", 2);
    if (problem.first) break;
    Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
    k(0, 0) = k(1, 1) = f;
    k(0, 2) = center[0];
    k(1, 2) = center[1];
    if (Result<void> ok = set_k(model, k, PixelOrigin::FirstPixelCenter); !ok)
      return fail(ok.error().code, text(where, ": ", ok.error().message));
    const Result<Lens> lens = lens_of(own, type);
    if (problem.first) break;
    if (!lens) return fail(lens.error().code, text(where, ": ", lens.error().message));
    model.lens = *lens;
    if (!models.emplace(key, model).second) problem.note(where, text("its key ", key, " is here twice"));
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return models;
}

Result<std::map<std::uint32_t, Rigid3>> poses_of(JsonFields& file, const std::string& name,
                                                 JsonProblem& problem) {
  std::map<std::uint32_t, Rigid3> poses;
  const Json* const list = file.list("extrinsics");
  for (std::size_t i = 0; list && !problem.first && i < list->size(); ++i) {
    const std::string where = text(name, ": extrinsic ", i);
    JsonFields entry((*list)[i], where, problem);
    const std::uint32_t key = id_of(entry.number("key"));
    const Json* const value = entry.child("value");
    if (problem.first) break;
    JsonFields pose(*value, where, problem);
    const std::vector<double> r = pose.numbers("rotation", 9), c = pose.numbers("center", 3);
    if (problem.first) break;
    Eigen::Matrix3d matrix;
    for (int k = 0; k < 9; ++k) matrix(k / 3, k % 3) = r[static_cast<std::size_t>(k)];
    const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(matrix);
    if (!rotation) return fail(rotation.error().code, text(where, ": ", rotation.error().message));
    if (!poses.emplace(key, Rigid3{*rotation, *rotation * -Eigen::Vector3d(c[0], c[1], c[2])}).second)
      problem.note(where, text("its key ", key, " is here twice"));
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return poses;
}

}  // namespace

Result<ForeignRig> parse_openmvg(std::string_view content, std::string_view name_given) {
  const std::string name(name_given);
  const Result<Json> root = parse_json(content, name);
  if (!root) return forward(root);
  JsonProblem problem;
  JsonFields file(*root, name, problem);
  // 0.1 to 0.3 are alike in what is read here.
  const std::string version = file.has("sfm_data_version") ? file.string("sfm_data_version") : "0.1";
  if (!problem.first && !version.starts_with("0."))
    return fail(ErrorCode::Unsupported,
                text(name, ": sfm_data_version ", version,
                     " is not known here; let OpenMVG write 0.3 (openMVG_main_ConvertSfM_DataFormat)"));
  const Result<std::map<std::uint32_t, CameraModel>> models = intrinsics_of(file, name, problem);
  if (!models) return forward(models);
  const Result<std::map<std::uint32_t, Rigid3>> poses = poses_of(file, name, problem);
  if (!poses) return forward(poses);
  ForeignRig foreign;
  const Json* const views = file.list("views");
  for (std::size_t i = 0; views && !problem.first && i < views->size(); ++i) {
    const std::string where = text(name, ": view ", i);
    JsonFields entry((*views)[i], where, problem);
    const Json* const found = data_of(entry, problem, where);
    if (!found) break;
    JsonFields data(*found, where, problem);
    const std::string picture = data.string("filename");
    const double intrinsic = data.number("id_intrinsic"), pose = data.number("id_pose");
    if (problem.first) break;
    const auto at = poses->find(id_of(pose));
    if (at == poses->end()) continue;  // a view that OpenMVG could not place
    const auto model = models->find(id_of(intrinsic));
    if (model == models->end())
      return fail(ErrorCode::BadData, text(where, ": names intrinsic ", intrinsic, ", which is not there"));
    const std::string file_name = std::filesystem::path(picture).filename().string();
    foreign.rig.cameras.push_back({serial_from_name(file_name), model->second, at->second, {}});
    foreign.image_names.push_back(picture);
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_openmvg(const std::filesystem::path& file) {
  const Result<std::string> content = read_file(file);
  if (!content) return forward(content);
  return parse_openmvg(*content, file.string());
}

}  // namespace floatstage::calib
