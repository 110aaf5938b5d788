#include "core/take_layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "core/json_fields.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

std::string frame_name(int frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof name, "%06d%s", frame, extension);
  return name;
}

// The frame that a file is named after; nothing where frame_name() would call it otherwise.
std::optional<int> frame_named(const std::string& name, const char* extension) {
  int frame = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), frame);
  if (error != std::errc() || frame < 0 || name != frame_name(frame, extension)) return std::nullopt;
  return frame;
}

std::vector<int> frames_in(const std::filesystem::path& folder, const char* extension) {
  std::vector<int> frames;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (const std::optional<int> frame = frame_named(entry->path().filename().string(), extension))
      frames.push_back(*frame);
  std::sort(frames.begin(), frames.end());
  return frames;
}

// Media names come from a file: they must not lead out of the take.
bool plain_file_name(const std::string& s) {
  return !s.empty() && s != "." && s != ".." && s.find('/') == std::string::npos;
}

bool sha256_in_hex(const std::string& s) {
  return s.size() == 64 && std::all_of(s.begin(), s.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

TakeManifest::Camera read_camera(const nlohmann::json& value, const std::string& where,
                                 JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  TakeManifest::Camera c;
  c.serial = fields.string("serial");
  c.media = fields.string("media");
  c.codec = fields.string("codec");
  const std::string format = fields.string("format");
  c.width = fields.integer("width");
  c.height = fields.integer("height");
  fields.refuse_others();
  if (const std::optional<PixelFormat> known = pixel_format_named(format))
    c.format = *known;
  else
    problem.note(where, text("unknown pixel format '", format, "'"));
  if (!is_usable_serial(c.serial)) problem.note(where, text("'", c.serial, "' cannot be a camera serial"));
  if (!plain_file_name(c.media))
    problem.note(where, text("'", c.media, "' is not the name of a file inside the take"));
  if (c.width < 0 || c.height < 0)
    problem.note(where, text("image size ", c.width, "x", c.height, " is negative"));
  return c;
}

TakeManifest::File read_file_entry(const nlohmann::json& value, const std::string& where,
                                   JsonProblem& problem) {
  JsonFields fields(value, where, problem);
  TakeManifest::File file;
  file.name = fields.string("name");
  const double bytes = fields.number("bytes");
  file.sha256 = fields.string("sha256");
  fields.refuse_others();
  if (!plain_file_name(file.name))
    problem.note(where, text("'", file.name, "' is not the name of a file inside the take"));
  if (!(bytes >= 0 && bytes < 9e15 && bytes == std::floor(bytes)))
    problem.note(where, "'bytes' is not the size of a file");
  else
    file.bytes = static_cast<std::uint64_t>(bytes);
  if (!sha256_in_hex(file.sha256)) problem.note(where, "'sha256' is not 64 lower-case hexadecimal digits");
  return file;
}

}  // namespace

std::filesystem::path TakeLayout::matte(std::string_view serial, int frame) const {
  return mattes() / serial / frame_name(frame, ".png");
}

std::filesystem::path TakeLayout::label_matte(std::string_view serial, std::string_view label,
                                              int frame) const {
  return mattes() / serial / label / frame_name(frame, ".png");
}

TakeLayout TakeLayout::with_labels(std::vector<std::string> labels) const {
  TakeLayout layout = *this;
  layout.labels_ = std::move(labels);
  return layout;
}

std::vector<std::filesystem::path> TakeLayout::matte_files(std::string_view serial, int frame) const {
  if (labels_.empty()) return {matte(serial, frame)};
  std::vector<std::filesystem::path> files;
  for (const std::string& label : labels_) files.push_back(label_matte(serial, label, frame));
  return files;
}

std::filesystem::path TakeLayout::meshes() const {
  if (labels_.empty()) return folder_ / "meshes";
  std::string name;
  for (const std::string& label : labels_) name += (name.empty() ? "" : "+") + label;
  return folder_ / "meshes" / "labels" / name;
}

bool is_usable_label(std::string_view name) {
  constexpr std::size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

std::filesystem::path TakeLayout::mesh(int frame) const { return meshes() / frame_name(frame, ".ply"); }

std::vector<int> TakeLayout::frames_with_mattes(std::string_view serial) const {
  return frames_in(mattes() / serial, ".png");
}

std::vector<int> TakeLayout::frames_with_meshes() const { return frames_in(meshes(), ".ply"); }

Result<TakeManifest> parse_manifest(std::string_view bytes, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(bytes, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  TakeManifest m;
  m.version = fields.integer("floatstage_take");
  if (!problem.first && m.version != kVersion)
    return fail(ErrorCode::Unsupported, text(name, ": take format ", m.version,
                                             " is not known here; this program reads format ", kVersion));
  m.label = fields.string("label");
  m.created = fields.string("created");
  m.writer = fields.string("writer");
  m.frame_rate = fields.number("frame_rate");
  m.rig_sha256 = fields.string("rig_sha256");
  m.complete = fields.boolean("complete");
  if (const nlohmann::json* cameras = fields.list("cameras"))
    for (const nlohmann::json& camera : *cameras)
      m.cameras.push_back(read_camera(camera, text(name, ": camera ", m.cameras.size()), problem));
  if (fields.has("files"))
    if (const nlohmann::json* files = fields.list("files"))
      for (const nlohmann::json& file : *files)
        m.files.push_back(read_file_entry(file, text(name, ": file ", m.files.size()), problem));
  fields.refuse_others();

  const std::string where(name);
  if (!(m.frame_rate >= 0)) problem.note(where, "'frame_rate' is negative");
  if (!sha256_in_hex(m.rig_sha256))
    problem.note(where, "'rig_sha256' is not 64 lower-case hexadecimal digits");
  if (m.cameras.empty()) problem.note(where, "the take has no camera");
  std::set<std::string> serials, media;
  for (const TakeManifest::Camera& c : m.cameras)
    if (!serials.insert(c.serial).second || !media.insert(c.media).second)
      problem.note(where, text("camera '", c.serial, "' or its media file is listed twice"));
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return m;
}

std::string to_json(const TakeManifest& m) {
  Json cameras = Json::array();
  for (const TakeManifest::Camera& c : m.cameras)
    cameras.push_back({{"serial", c.serial},
                       {"media", c.media},
                       {"codec", c.codec},
                       {"format", name_of(c.format)},
                       {"width", c.width},
                       {"height", c.height}});
  Json whole = {{"floatstage_take", m.version}, {"label", m.label},
                {"created", m.created},         {"writer", m.writer},
                {"frame_rate", m.frame_rate},   {"rig_sha256", m.rig_sha256},
                {"complete", m.complete},       {"cameras", std::move(cameras)}};
  for (const TakeManifest::File& file : m.files)
    whole["files"].push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return print_json(whole);
}

}  // namespace floatstage
