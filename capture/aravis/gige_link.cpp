#include "capture/aravis/gige_link.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr int kHeaders = 20 + 8 + 8;        // IP, UDP, GVSP: within the packet size
constexpr int kEthernet = 14 + 4 + 8 + 12;  // header, checksum, preamble, gap: outside it
constexpr double kUsable = 0.95;            // of a link: control traffic and the others' jitter need the rest

}  // namespace

Result<GigeSchedule> gige_schedule(const GigeDemand& d) {
  if (d.payload_bytes == 0 || !(d.frame_rate > 0) || d.cameras < 1 || !(d.link_mbit > 0) ||
      d.packet_bytes <= kHeaders) {
    return fail(
        ErrorCode::InvalidArgument,
        text("GigE link: ", d.cameras, " cameras of ", d.payload_bytes, " bytes a picture at ", d.frame_rate,
             " pictures a second in packets of ", d.packet_bytes, " bytes on ", d.link_mbit,
             " Mbit/s cannot be; all must be positive, packets above ", kHeaders, " bytes"));
  }
  GigeSchedule schedule;
  const auto carried = static_cast<std::uint64_t>(d.packet_bytes - kHeaders);
  schedule.packets = (d.payload_bytes + carried - 1) / carried + 2;
  const double packet_ns = (d.packet_bytes + kEthernet) * 8e3 / d.link_mbit;
  const double turn_ns = packet_ns * d.cameras;
  const double picture_ns = turn_ns * static_cast<double>(schedule.packets);
  schedule.link_share = picture_ns * d.frame_rate * 1e-9;
  schedule.packet_time = {std::llround(packet_ns)};
  schedule.packet_delay = {std::llround(turn_ns - packet_ns)};
  schedule.picture_time = {std::llround(picture_ns)};
  if (schedule.link_share > kUsable) {
    const double fits = std::floor(10 * d.frame_rate * kUsable / schedule.link_share) / 10;
    return fail(ErrorCode::InvalidArgument,
                text("GigE link: ", d.cameras, " cameras of ", d.payload_bytes, " bytes a picture at ",
                     d.frame_rate, " pictures a second need ", std::llround(100 * schedule.link_share),
                     " % of ", d.link_mbit, " Mbit/s; use at most ", fits,
                     " pictures a second, a smaller region, larger packets or one "
                     "link for fewer cameras"));
  }
  return schedule;
}

}  // namespace floatstage::capture
