#include "studio/node/capture_config.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <toml++/toml.h>

#include "capture/time_offsets.h"
#include "core/file.h"
#include "core/log.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

namespace fs = std::filesystem;

// One table of the file: each key is read once and checked; what nobody asked for is an error.
class Section {
 public:
  Section(const toml::table* table, std::string title, std::optional<std::string>& problem)
      : table_(table), title_(std::move(title)), problem_(problem) {}

  std::string text_of(const char* key, std::string otherwise) {
    const toml::node* node = take(key);
    if (!node) return otherwise;
    const std::optional<std::string> value = node->value_exact<std::string>();
    if (!value) note(node, text(key, " must be a text in quotes"));
    return value.value_or(otherwise);
  }
  std::vector<std::string> texts(const char* key) {
    std::vector<std::string> all;
    const toml::node* node = take(key);
    if (!node) return all;
    const toml::array* list = node->as_array();
    for (std::size_t i = 0; list && i < list->size(); ++i)
      if (const std::optional<std::string> value = list->get(i)->value_exact<std::string>())
        all.push_back(*value);
    if (!list || all.size() != list->size()) note(node, text(key, " must be a list of texts in quotes"));
    return all;
  }
  double number(const char* key, double otherwise, double low, double high) {
    const toml::node* node = take(key);
    if (!node) return otherwise;
    const std::optional<double> value = node->value<double>();
    if (!value || !(*value >= low && *value <= high))
      note(node, text(key, " must be a number from ", low, " to ", high));
    return value.value_or(otherwise);
  }
  std::uint64_t whole(const char* key, std::uint64_t otherwise, std::int64_t low, std::int64_t high) {
    const toml::node* node = take(key);
    if (!node) return otherwise;
    const std::optional<std::int64_t> value = node->value_exact<std::int64_t>();
    if (!value || *value < low || *value > high)
      note(node, text(key, " must be a whole number from ", low, " to ", high));
    return static_cast<std::uint64_t>(value.value_or(static_cast<std::int64_t>(otherwise)));
  }
  void note(const toml::node* node, const std::string& what) {
    if (problem_) return;
    problem_ =
        node ? text("line ", node->source().begin.line, ": ", title_, ": ", what) : text(title_, ": ", what);
  }
  const toml::node* at(const char* key) const { return table_ ? table_->get(key) : nullptr; }
  void finish() {
    if (!table_) return;
    for (const auto& [key, node] : *table_) {
      const std::string name(key.str());
      if (!asked_.contains(name))
        note(&node, text("'", name, "' is not understood; there are ", understood_));
    }
  }

 private:
  const toml::node* take(const char* key) {
    asked_.insert(key);
    understood_ += text(understood_.empty() ? "" : ", ", key);
    return at(key);
  }

  const toml::table* table_;
  std::string title_;
  std::optional<std::string>& problem_;
  std::set<std::string> asked_;
  std::string understood_;
};

void read_studio(Section section, CaptureConfig& config, const fs::path& base) {
  config.frame_rate = section.number("frame_rate", 0, 0.1, 10'000);
  if (const std::string rig = section.text_of("rig", ""); !rig.empty()) config.rig = base / rig;
  if (const std::string times = section.text_of("times", ""); !times.empty()) config.times = base / times;
  if (const std::string file = section.text_of("presets", ""); !file.empty()) config.presets = base / file;
  config.name = section.text_of("name", config.name);
  section.finish();
  if (!section.at("frame_rate")) section.note(nullptr, "frame_rate is missing");
}

void read_recording(Section section, CaptureConfig& config, const fs::path& base) {
  capture::TakeWriterOptions& take = config.recorder.take;
  config.folder = base / section.text_of("folder", "takes");
  take.label = section.text_of("label", "take");
  const std::string codec = section.text_of("codec", "ffv1");
  if (codec == "ffv1")
    take.codec = capture::TakeCodec::Ffv1;
  else if (codec == "raw")
    take.codec = capture::TakeCodec::Raw;
  else if (codec == "h264")
    take.codec = capture::TakeCodec::H264;
  else
    section.note(section.at("codec"), "codec must be ffv1, raw or h264");
  if (!is_usable_serial(take.label))
    section.note(section.at("label"), "label must be of letters, digits, '.', '_' and '-'");
  config.recorder.queue_frames = section.whole("queue_frames", config.recorder.queue_frames, 1, 100'000);
  config.recorder.sync_seconds = section.number("sync_seconds", 0, 0, 3600);
  config.preroll_seconds = section.number("preroll_seconds", 0, 0, 60);
  config.keep_free_bytes =
      section.whole("keep_free_mb", config.keep_free_bytes / 1'000'000, 0, 1'000'000'000) * 1'000'000;
  const std::string disagreement = section.text_of("disagreement", "warn");
  config.refuse_disagreement = disagreement == "refuse";
  if (disagreement != "refuse" && disagreement != "warn")
    section.note(section.at("disagreement"), "disagreement must be warn or refuse");
  section.finish();
}

void read_web(Section section, CaptureConfig& config, const fs::path& base) {
  PageSettings web;
  web.port = static_cast<int>(section.whole("port", static_cast<std::uint64_t>(web.port), 0, 65535));
  web.address = section.text_of("address", web.address);
  if (const std::string file = section.text_of("token_file", ""); !file.empty()) web.token_file = base / file;
  web.names = section.texts("names");
  section.finish();
  config.web = std::move(web);
}

void read_publish(Section section, CaptureConfig& config, const fs::path& base) {
  CaptureConfig::Publish publish;
  publish.address = section.text_of("address", publish.address);
  publish.control = section.text_of("control", publish.control);
  if (const std::string keys = section.text_of("keys", ""); !keys.empty()) publish.keys = base / keys;
  publish.key = section.text_of("key", publish.key);
  if (const std::string plates = section.text_of("plates", ""); !plates.empty())
    publish.plates = base / plates;
  publish.shrink =
      static_cast<int>(section.whole("shrink", static_cast<std::uint64_t>(publish.shrink), 1, 16));
  const std::string tiles = section.text_of("tiles", "jpeg");
  publish.raw_tiles = tiles == "raw";
  if (tiles != "jpeg" && tiles != "raw") section.note(section.at("tiles"), "tiles must be jpeg or raw");
  publish.jpeg_quality = static_cast<int>(
      section.whole("jpeg_quality", static_cast<std::uint64_t>(publish.jpeg_quality), 1, 100));
  section.finish();
  if (config.rig.empty())
    section.note(nullptr, "outlines mean nothing without a calibration; name the rig in [studio]");
  config.publish = std::move(publish);
}

void read_limits(Section section, capture::RecordingLimits& limits) {
  limits.skips = section.whole("skips", limits.skips, 0, 1'000'000'000);
  limits.duplicates = section.whole("duplicates", limits.duplicates, 0, 1'000'000'000);
  limits.spread_ms = section.number("spread_ms", limits.spread_ms, 0, 1e6);
  limits.rate_deviation = section.number("rate_deviation", limits.rate_deviation, 0, 1);
  section.finish();
}

void read_camera(Section section, CaptureConfig& config) {
  CaptureConfig::Camera camera;
  camera.serial = section.text_of("serial", "");
  camera.source = section.text_of("source", "");
  if (!is_usable_serial(camera.serial))
    section.note(section.at("serial"), "serial must be of letters, digits, '.', '_' and '-'");
  if (camera.source.empty())
    section.note(section.at("source"), "source is missing, for example \"v4l2:/dev/video0\"");
  for (const CaptureConfig::Camera& other : config.cameras)
    if (other.serial == camera.serial)
      section.note(section.at("serial"), text("serial '", camera.serial, "' is there twice"));
  section.finish();
  config.cameras.push_back(std::move(camera));
}

void read_sound(Section section, CaptureConfig& config) {
  const std::string source = section.text_of("source", "");
  if (source.empty()) section.note(section.at("source"), "source is missing, for example \"alsa:default\"");
  for (const std::string& other : config.sounds)
    if (other == source) section.note(section.at("source"), text("source '", source, "' is there twice"));
  section.finish();
  config.sounds.push_back(source);
}

}  // namespace

Result<CaptureConfig> parse_capture_config(std::string_view bytes, std::string_view name,
                                           const fs::path& base) {
  const auto bad = [&](const std::string& what) { return fail(ErrorCode::BadData, text(name, ": ", what)); };
  toml::table root;
  try {
    root = toml::parse(bytes);
  } catch (const toml::parse_error& error) {
    return bad(text("line ", error.source().begin.line, ": no TOML: ", error.description()));
  }
  std::optional<std::string> problem;
  CaptureConfig config;
  read_studio({root["studio"].as_table(), "[studio]", problem}, config, base);
  read_recording({root["recording"].as_table(), "[recording]", problem}, config, base);
  read_limits({root["limits"].as_table(), "[limits]", problem}, config.recorder.limits);
  if (root.contains("web")) read_web({root["web"].as_table(), "[web]", problem}, config, base);
  if (root.contains("publish"))
    read_publish({root["publish"].as_table(), "[publish]", problem}, config, base);
  config.recorder.take.frame_rate = config.frame_rate;
  if (const toml::array* cameras = root["camera"].as_array()) {
    for (const toml::node& camera : *cameras) {
      if (!camera.is_table()) return bad("each camera is a [[camera]] table");
      read_camera({camera.as_table(), text("[[camera]] ", config.cameras.size() + 1), problem}, config);
    }
  }
  if (const toml::array* sounds = root["sound"].as_array()) {
    for (const toml::node& sound : *sounds) {
      if (!sound.is_table()) return bad("each source of sound is a [[sound]] table");
      read_sound({sound.as_table(), text("[[sound]] ", config.sounds.size() + 1), problem}, config);
    }
  }
  for (const auto& [key, node] : root) {
    const std::string title(key.str());
    const bool known = title == "studio" || title == "recording" || title == "limits" || title == "web" ||
                       title == "publish";
    if (title == "camera" || title == "sound" ? !node.is_array() : !known || !node.is_table())
      return bad(text("line ", node.source().begin.line, ": '", title,
                      "' is not understood; there are [studio], [recording], [limits], [web], [publish], "
                      "[[camera]] and [[sound]]"));
  }
  if (problem) return bad(*problem);
  if (config.cameras.empty()) return bad("it names no [[camera]]");
  return config;
}

Result<CaptureConfig> load_capture_config(const fs::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  Result<CaptureConfig> config = parse_capture_config(*bytes, file.string(), file.parent_path());
  if (config && config->presets.empty()) config->presets = fs::path(file).replace_extension(".presets.toml");
  return config;
}

Result<capture::TimeOffsetFile> load_times(const CaptureConfig& config) {
  if (config.times.empty()) return capture::TimeOffsetFile{};
  Result<capture::TimeOffsetFile> times = capture::load_time_offsets(config.times);
  if (!times) return times;
  for (const CaptureConfig::Camera& camera : config.cameras) {
    const bool known = std::any_of(times->cameras.begin(), times->cameras.end(),
                                   [&](const auto& c) { return c.serial == camera.serial && c.offset; });
    if (!known)
      log::warning(text(config.times.string(), " has no time offset of camera '", camera.serial,
                        "': its stamps are taken as they are"));
  }
  return times;
}

}  // namespace floatstage::studio
