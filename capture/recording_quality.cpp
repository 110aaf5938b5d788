#include "capture/recording_quality.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::capture {

QualityMeter::QualityMeter(std::vector<std::string> serials, double frame_rate, RecordingLimits limits)
    : frame_rate_(frame_rate), limits_(limits) {
  for (std::string& serial : serials) {
    cameras_.emplace_back();
    cameras_.back().quality.serial = std::move(serial);
  }
}

void QualityMeter::recorded(int camera, std::uint64_t row, const FrameInfo& info,
                            std::optional<std::uint64_t> counted) {
  Camera& c = cameras_[static_cast<std::size_t>(camera)];
  const Timestamp time = info.exposure_start;
  if (!c.first) {
    c.first = time;
    c.quality.skips += row;  // rows before its first picture
    c.rows_before_first = row;
  } else {
    const std::uint64_t rows = row - c.last_row;
    c.quality.skips += rows - 1;
    c.skips_between += rows - 1;
    c.quality.lost += std::max<std::uint64_t>(counted.value_or(1), 1) - 1;
    c.counted += counted.value_or(rows);
  }
  c.last = time;
  c.last_row = row;
  ++c.quality.recorded;
  if (info.status == FrameStatus::Corrupt) ++c.quality.corrupt;
  if (instants_.size() <= row) instants_.resize(row + 1);
  std::optional<Instant>& instant = instants_[row];
  if (!instant) instant = Instant{time, time};
  instant->earliest = std::min(instant->earliest, time);
  instant->latest = std::max(instant->latest, time);
}

void QualityMeter::counted_elsewhere(int camera, std::uint64_t pictures) {
  Camera& c = cameras_[static_cast<std::size_t>(camera)];
  c.counted += pictures;
  if (pictures > 1) c.quality.lost += pictures - 1;  // the last of them came
}

RecordingQuality QualityMeter::judge() const {
  RecordingQuality quality;
  for (const Camera& c : cameras_) {
    RecordedCamera& camera = quality.cameras.emplace_back(c.quality);
    camera.unexposed = c.rows_before_first + c.skips_between - std::min(c.skips_between, camera.lost);
    if (c.first && c.last > c.first)
      camera.frame_rate = static_cast<double>(c.counted) / seconds(*c.last - *c.first);
  }
  std::vector<double> spreads;
  for (const std::optional<Instant>& instant : instants_)
    if (instant) spreads.push_back(seconds(instant->latest - instant->earliest) * 1e3);
  if (!spreads.empty()) {
    quality.spread_p50_ms = median(spreads);
    quality.spread_max_ms = percentile(std::move(spreads), 1);
  }
  complain(quality);
  return quality;
}

void QualityMeter::complain(RecordingQuality& quality) const {
  const auto note = [&](const auto&... parts) { quality.complaints.push_back(text(parts...)); };
  for (const RecordedCamera& c : quality.cameras) {
    if (c.recorded == 0) {
      note("camera '", c.serial, "': no picture was recorded; check its cable and its trigger");
      continue;
    }
    if (c.skips > limits_.skips)
      note("camera '", c.serial, "': ", c.skips, " frames are missing, at most ", limits_.skips,
           " are allowed; check its link");
    if (c.duplicates > limits_.duplicates)
      note("camera '", c.serial, "': ", c.duplicates, " frames came twice, at most ", limits_.duplicates,
           " are allowed");
    const double deviation = c.frame_rate > 0 ? c.frame_rate / frame_rate_ - 1 : 0;
    if (std::abs(deviation) > limits_.rate_deviation)
      note("camera '", c.serial, "': ", c.frame_rate, " frames a second instead of ", frame_rate_,
           "; check its exposure time and its trigger");
  }
  if (quality.spread_max_ms > limits_.spread_ms)
    note("the exposures of one instant lie up to ", quality.spread_max_ms, " ms apart, at most ",
         limits_.spread_ms, " ms are allowed; trigger the cameras together");
}

std::string to_json(const RecordingQuality& quality) {
  nlohmann::ordered_json json;
  json["verdict"] = quality.pass() ? "PASS" : "FAIL";
  json["cameras"] = nlohmann::ordered_json::array();
  for (const RecordedCamera& c : quality.cameras) {
    json["cameras"].push_back({{"serial", c.serial},
                               {"recorded", c.recorded},
                               {"skips", c.skips},
                               {"unexposed", c.unexposed},
                               {"lost", c.lost},
                               {"failed", c.failed},
                               {"duplicates", c.duplicates},
                               {"corrupt", c.corrupt},
                               {"frame_rate", c.frame_rate},
                               {"queue_peak", c.queue_peak}});
  }
  json["spread_ms"] = {{"p50", quality.spread_p50_ms}, {"max", quality.spread_max_ms}};
  json["complaints"] = quality.complaints;
  return json.dump(2) + "\n";
}

}  // namespace floatstage::capture
