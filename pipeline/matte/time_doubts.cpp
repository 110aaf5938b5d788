#include "pipeline/matte/time_doubts.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>

#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/take_times.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kFewestTimed = 4;         // of fewer, any could be the one that is apart
constexpr std::size_t kFewestTimedFrames = 12;  // calib::measure_time_offsets()
constexpr std::size_t kManyCameras = 16;        // which together tell as much in half of the time
constexpr std::size_t kEnoughFrames = 50;       // two seconds, in which somebody moves
constexpr double kApart = 0.5;  // frames: from there on, moving the pictures brings them nearer
constexpr double kSigmas = 3;

// The middle of the longest stretch of frames that follow one another.
std::vector<int> in_a_row(const std::vector<int>& frames, std::size_t enough) {
  std::size_t best = 0, length = 0;
  for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
    for (end = begin + 1; end < frames.size() && frames[end] == frames[end - 1] + 1;) ++end;
    if (end - begin > length) best = begin, length = end - begin;
  }
  const std::size_t some = std::min(length, enough);
  const auto first = frames.begin() + static_cast<std::ptrdiff_t>(best + (length - some) / 2);
  return {first, first + static_cast<std::ptrdiff_t>(some)};
}

std::string tenths(double value) { return text(std::fixed, std::setprecision(1), value); }

// By how many frames a camera is apart from most; nothing where that is not known.
std::vector<std::optional<double>> apart_from_most(const calib::TimeOffsets& times) {
  std::vector<double> known;
  for (const calib::TimeOffset& one : times.cameras)
    if (one.measured) known.push_back(one.frames);
  std::vector<std::optional<double>> apart(times.cameras.size());
  if (known.size() < kFewestTimed) return apart;
  const double usual = median(std::move(known));
  for (std::size_t c = 0; c < apart.size(); ++c)
    if (times.cameras[c].measured) apart[c] = times.cameras[c].frames - usual;
  return apart;
}

bool is_sure(double apart, const calib::TimeOffset& one) {
  return std::abs(apart) >= kSigmas * one.sigma_frames;
}

// Somebody seems to be apart, but that may be chance.
bool is_unsure(const calib::TimeOffsets& times) {
  const std::vector<std::optional<double>> apart = apart_from_most(times);
  for (std::size_t c = 0; c < apart.size(); ++c)
    if (apart[c] && std::abs(*apart[c]) >= kApart && !is_sure(*apart[c], times.cameras[c])) return true;
  return false;
}

}  // namespace

Result<std::vector<std::string>> time_doubts(const capture::TakeReader& take, const std::vector<int>& frames,
                                             int threads, Progress* progress) {
  std::vector<std::string> doubts;
  const std::vector<RigCamera>& cameras = take.rig().cameras;
  const std::vector<int> asked =
      in_a_row(frames, cameras.size() > kManyCameras ? kEnoughFrames / 2 : kEnoughFrames);
  if (cameras.size() < kFewestTimed || asked.size() < kFewestTimedFrames || !(take.manifest().frame_rate > 0))
    return doubts;
  Result<TakeTimes> times = measure_take_times(take, asked, {.quick = true, .threads = threads}, progress);
  if (times && is_unsure(times->offsets))
    times = measure_take_times(take, asked, {.quick = false, .threads = threads}, progress);
  if (!times) return forward(times);
  for (const Standstill& still : times->standstills)
    doubts.push_back(text("camera '", cameras[still.camera].serial, "' shows the same picture in frames ",
                          still.first, " to ", still.last,
                          " while the others move: its signal was lost, or the last picture was repeated; "
                          "leave those frames out (`floatstage take trim`) or the camera (--cameras of "
                          "`floatstage import`)"));
  const std::vector<std::optional<double>> apart = apart_from_most(times->offsets);
  const std::string name = take.layout().folder().string();
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const calib::TimeOffset& one = times->offsets.cameras[c];
    if (!apart[c] || std::abs(*apart[c]) < kApart || !is_sure(*apart[c], one)) continue;
    doubts.push_back(text(
        "camera '", cameras[c].serial, "' is ", tenths(std::abs(*apart[c])), " +- ",
        tenths(std::max(one.sigma_frames, 0.05)), " frames ", *apart[c] < 0 ? "behind" : "ahead of",
        " the others, so that what moves is cut and drawn beside where it was; `floatstage "
        "calibrate times ",
        name, "` and `floatstage take set-times ", name, " -o NEW` bring its pictures to their instants"));
  }
  return doubts;
}

}  // namespace floatstage::pipeline
