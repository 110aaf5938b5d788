#include "pipeline/derive/set_times.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr double kMostFrames = 1e6;  // of an offset: more than any take has

std::string hundredths(double value) { return text(std::fixed, std::setprecision(2), value); }

const capture::CameraTimeOffset* time_of(const capture::TimeOffsetFile& times, const std::string& serial) {
  const auto found = std::find_if(times.cameras.begin(), times.cameras.end(),
                                  [&](const auto& one) { return one.serial == serial; });
  return found != times.cameras.end() && found->offset ? &*found : nullptr;
}

}  // namespace

Result<SetTimesReport> set_times(const capture::TakeReader& take, const capture::TimeOffsetFile& times,
                                 const std::filesystem::path& out) {
  const std::vector<RigCamera>& cameras = take.rig().cameras;
  const std::string name = take.layout().folder().string();
  const double period = 1e9 / take.manifest().frame_rate;
  if (!(take.manifest().frame_rate > 0)) return fail(ErrorCode::NotFound, text(name, ": has no frame rate"));
  std::vector<double> known;
  for (const RigCamera& camera : cameras)
    if (const auto* one = time_of(times, camera.serial))
      known.push_back(static_cast<double>(one->offset->count) / period);
  if (known.empty())
    return fail(ErrorCode::NotFound, text("no camera of ", name, " has a time; `floatstage calibrate times ",
                                          name, "` measures them"));
  const double usual = median(std::move(known));
  SetTimesReport report;
  capture::TimeOffsetFile left = times;
  int first = 0, end = take.frame_count();
  for (const RigCamera& camera : cameras) {
    const auto* const one = time_of(times, camera.serial);
    const double frames = one == nullptr ? 0 : static_cast<double>(one->offset->count) / period - usual;
    const int whole = static_cast<int>(std::lround(std::clamp(frames, -kMostFrames, kMostFrames)));
    report.moved.push_back(whole);
    if (whole == 0) continue;
    first = std::max(first, whole), end = std::min(end, take.frame_count() + std::min(whole, 0));
    left.cameras[static_cast<std::size_t>(one - times.cameras.data())].offset->count -=
        std::llround(whole * period);
    report.sentences.push_back(
        text("camera '", camera.serial, "' was ", hundredths(std::abs(frames)), " frames ",
             whole < 0 ? "behind" : "ahead of", " the others; its pictures moved ", std::abs(whole),
             whole < 0 ? " earlier, " : " later, ", hundredths(std::abs(frames - whole)), " are left"));
  }
  if (report.sentences.empty())
    return fail(
        ErrorCode::InvalidArgument,
        text("no camera of ", name, " is half a frame or more apart from the others: nothing to move"));
  if (first >= end)
    return fail(ErrorCode::InvalidArgument,
                text("no instant of ", name, " would be left of which all cameras have a picture"));
  Result<DerivedReport> made = derive_take(take,
                                           {.rig = std::nullopt,
                                            .first = first,
                                            .end = end,
                                            .how = "set-times",
                                            .label = {},
                                            .moved = report.moved,
                                            .times = std::move(left)},
                                           out);
  if (!made) return forward(made);
  report.take = *std::move(made);
  return report;
}

}  // namespace floatstage::pipeline
