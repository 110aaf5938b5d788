#include "capture/added_file.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr int kLargest = 1 << 20;   // px: beyond any picture
constexpr std::size_t kMost = 256;  // overlays of a camera

// Four whole numbers.
std::vector<int> four(const std::vector<double>& numbers, const std::string& where, JsonProblem& problem) {
  std::vector<int> out;
  for (const double n : numbers) {
    const bool sound = n >= 0 && n <= kLargest && n == static_cast<int>(n);
    if (!sound) problem.note(where, "pixels are whole numbers, and none is negative");
    out.push_back(sound ? static_cast<int>(n) : 0);
  }
  return out;
}

AddedContent read_camera(JsonFields& fields, JsonProblem& problem) {
  AddedContent added;
  const std::vector<int> bars = four(fields.numbers("bars", 4), fields.where(), problem);
  added.left = bars[0], added.top = bars[1], added.right = bars[2], added.bottom = bars[3];
  const nlohmann::json* overlays = fields.list("overlays");
  if (!overlays) return added;
  if (overlays->size() > kMost) problem.note(fields.where(), text("more than ", kMost, " overlays"));
  for (const nlohmann::json& overlay : *overlays) {
    std::vector<double> numbers;
    for (const nlohmann::json& n : overlay)
      if (n.is_number()) numbers.push_back(n.get<double>());
    if (!overlay.is_array() || overlay.size() != 4 || numbers.size() != 4) {
      problem.note(fields.where(), "an overlay is [x, y, width, height]");
      break;
    }
    const std::vector<int> box = four(numbers, fields.where(), problem);
    added.overlays.push_back({box[0], box[1], box[2], box[3]});
  }
  return added;
}

}  // namespace

AddedContent AddedFile::of(const std::string& serial) const {
  const auto found = cameras.find(serial);
  return hidden && found != cameras.end() ? found->second : AddedContent();
}

std::filesystem::path added_file(const TakeLayout& take) { return take.folder() / "added.json"; }

std::string to_json(const AddedFile& added) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const auto& [serial, a] : added.cameras) {
    nlohmann::ordered_json overlays = nlohmann::ordered_json::array();
    for (const PixelBox& b : a.overlays) overlays.push_back({b.x, b.y, b.width, b.height});
    cameras.push_back(
        {{"serial", serial}, {"bars", {a.left, a.top, a.right, a.bottom}}, {"overlays", overlays}});
  }
  return print_json({{"floatstage_added", 1}, {"hidden", added.hidden}, {"cameras", cameras}});
}

Result<AddedFile> parse_added(std::string_view json, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(json, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  AddedFile out;
  const int version = fields.integer("floatstage_added");
  if (!problem.first && version != 1)
    return fail(ErrorCode::Unsupported, text(name, ": format ", version, " is not known; 1 is"));
  out.hidden = fields.boolean("hidden");
  if (const nlohmann::json* cameras = fields.list("cameras"))
    for (const nlohmann::json& camera : *cameras) {
      JsonFields one(camera, text(name, ": a camera"), problem);
      const std::string serial = one.string("serial");
      const AddedContent added = read_camera(one, problem);
      one.refuse_others();
      if (!out.cameras.emplace(serial, added).second)
        problem.note(std::string(name), text("camera '", serial, "' is in it twice"));
    }
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return out;
}

Result<AddedFile> load_added(const TakeLayout& take) {
  const std::filesystem::path file = added_file(take);
  if (!is_there(file)) return AddedFile{};
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_added(*bytes, file.string());
}

Result<void> save_added(const AddedFile& added, const TakeLayout& take) {
  return write_file(added_file(take), to_json(added));
}

}  // namespace floatstage::capture
