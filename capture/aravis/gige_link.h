#pragma once

#include <cstddef>
#include <cstdint>

#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

/// One camera's share of an Ethernet link.
struct GigeDemand {
  std::size_t payload_bytes = 0;  ///< of one picture
  double frame_rate = 0;          ///< pictures a second; > 0
  int cameras = 1;                ///< equal ones that send through the same link at the same time
  double link_mbit = 1000;        ///< of the narrowest link they share
  int packet_bytes = 1400;        ///< GVSP packet with its IP header (GevSCPSPacketSize)
};

/// How a camera spreads a picture's packets so that equal cameras, triggered together, never overrun their
/// link.
struct GigeSchedule {
  std::uint64_t packets = 0;  ///< a picture, leader and trailer included
  Nanoseconds packet_time;    ///< one packet on the wire
  Nanoseconds packet_delay;   ///< to wait after each (GevSCPD): the others' turn
  Nanoseconds picture_time;   ///< from the first packet to the last
  double link_share = 0;      ///< of the link, all cameras together
};

/// Bandwidth of GVSP (GigE Vision 2.x) over Ethernet: each packet of S bytes carries S - 36 of payload (IP
/// 20, UDP 8, GVSP 8) and occupies S + 38 on the wire (header 14, checksum 4, preamble 8, gap 12). With n
/// cameras a packet may follow the last after n packet times. InvalidArgument when the pictures do not fit
/// the link, with what would.
Result<GigeSchedule> gige_schedule(const GigeDemand& demand);

}  // namespace floatstage::capture
