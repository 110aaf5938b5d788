#include "pipeline/take_times.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/synchronizer.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/scene_loader.h"
#include "recon/outline.h"

namespace floatstage::pipeline {
namespace {

// How much later a camera's stamps are than another's of the same row, usually; ns.
double stamps_apart(const capture::TakeReader& take, int camera, int reference,
                    const std::vector<int>& frames) {
  const std::vector<FrameRow>&one = take.rows(camera), &other = take.rows(reference);
  std::vector<double> apart;
  for (const int frame : frames) {
    const auto k = static_cast<std::size_t>(frame);
    if (k < one.size() && k < other.size() && one[k].media_index && other[k].media_index)
      apart.push_back(static_cast<double>((one[k].info.exposure_start - other[k].info.exposure_start).count));
  }
  return apart.empty() ? 0 : median(std::move(apart));
}

Result<std::vector<std::vector<Silhouette>>> outlines_of(const capture::TakeReader& take,
                                                         const std::vector<int>& frames, int threads,
                                                         Progress* progress) {
  const std::vector<RigCamera>& cameras = take.rig().cameras;
  std::vector<std::vector<Silhouette>> outlines;
  ProgressPart part(progress, "silhouettes", frames.size());
  for (const int frame : frames) {
    if (is_cancelled(progress)) return cancelled_unwritten();
    const Result<std::vector<Matte>> mattes = load_mattes(take, frame);
    if (!mattes) return forward(mattes);
    std::vector<Silhouette> all(cameras.size());
    parallel_for(all.size(), threads, [&](std::size_t c) {
      const Matte& matte = (*mattes)[c];
      if (!matte.empty()) all[c] = recon::outline_of(matte, cameras[c].model, {.tolerance = 0});
    });
    outlines.push_back(std::move(all));
    part.advance();
  }
  return outlines;
}

// Whether a camera shows in frame k what it showed in the one before, and most others do not.
bool stands_still(const std::vector<std::vector<Silhouette>>& outlines, std::size_t k, std::size_t camera) {
  if (outlines[k][camera].empty() || outlines[k][camera].points != outlines[k - 1][camera].points)
    return false;
  std::size_t others = 0, changed = 0;
  for (std::size_t c = 0; c < outlines[k].size(); ++c) {
    if (c == camera || outlines[k][c].empty()) continue;
    ++others, changed += outlines[k][c].points != outlines[k - 1][c].points;
  }
  return 2 * changed > others;
}

std::vector<Standstill> standstills_in(const std::vector<std::vector<Silhouette>>& outlines,
                                       const std::vector<int>& frames) {
  constexpr std::size_t kLongEnough = 4;  // frames: performers may hold still for long, noise does not
  std::vector<Standstill> found;
  for (std::size_t c = 0; !outlines.empty() && c < outlines.front().size(); ++c) {
    std::size_t begin = 0, best = 0, best_begin = 0;
    for (std::size_t k = 1; k < outlines.size(); ++k) {
      if (!stands_still(outlines, k, c)) begin = k;
      if (k - begin + 1 > best) best = k - begin + 1, best_begin = begin;
    }
    if (best >= kLongEnough) found.push_back({c, frames[best_begin], frames[best_begin + best - 1]});
  }
  return found;
}

std::string rounded(double value, int decimals) {
  const double scale = std::pow(10, decimals);
  return text(std::round(scale * value) / scale);
}

// Instants by a rate's period: one that is apart by whole periods is of a neighbouring set.
void add_warnings(const Rig& rig, const std::vector<std::optional<double>>& instants, double rate,
                  TakeTimes& out) {
  const auto camera = [&](std::size_t c) { return text("camera '", rig.cameras[c].serial, "': "); };
  std::vector<double> known;
  for (const std::optional<double>& instant : instants)
    if (instant) known.push_back(*instant);
  if (known.empty()) return;
  const double first = known.front();
  for (double& instant : known) instant = first + std::remainder(instant - first, 1.0);
  const double middle = median(std::move(known));
  // As the live chain, whatever the rate.
  const double tolerance =
      std::min(static_cast<double>(capture::SyncOptions{}.tolerance.count) * 1e-6, 400 / rate);
  for (std::size_t c = 0; c < instants.size(); ++c) {
    if (!instants[c]) continue;
    const double sigma = out.offsets.cameras[c].sigma_frames,
                 apart_ms = 1e3 / rate * std::remainder(*instants[c] - middle, 1.0);
    if (sigma > kSureFrames)
      out.warnings.push_back(text(camera(c), "known to ", rounded(sigma, 3), " frames only, not to ",
                                  kSureFrames,
                                  "; take in more frames, or some in which more moves (--frames)"));
    if (std::abs(apart_ms) > tolerance)
      out.warnings.push_back(text(
          camera(c), "its pictures are taken ", rounded(apart_ms, 1),
          " ms from the middle of the others', which is more than the ", tolerance,
          " ms that pictures of one instant may differ by: `live` and camera nodes leave it out. Trigger the "
          "cameras together, or start this one anew until it is nearer; `process` uses it, and draws what "
          "moves by that much beside where it was"));
  }
}

}  // namespace

Result<TakeTimes> measure_take_times(const capture::TakeReader& take, const std::vector<int>& frames,
                                     const calib::TimeOffsetOptions& options, Progress* progress) {
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i] != frames[i - 1] + 1)
      return fail(ErrorCode::InvalidArgument,
                  "time offsets need frames that follow one another: A:B without a step");
  if (!(take.manifest().frame_rate > 0))
    return fail(ErrorCode::NotFound, text(take.layout().folder().string(), ": has no frame rate"));
  const Result<std::vector<std::vector<Silhouette>>> outlines =
      outlines_of(take, frames, options.threads, progress);
  if (!outlines) return forward(outlines);
  Result<calib::TimeOffsets> offsets = calib::measure_time_offsets(take.rig(), *outlines, options);
  if (!offsets) return forward(offsets);
  TakeTimes out{*std::move(offsets), {"silhouettes", {}}, standstills_in(*outlines, frames), {}};
  std::vector<std::optional<double>> instants;  // frames
  for (const calib::TimeOffset& one : out.offsets.cameras)
    instants.push_back(one.measured ? std::optional(one.frames) : std::nullopt);
  add_warnings(take.rig(), instants, take.manifest().frame_rate, out);
  const double period = 1e9 / take.manifest().frame_rate;
  for (std::size_t c = 0; c < out.offsets.cameras.size(); ++c) {
    calib::TimeOffset& one = out.offsets.cameras[c];
    capture::CameraTimeOffset row{take.rig().cameras[c].serial, {}, {}, one.not_measured};
    if (one.measured) {
      // Silhouettes tell instants; what stamps tell of them already is no offset.
      one.frames -= stamps_apart(take, static_cast<int>(c), out.offsets.reference, frames) / period;
      row.offset = Nanoseconds{std::llround(one.frames * period)};
      row.sigma = Nanoseconds{std::llround(one.sigma_frames * period)};
    }
    out.file.cameras.push_back(std::move(row));
  }
  return out;
}

}  // namespace floatstage::pipeline
