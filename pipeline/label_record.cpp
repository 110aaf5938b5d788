#include "pipeline/label_record.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;

int frame_of(const std::string& name) {
  std::size_t end = 0;
  const int frame = std::stoi(name, &end);
  if (end != name.size() || frame < 0) throw std::invalid_argument("'" + name + "' is no frame");
  return frame;
}

int frame_of(const json& number) {
  const int frame = number.get<int>();
  if (frame < 0) throw std::invalid_argument("a frame before the first");
  return frame;
}

// Serials and labels become folders' names.
std::string serial_of(const std::string& serial) {
  if (!is_usable_serial(serial)) throw std::invalid_argument("'" + serial + "' cannot be a serial");
  return serial;
}

std::string label_of(const std::string& label) {
  if (!is_usable_label(label)) throw std::invalid_argument("'" + label + "' cannot be a label");
  return label;
}

LabelRecord::Hashes hashes_of(const json& j) {
  LabelRecord::Hashes hashes;
  for (const auto& [serial, frames] : j.items())
    for (const auto& [frame, hash] : frames.items())
      hashes[serial_of(serial)][frame_of(frame)] = hash.get<std::string>();
  return hashes;
}

json to_json(const LabelRecord::Hashes& hashes) {
  json j = json::object();
  for (const auto& [serial, frames] : hashes)
    for (const auto& [frame, hash] : frames) j[serial][std::to_string(frame)] = hash;
  return j;
}

LabelClick click_of(const json& j) {
  LabelClick click{label_of(j.at("label")), serial_of(j.at("camera")), frame_of(j.at("frame")),
                   j.at("at").at(0), j.at("at").at(1)};
  if (!std::isfinite(click.x) || !std::isfinite(click.y)) throw std::invalid_argument("a click nowhere");
  return click;
}

LabelDoubt doubt_of(const json& j) {
  LabelDoubt doubt{j.at("why"), serial_of(j.at("camera")), frame_of(j.at("frame")), j.at("frames").get<int>(),
                   j.value("picture", "")};
  if (doubt.picture.find('/') != std::string::npos) throw std::invalid_argument("a picture elsewhere");
  return doubt;
}

std::vector<std::string> labels_of(const json& names) {
  std::vector<std::string> labels;
  for (const json& name : names) {
    const std::string label = label_of(name);
    if (std::find(labels.begin(), labels.end(), label) != labels.end())
      throw std::invalid_argument("label '" + label + "' twice");
    labels.push_back(label);
  }
  return labels;
}

LabelRecord record_of(const json& j) {
  LabelRecord record;
  record.labels = labels_of(j.at("labels"));
  record.drawn = labels_of(j.value("drawn", json::array()));
  for (const json& click : j.at("clicks")) record.clicks.push_back(click_of(click));
  record.inputs = j.at("inputs").get<std::string>();
  record.sums = hashes_of(j.at("sums"));
  for (const auto& [label, files] : j.at("files").items()) record.files[label_of(label)] = hashes_of(files);
  for (const json& doubt : j.at("doubts")) record.doubts.push_back(doubt_of(doubt));
  return record;
}

}  // namespace

Result<LabelRecord> load_label_record(const TakeLayout& layout) {
  const std::string name = layout.label_record().string();
  const Result<std::string> bytes = read_file(name);
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return LabelRecord();
  if (!bytes) return forward(bytes);
  const auto bad = [&](const std::string& why) {
    return fail(ErrorCode::BadData, text(name, " does not say how the labels were made (", why,
                                         "); remove it, and give the labels again"));
  };
  const Result<json> parsed = parse_json(*bytes, name);
  if (!parsed) return bad(parsed.error().message);
  try {
    if (const int version = parsed->at("floatstage_labels"); version != kVersion)
      return fail(ErrorCode::Unsupported, text(name, ": record format ", version, " is not known here"));
    return record_of(*parsed);
  } catch (const std::exception& e) {  // JSON's and stoi's
    return bad(e.what());
  }
}

Result<void> save_label_record(const LabelRecord& record, const TakeLayout& layout) {
  json clicks = json::array(), files = json::object(), doubts = json::array();
  for (const LabelClick& c : record.clicks)
    clicks.push_back({{"label", c.label}, {"camera", c.serial}, {"frame", c.frame}, {"at", {c.x, c.y}}});
  for (const auto& [label, hashes] : record.files) files[label] = to_json(hashes);
  for (const LabelDoubt& d : record.doubts)
    doubts.push_back({{"why", d.why},
                      {"camera", d.serial},
                      {"frame", d.frame},
                      {"frames", d.frames},
                      {"picture", d.picture}});
  json whole = {{"floatstage_labels", kVersion},
                {"labels", record.labels},
                {"clicks", clicks},
                {"inputs", record.inputs},
                {"sums", to_json(record.sums)},
                {"files", files},
                {"doubts", doubts}};
  if (!record.drawn.empty()) whole["drawn"] = record.drawn;
  return write_file(layout.label_record(), whole.dump(1) + "\n");
}

Result<TakeLayout> choose_labels(const TakeLayout& layout, const std::vector<std::string>& only,
                                 const std::vector<std::string>& without) {
  if (only.empty() && without.empty()) return layout;
  if (!only.empty() && !without.empty())
    return fail(ErrorCode::InvalidArgument, "give the labels that stay or those that go, not both");
  const Result<LabelRecord> record = load_label_record(layout);
  if (!record) return forward(record);
  std::string known;
  for (const std::string& label : record->labels) known += text(known.empty() ? "" : ", ", label);
  for (const std::string& label : only.empty() ? without : only)
    if (std::find(record->labels.begin(), record->labels.end(), label) == record->labels.end())
      return fail(ErrorCode::NotFound,
                  text(layout.folder().string(), " has no label '", label, "'; it has ",
                       known.empty() ? "none; give them with `floatstage matte --label`" : known));
  std::vector<std::string> chosen;
  for (const std::string& label : record->labels) {
    const auto in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), label) != list.end();
    };
    if (only.empty() ? !in(without) : in(only)) chosen.push_back(label);
  }
  if (chosen.empty())
    return fail(ErrorCode::InvalidArgument,
                text("without ", known, " nobody is left in ", layout.folder().string()));
  return layout.with_labels(std::move(chosen));
}

}  // namespace floatstage::pipeline
