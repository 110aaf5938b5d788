// Method:  epipolar tangents as functions of time, shifted against one another until they meet
// Paper:   the tangents: J. Porrill, S. Pollard, "Curve matching and stereo calibration", 1991; compare
//          S. Sinha, M. Pollefeys, "Synchronization and calibration of camera networks
//          from silhouettes", 2004
// Differs: poses are known, and offsets are fractions of a frame: cubic interpolation between pictures, least
//          squares over all pairs, with a constant for each tangent, so that a rig that is off a little moves
//          nothing; uncertainty by leaving stretches of time out (Efron 1982); cameras that are apart by more
//          than two frames are brought to the others' time by whole frames first
// ADR:     0235, 0257, 0367

#include "calib/silhouettes/silhouette_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <ceres/ceres.h>
#include <ceres/cubic_interpolation.h>

#include "calib/silhouettes/followed_tips.h"
#include "calib/silhouettes/tangencies.h"
#include "calib/silhouettes/whole_frames.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Curve = ceres::Grid1D<double>;
using Interpolator = ceres::CubicInterpolator<Curve>;

constexpr int kFewestFrames = 12;
constexpr int kMargin = 3;   // frames around one, so that two of offset can be interpolated
constexpr double kMost = 2;  // frames of offset, beside whole ones
constexpr double kInterpolated = kMost - 1e-6;  // at the end itself, a frame more would be read
constexpr int kStretches = 8;                   // of time, for the jackknife
constexpr double kFirstLoss = 2;                // px
constexpr double kLeastLoss = 0.1;              // px: outlines are no better than that
constexpr double kUseless = 0.25;               // frames: a sigma that helps nobody
constexpr double kQuickUseless = 0.5;           // likewise, where only whole frames are asked
constexpr double kTurned = 5;                   // times what tangents usually lie apart: a pose that is off
constexpr int kFewestInstants = 5;              // of a tangent, of which one constant is estimated
constexpr int kFewestShared = 8;                // instants at which two cameras' tips are compared
constexpr double kOneTip = 1;                   // px: tips that usually lie nearer to one another are one
constexpr double kSameTangent = 0.3;            // px
constexpr int kFewCameras = 8;                  // of which all pairs are asked, also quickly
constexpr double kFewPlanes = 0.02;             // rad a pixel: the baseline runs through the subject

/// One tangent of a pair of cameras over time.
struct Track {
  int a = 0, b = 0;
  std::vector<double> in_a, in_b;  ///< px of both pictures together; NaN: not seen
  std::vector<int> usable;         ///< frames around which both are known
  double constant = 0;
};

bool known_around(const std::vector<double>& curve, int k) {
  for (int i = k - kMargin; i <= k + kMargin; ++i)
    if (i < 0 || i >= static_cast<int>(curve.size()) || std::isnan(curve[static_cast<std::size_t>(i)]))
      return false;
  return true;
}

/// Whether a curve moves by more than its noise: rates over four frames against what three in a row stray by.
struct Motion {
  double rates = 0, strays = 0;
  void add(const std::vector<double>& curve, const std::vector<int>& at) {
    for (const int frame : at) {
      const auto k = static_cast<std::size_t>(frame);
      const double rate = (curve[k + 2] - curve[k - 2]) / 4,
                   stray = (curve[k - 1] - 2 * curve[k] + curve[k + 1]) / std::sqrt(6.0);
      rates += rate * rate, strays += stray * stray;
    }
  }
  // Noise alone has rates of a third of it.
  bool any() const { return rates > 0 && rates > strays; }
};

std::optional<Track> track_of(const Rig& rig, int a, int b, int side,
                              std::span<const std::vector<ConvexOutline>> frames) {
  const RigCamera &one = rig.cameras[static_cast<std::size_t>(a)],
                  &other = rig.cameras[static_cast<std::size_t>(b)];
  const auto pencil = PlanePencil::through(one, other, focus_point(rig) - one.cam_from_world.center());
  if (!pencil) return std::nullopt;
  Track track{a, b, {}, {}, {}};
  std::optional<double> per_pixel;
  for (const std::vector<ConvexOutline>& outlines : frames) {
    track.in_a.push_back(NAN), track.in_b.push_back(NAN);
    const auto in_a = pencil->extremes(one, outlines[static_cast<std::size_t>(a)]),
               in_b = pencil->extremes(other, outlines[static_cast<std::size_t>(b)]);
    const auto at = [&](const Extremes& e, const ConvexOutline& outline) {
      return outline.rays[static_cast<std::size_t>(e.ray[side])];
    };
    if (in_a && in_b && in_a->ray[side] >= 0 && in_b->ray[side] >= 0 && !per_pixel)
      per_pixel =
          std::hypot(pencil->angle_per_pixel(one, at(*in_a, outlines[static_cast<std::size_t>(a)])),
                     pencil->angle_per_pixel(other, at(*in_b, outlines[static_cast<std::size_t>(b)])));
    if (in_a && in_a->ray[side] >= 0) track.in_a.back() = in_a->angle[side];
    if (in_b && in_b->ray[side] >= 0) track.in_b.back() = in_b->angle[side];
  }
  if (!per_pixel) return std::nullopt;
  for (double& angle : track.in_a) angle /= *per_pixel;
  for (double& angle : track.in_b) angle /= *per_pixel;
  for (int k = 0; k < static_cast<int>(frames.size()); ++k)
    if (known_around(track.in_a, k) && known_around(track.in_b, k)) track.usable.push_back(k);
  if (static_cast<int>(track.usable.size()) < kFewestInstants) return std::nullopt;
  return track;
}

/// What two tangents differ by at frame k of the studio: offset of a, offset of b, constant.
class Apart final : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  Apart(const Track& track, int frame)
      : grid_a_(track.in_a.data(), 0, static_cast<int>(track.in_a.size())),
        grid_b_(track.in_b.data(), 0, static_cast<int>(track.in_b.size())),
        a_(grid_a_),
        b_(grid_b_),
        frame_(frame) {}
  bool Evaluate(const double* const* p, double* residual, double** jacobians) const override {
    double a, b, rate_a, rate_b;
    a_.Evaluate(frame_ - std::clamp(p[0][0], -kInterpolated, kInterpolated), &a, &rate_a);
    b_.Evaluate(frame_ - std::clamp(p[1][0], -kInterpolated, kInterpolated), &b, &rate_b);
    residual[0] = a - b - p[2][0];
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) jacobians[0][0] = -rate_a;
    if (jacobians[1] != nullptr) jacobians[1][0] = rate_b;
    if (jacobians[2] != nullptr) jacobians[2][0] = -1;
    return true;
  }

 private:
  Curve grid_a_, grid_b_;
  Interpolator a_, b_;
  double frame_;
};

/// Offsets of all cameras, those of `measurable` against the first of them.
class Solver {
 public:
  Solver(std::vector<Track>& tracks, std::size_t cameras, int frames)
      : tracks_(tracks), cameras_(cameras), frames_(frames) {}

  /// `without`: a stretch of time that is left out; -1: none.
  std::vector<double> solve(int reference, int without) {
    std::vector<double> offsets(cameras_, 0.0);
    double loss = kFirstLoss;
    for (int round = 0; round < 3; ++round) {
      run(reference, without, loss, offsets);
      loss = std::max(kLeastLoss, 2 * typical_residual(offsets));
    }
    return offsets;
  }

 private:
  bool left_out(int frame, int without) const { return frame * kStretches / frames_ == without; }

  void run(int reference, int without, double scale, std::vector<double>& offsets) {
    ceres::CauchyLoss loss(scale);
    ceres::Problem::Options ownership;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    for (Track& track : tracks_)
      for (const int frame : track.usable)
        if (!left_out(frame, without))
          problem.AddResidualBlock(new Apart(track, frame), &loss,
                                   &offsets[static_cast<std::size_t>(track.a)],
                                   &offsets[static_cast<std::size_t>(track.b)], &track.constant);
    double* const fixed = &offsets[static_cast<std::size_t>(reference)];
    if (!problem.HasParameterBlock(fixed)) return;
    problem.SetParameterBlockConstant(fixed);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 30;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
  }

  double typical_residual(const std::vector<double>& offsets) const {
    std::vector<double> sizes;
    for (const Track& track : tracks_)
      for (const int frame : track.usable) {
        const double* const p[] = {&offsets[static_cast<std::size_t>(track.a)],
                                   &offsets[static_cast<std::size_t>(track.b)], &track.constant};
        double residual;
        Apart(track, frame).Evaluate(p, &residual, nullptr);
        sizes.push_back(std::abs(residual));
      }
    return median(std::move(sizes));
  }

  std::vector<Track>& tracks_;
  std::size_t cameras_;
  int frames_;
};

// All of a few cameras; of many, each with some of its neighbours and some farther off, in the rig's order.
std::vector<std::pair<int, int>> pairs_of(int cameras, bool quick) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < cameras; ++a)
    for (int b = a + 1; b < cameras; ++b) {
      const int apart = std::min(b - a, cameras - (b - a));
      if (!quick || cameras <= kFewCameras || apart <= 2 || apart == cameras / 4) pairs.emplace_back(a, b);
    }
  return pairs;
}

std::vector<Track> all_tracks(const Rig& rig, std::span<const std::vector<Silhouette>> silhouettes,
                              const TimeOffsetOptions& options) {
  std::vector<std::vector<ConvexOutline>> frames(silhouettes.size());
  parallel_for(frames.size(), options.threads, [&](std::size_t k) {
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      frames[k].push_back(convex_outline(rig.cameras[c].model, silhouettes[k][c]));
  });
  const std::vector<std::pair<int, int>> pairs =
      pairs_of(static_cast<int>(rig.cameras.size()), options.quick);
  std::vector<std::array<std::optional<Track>, 2>> found(pairs.size());
  parallel_for(pairs.size(), options.threads, [&](std::size_t i) {
    for (int side = 0; side < 2; ++side)
      found[i][static_cast<std::size_t>(side)] = track_of(rig, pairs[i].first, pairs[i].second, side, frames);
  });
  std::vector<Track> tracks;
  for (auto& sides : found)
    for (std::optional<Track>& track : sides)
      if (track) tracks.push_back(*std::move(track));
  return tracks;
}

double at_time(const std::vector<double>& curve, double time) {
  const double floor = std::floor(time);
  if (floor < 0 || floor + 1 >= static_cast<double>(curve.size())) return NAN;
  const auto k = static_cast<std::size_t>(floor);
  return curve[k] + (time - floor) * (curve[k + 1] - curve[k]);
}

/// Whether two cameras' tips are one place: their planes agree at all instants, by what is known of offsets.
bool agree(const std::vector<double>& in_a, const std::vector<double>& in_b, double offset_a,
           double offset_b) {
  std::vector<double> apart;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    const double d =
        at_time(in_a, static_cast<double>(k) - offset_a) - at_time(in_b, static_cast<double>(k) - offset_b);
    if (!std::isnan(d)) apart.push_back(std::abs(d));
  }
  return static_cast<int>(apart.size()) >= kFewestShared && median(std::move(apart)) < kOneTip;
}

/// Whether the pair's outermost tangents are these.
bool is_known(const Track& track, std::span<const Track> tracks) {
  return std::any_of(tracks.begin(), tracks.end(), [&](const Track& other) {
    if (other.a != track.a || other.b != track.b) return false;
    const auto same = std::count_if(track.usable.begin(), track.usable.end(), [&](int frame) {
      const auto k = static_cast<std::size_t>(frame);
      return std::abs(other.in_a[k] - track.in_a[k]) < kSameTangent;
    });
    return 2 * same > static_cast<std::ptrdiff_t>(track.usable.size());
  });
}

/// Tangents inside of the outlines, of one pair of cameras.
void add_inner_tracks(const Rig& rig, int a, int b, std::span<const std::vector<Silhouette>> frames,
                      const TimeOffsets& offsets, std::span<const Track> outer, std::vector<Track>& out) {
  const auto first = static_cast<std::size_t>(a), second = static_cast<std::size_t>(b);
  const RigCamera &one = rig.cameras[first], &other = rig.cameras[second];
  const Eigen::Vector3d focus = focus_point(rig);
  const Eigen::Vector3d in_one = one.cam_from_world * focus, in_other = other.cam_from_world * focus;
  const auto pencil = PlanePencil::through(one, other, focus - one.cam_from_world.center());
  if (!pencil || !(in_one.z() > 0) || !(in_other.z() > 0)) return;
  const double per_pixel = std::hypot(pencil->angle_per_pixel(one, in_one / in_one.z()),
                                      pencil->angle_per_pixel(other, in_other / in_other.z()));
  if (!(per_pixel < kFewPlanes)) return;
  for (const PencilEnd end : {PencilEnd::Smallest, PencilEnd::Largest}) {
    const auto in_a = followed_tips(*pencil, one, first, end, frames, per_pixel),
               in_b = followed_tips(*pencil, other, second, end, frames, per_pixel);
    for (const std::vector<double>& curve_a : in_a)
      for (const std::vector<double>& curve_b : in_b) {
        if (!agree(curve_a, curve_b, offsets.cameras[first].frames, offsets.cameras[second].frames)) continue;
        Track track{a, b, curve_a, curve_b, {}};
        for (int k = 0; k < static_cast<int>(frames.size()); ++k)
          if (known_around(curve_a, k) && known_around(curve_b, k)) track.usable.push_back(k);
        if (static_cast<int>(track.usable.size()) >= kFewestInstants && !is_known(track, outer))
          out.push_back(std::move(track));
      }
  }
}

// Of the cameras that are measured.
std::vector<Track> inner_tracks(const Rig& rig, std::span<const std::vector<Silhouette>> frames,
                                const TimeOffsets& offsets, std::span<const Track> outer) {
  std::vector<Track> tracks;
  const int cameras = static_cast<int>(rig.cameras.size());
  for (int a = 0; a < cameras; ++a)
    for (int b = a + 1; b < cameras; ++b)
      if (offsets.cameras[static_cast<std::size_t>(a)].measured &&
          offsets.cameras[static_cast<std::size_t>(b)].measured)
        add_inner_tracks(rig, a, b, frames, offsets, outer, tracks);
  return tracks;
}

// Says of every camera whether there is motion to measure it by.
TimeOffsets measurable(std::size_t cameras, const std::vector<Track>& tracks) {
  TimeOffsets out;
  out.cameras.resize(cameras);
  std::vector<Motion> motions(cameras);
  std::vector<bool> seen(cameras, false);
  for (const Track& track : tracks) {
    motions[static_cast<std::size_t>(track.a)].add(track.in_a, track.usable);
    motions[static_cast<std::size_t>(track.b)].add(track.in_b, track.usable);
    seen[static_cast<std::size_t>(track.a)] = seen[static_cast<std::size_t>(track.b)] = true;
  }
  for (std::size_t c = 0; c < cameras; ++c) {
    TimeOffset& one = out.cameras[c];
    one.measured = motions[c].any();
    if (!seen[c]) {
      one.not_measured =
          "its silhouettes and another's are not seen together, uncut, in enough frames in a row";
    } else if (!one.measured) {
      one.not_measured = "nothing moves in its silhouettes";
    }
  }
  return out;
}

// How far each camera's tangents lie from all others', whatever the time.
std::vector<double> distances(std::size_t cameras, const std::vector<Track>& tracks) {
  std::vector<std::vector<double>> apart(cameras);
  for (const Track& track : tracks)
    for (const int c : {track.a, track.b})
      apart[static_cast<std::size_t>(c)].push_back(std::abs(track.constant));
  std::vector<double> out;
  for (std::vector<double>& one : apart) out.push_back(one.empty() ? 0 : median(std::move(one)));
  return out;
}

/// The camera whose pose is off, if there is one: a turned camera lies apart in all its pairs, the others in
/// one each.
std::optional<std::size_t> turned_camera(const TimeOffsets& found) {
  std::vector<double> apart;
  std::size_t worst = 0;
  for (std::size_t c = 0; c < found.cameras.size(); ++c) {
    if (!found.cameras[c].measured) continue;
    apart.push_back(found.cameras[c].apart_px);
    if (!found.cameras[worst].measured || apart.back() > found.cameras[worst].apart_px) worst = c;
  }
  if (apart.size() < 4) return std::nullopt;  // of three, any could be the one
  const double largest = found.cameras[worst].apart_px;
  if (largest > 2 * kLeastLoss && largest > kTurned * median(std::move(apart))) return worst;
  return std::nullopt;
}

// A camera of which nothing is known says nothing, and must not be moved by what others see.
// The reference is one that was not brought to the others' time, where there is one: it shares most instants.
void keep_measurable(const std::vector<int>& whole, TimeOffsets& out, std::vector<Track>& tracks) {
  out.reference = -1;
  for (std::size_t c = 0; c < out.cameras.size(); ++c)
    if (out.cameras[c].measured &&
        (out.reference < 0 || (whole[c] == 0 && whole[static_cast<std::size_t>(out.reference)] != 0)))
      out.reference = static_cast<int>(c);
  std::erase_if(tracks, [&](const Track& t) {
    return !out.cameras[static_cast<std::size_t>(t.a)].measured ||
           !out.cameras[static_cast<std::size_t>(t.b)].measured;
  });
}

void add_uncertainty(Solver& solver, bool quick, TimeOffsets& out) {
  std::vector<std::vector<double>> without;
  for (int k = 0; k < kStretches; ++k) without.push_back(solver.solve(out.reference, k));
  for (std::size_t c = 0; c < out.cameras.size(); ++c) {
    TimeOffset& one = out.cameras[c];
    if (!one.measured || static_cast<int>(c) == out.reference) continue;
    double squares = 0;
    for (const std::vector<double>& offsets : without) squares += std::pow(offsets[c] - one.frames, 2);
    one.sigma_frames = std::sqrt((kStretches - 1.0) / kStretches * squares);
    if (one.sigma_frames < (quick ? kQuickUseless : kUseless) && std::abs(one.frames) < kMost) continue;
    one = {};
    one.not_measured = text("its silhouettes do not tell: too little moves, or they are apart by more than ",
                            kMostWholeFrames, " frames");
  }
}

std::vector<int> whole_frames_apart(const Rig& rig, const std::vector<Track>& tracks) {
  std::vector<SharedTangent> tangents;
  for (const Track& track : tracks) tangents.push_back({track.a, track.b, track.in_a, track.in_b});
  return whole_frames_apart(rig.cameras.size(), tangents);
}

// Every camera's pictures at the instants that they show; nothing where it has none.
std::vector<std::vector<Silhouette>> at_their_instants(std::span<const std::vector<Silhouette>> frames,
                                                       const std::vector<int>& offsets) {
  std::vector<std::vector<Silhouette>> out;
  const int count = static_cast<int>(frames.size());
  for (int k = 0; k < count; ++k) {
    out.emplace_back(offsets.size());
    for (std::size_t c = 0; c < offsets.size(); ++c)
      if (const int from = k - offsets[c]; from >= 0 && from < count)
        out.back()[c] = frames[static_cast<std::size_t>(from)][c];
  }
  return out;
}

// Of cameras that are apart by two frames at most.
TimeOffsets measure_fractions(const Rig& rig, std::span<const std::vector<Silhouette>> frames,
                              const std::vector<int>& whole, std::vector<Track> tracks, bool quick) {
  TimeOffsets out = measurable(rig.cameras.size(), tracks);
  Solver solver(tracks, rig.cameras.size(), static_cast<int>(frames.size()));
  for (;;) {
    keep_measurable(whole, out, tracks);
    if (tracks.empty()) return TimeOffsets{-1, std::move(out.cameras)};
    const std::vector<double> offsets = solver.solve(out.reference, -1);
    const std::vector<double> apart = distances(rig.cameras.size(), tracks);
    for (std::size_t c = 0; c < offsets.size(); ++c)
      if (out.cameras[c].measured) out.cameras[c].frames = offsets[c], out.cameras[c].apart_px = apart[c];
    const std::optional<std::size_t> turned = turned_camera(out);
    if (!turned) break;
    TimeOffset& one = out.cameras[*turned];
    one.measured = false;
    one.frames = 0;
    one.not_measured =
        text("its silhouettes lie ", std::round(10 * one.apart_px) / 10,
             " px from the others' at all times alike: its pose is off (`calibrate silhouettes`)");
  }
  // Offsets to about a tenth of a frame tell which of the other tangents are one, and those make them surer.
  if (!quick)
    for (Track& track : inner_tracks(rig, frames, out, tracks)) tracks.push_back(std::move(track));
  const std::vector<double> offsets = solver.solve(out.reference, -1);
  for (std::size_t c = 0; c < offsets.size(); ++c)
    if (out.cameras[c].measured) out.cameras[c].frames = offsets[c];
  add_uncertainty(solver, quick, out);
  return out;
}

}  // namespace

Result<TimeOffsets> measure_time_offsets(const Rig& rig, std::span<const std::vector<Silhouette>> frames,
                                         const TimeOffsetOptions& options) {
  if (rig.cameras.size() < 2)
    return fail(ErrorCode::InvalidArgument, "one camera alone has no time offset to another");
  if (static_cast<int>(frames.size()) < kFewestFrames)
    return fail(ErrorCode::InvalidArgument,
                text("time offsets need ", kFewestFrames, " frames in a row at least, not ", frames.size()));
  std::vector<Track> tracks = all_tracks(rig, frames, options);
  const std::vector<int> whole = whole_frames_apart(rig, tracks);
  if (std::all_of(whole.begin(), whole.end(), [](int offset) { return offset == 0; }))
    return measure_fractions(rig, frames, whole, std::move(tracks), options.quick);
  const std::vector<std::vector<Silhouette>> together = at_their_instants(frames, whole);
  TimeOffsets out =
      measure_fractions(rig, together, whole, all_tracks(rig, together, options), options.quick);
  for (std::size_t c = 0; c < whole.size() && out.reference >= 0; ++c)
    if (out.cameras[c].measured)
      out.cameras[c].frames += whole[c] - whole[static_cast<std::size_t>(out.reference)];
  return out;
}

}  // namespace floatstage::calib
