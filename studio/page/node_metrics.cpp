#include "studio/page/node_metrics.h"

#include <utility>
#include <vector>

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

namespace floatstage::studio {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Labels = std::vector<ClientMetric::Label>;

class Families {
 public:
  Families& begin(const char* name, const char* help, MetricType type) {
    MetricFamily family;
    family.name = name;
    family.help = help;
    family.type = type;
    families_.push_back(std::move(family));
    return *this;
  }
  Families& add(double value, Labels labels = {}) {
    ClientMetric metric;
    metric.label = std::move(labels);
    (families_.back().type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
    families_.back().metric.push_back(std::move(metric));
    return *this;
  }
  void add(std::uint64_t value, Labels labels) { add(static_cast<double>(value), std::move(labels)); }
  const std::vector<MetricFamily>& all() const { return families_; }

 private:
  std::vector<MetricFamily> families_;
};

void add_cameras(Families& out, const NodeStatus& status) {
  out.begin("floatstage_camera_frames_total", "Pictures of a camera, by what became of them",
            MetricType::Counter);
  for (const NodeCamera& c : status.cameras) {
    out.add(c.delivered, {{"camera", c.serial}, {"result", "delivered"}});
    out.add(c.lost, {{"camera", c.serial}, {"result", "lost"}});
    out.add(c.failed, {{"camera", c.serial}, {"result", "failed"}});
    out.add(c.corrupt, {{"camera", c.serial}, {"result", "corrupt"}});
    out.add(c.starved, {{"camera", c.serial}, {"result", "starved"}});
  }
  out.begin("floatstage_camera_reconnects_total", "Times a camera came back", MetricType::Counter);
  for (const NodeCamera& c : status.cameras) out.add(c.reconnects, {{"camera", c.serial}});
  out.begin("floatstage_camera_frame_rate", "Pictures a second over the last seconds", MetricType::Gauge);
  for (const NodeCamera& c : status.cameras) out.add(c.frame_rate, {{"camera", c.serial}});
  out.begin("floatstage_camera_up", "1 while a camera streams", MetricType::Gauge);
  for (const NodeCamera& c : status.cameras) out.add(c.trouble.empty() ? 1.0 : 0.0, {{"camera", c.serial}});
  out.begin("floatstage_camera_temperature_celsius", "Where the device tells", MetricType::Gauge);
  for (const NodeCamera& c : status.cameras)
    if (c.temperature_c) out.add(*c.temperature_c, {{"camera", c.serial}});
}

}  // namespace

std::string prometheus_text(const NodeStatus& status, const PageCounters& page) {
  Families out;
  add_cameras(out, status);
  out.begin("floatstage_sync_spread_seconds", "Between the exposures of one instant, over the last seconds",
            MetricType::Gauge)
      .add(status.spread_p50_ms * 1e-3, {{"quantile", "0.5"}})
      .add(status.spread_max_ms * 1e-3, {{"quantile", "1"}});
  out.begin("floatstage_recording", "1 while a take is recorded", MetricType::Gauge)
      .add(status.recording ? 1.0 : 0.0);
  out.begin("floatstage_recording_gaps", "Rows without a picture in the take being recorded",
            MetricType::Gauge)
      .add(status.recording ? static_cast<double>(status.recording->gaps) : 0.0);
  out.begin("floatstage_disk_free_bytes", "Where takes are written", MetricType::Gauge)
      .add(static_cast<double>(status.disk_free_bytes));
  out.begin("floatstage_page_requests_total", "Requests to the node's page", MetricType::Counter)
      .add(static_cast<double>(page.requests));
  out.begin("floatstage_page_refused_total", "Requests without the right token", MetricType::Counter)
      .add(static_cast<double>(page.refused));
  out.begin("floatstage_page_viewers", "Open live connections", MetricType::Gauge)
      .add(static_cast<double>(page.viewers));
  out.begin("floatstage_page_dropped_total", "Live messages that a slow viewer did not get",
            MetricType::Counter)
      .add(static_cast<double>(page.dropped));
  return prometheus::TextSerializer().Serialize(out.all());
}

}  // namespace floatstage::studio
