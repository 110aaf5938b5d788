#include "capture/time_offsets.h"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr double kLargest = 60e9;  // ns: nobody's cameras are a minute apart

CameraTimeOffset read_camera(const nlohmann::json& value, const std::string& name, JsonProblem& problem) {
  JsonFields fields(value, text(name, ": a camera"), problem);
  CameraTimeOffset out;
  out.serial = fields.string("serial");
  const auto time = [&](const char* key) {
    const double ns = fields.number(key);
    if (!(std::abs(ns) <= kLargest)) problem.note(fields.where(), text(key, " is more than a minute"));
    return Nanoseconds{std::abs(ns) <= kLargest ? std::llround(ns) : 0};
  };
  if (fields.has("not_measured")) {
    out.not_measured = fields.string("not_measured");
  } else {
    out.offset = time("offset_ns");
    out.sigma = time("sigma_ns");
    if (out.sigma->count < 0) problem.note(fields.where(), "sigma_ns is negative");
  }
  fields.refuse_others();
  return out;
}

}  // namespace

std::filesystem::path times_file(const TakeLayout& take) { return take.folder() / "times.json"; }

std::string to_json(const TimeOffsetFile& times) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const CameraTimeOffset& c : times.cameras) {
    if (c.offset) {
      cameras.push_back(
          {{"serial", c.serial}, {"offset_ns", c.offset->count}, {"sigma_ns", c.sigma ? c.sigma->count : 0}});
    } else {
      cameras.push_back({{"serial", c.serial}, {"not_measured", c.not_measured}});
    }
  }
  return print_json({{"floatstage_times", 1}, {"from", times.from}, {"cameras", cameras}});
}

Result<TimeOffsetFile> parse_time_offsets(std::string_view json, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(json, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  TimeOffsetFile out;
  const int version = fields.integer("floatstage_times");
  if (!problem.first && version != 1)
    return fail(ErrorCode::Unsupported, text(name, ": format ", version, " of times is not known; 1 is"));
  out.from = fields.string("from");
  if (const nlohmann::json* cameras = fields.list("cameras"))
    for (const nlohmann::json& camera : *cameras)
      out.cameras.push_back(read_camera(camera, std::string(name), problem));
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return out;
}

Result<TimeOffsetFile> load_time_offsets(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_time_offsets(*bytes, file.string());
}

Result<TimeOffsetFile> load_time_offsets(const TakeLayout& take) {
  const std::filesystem::path file = times_file(take);
  return is_there(file) ? load_time_offsets(file) : TimeOffsetFile{};
}

Result<void> save_time_offsets(const TimeOffsetFile& times, const std::filesystem::path& file) {
  return write_file(file, to_json(times));
}

std::vector<Nanoseconds> offsets_of(const TimeOffsetFile& times, const std::vector<std::string>& serials) {
  std::vector<Nanoseconds> out(serials.size(), Nanoseconds{0});
  for (std::size_t i = 0; i < serials.size(); ++i)
    for (const CameraTimeOffset& c : times.cameras)
      if (c.serial == serials[i] && c.offset) out[i] = *c.offset;
  return out;
}

std::vector<Nanoseconds> offsets_of(const TimeOffsetFile& times, const Rig& rig) {
  std::vector<std::string> serials;
  for (const RigCamera& camera : rig.cameras) serials.push_back(camera.serial);
  return offsets_of(times, serials);
}

}  // namespace floatstage::capture
