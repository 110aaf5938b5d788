// How steadily methods show a surface along a path. Points of the proxy are followed by their own projection:
// what the colour at a point does beyond a steady change is jitter, what it does at once is a pop.
#include "pipeline/evaluate/temporal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/random.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/evaluate/held_out_scene.h"
#include "pipeline/subject.h"

namespace floatstage::pipeline {
namespace {

constexpr int kPoints = 20000;
constexpr double kTail = 0.999;
constexpr double kFacing = 0.2;    // cosine: what is seen at a grazing angle is a mixture of neighbours
constexpr double kNearer = 0.002;  // share of its depth by which a point may lie behind what is drawn there
// Colours are read through a Gaussian: at the highest frequency that a picture has, 0.5 a pixel, it lets 0.7
// % pass. What is read between pixels would otherwise change with where between them a point happens to lie.
constexpr double kSigma = 1;      // px
constexpr int kReach = 3;         // px
constexpr double kJump = 0.0125;  // share of the proxy's diagonal: the renderers' surfaces end there, too
constexpr int kWayPieces = 16;    // that a picture's way is measured in

struct SurfacePoint {
  Eigen::Vector3d place, normal;
};

// Evenly over the surface, always the same.
std::vector<SurfacePoint> points_on(const Mesh& mesh) {
  std::vector<double> areas;
  double total = 0;
  auto corner = [&](std::size_t t, std::size_t k) {
    return mesh.positions[mesh.triangles[3 * t + k]].cast<double>().eval();
  };
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    total += 0.5 * (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm();
    areas.push_back(total);
  }
  std::vector<SurfacePoint> points;
  Random random(1);
  for (int i = 0; i < kPoints && total > 0; ++i) {
    const double at = (i + random.uniform()) / kPoints * total;
    const auto t = static_cast<std::size_t>(std::lower_bound(areas.begin(), areas.end(), at) - areas.begin());
    if (t >= areas.size()) continue;
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Eigen::Vector3d a = corner(t, 0), b = corner(t, 1) - a, c = corner(t, 2) - a, n = b.cross(c);
    if (n.norm() > 0) points.push_back({a + u * b + v * c, n.normalized()});
  }
  return points;
}

// The mesh's depth in a view, by pixel centres; infinity where it is not.
std::vector<double> depth_of(const Mesh& mesh, const View& view) {
  const CameraModel& m = view.model;
  std::vector<double> depth(static_cast<std::size_t>(m.width) * static_cast<std::size_t>(m.height),
                            std::numeric_limits<double>::infinity());
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    std::array<Eigen::Vector3d, 3> p;  // px, px, 1/z
    bool ahead = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d in =
          view.view_from_world * mesh.positions[mesh.triangles[3 * t + k]].cast<double>();
      ahead = ahead && in.z() > view.near_plane;
      p[k] = {m.fx * in.x() / in.z() + m.cx, m.fy * in.y() / in.z() + m.cy, 1 / in.z()};
    }
    const double area =
        (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (p[1].y() - p[0].y());
    if (!ahead || area == 0) continue;
    const auto [x0, x1] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [y0, y1] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    for (int y = std::max(0, static_cast<int>(std::floor(y0))); y < m.height && y <= y1; ++y)
      for (int x = std::max(0, static_cast<int>(std::floor(x0))); x < m.width && x <= x1; ++x) {
        auto side = [&](std::size_t a, std::size_t b) {
          return ((p[b].x() - p[a].x()) * (y + 0.5 - p[a].y()) -
                  (x + 0.5 - p[a].x()) * (p[b].y() - p[a].y())) /
                 area;
        };
        const double a = side(1, 2), b = side(2, 0), c = 1 - a - b;
        if (a < 0 || b < 0 || c < 0) continue;
        double& d = depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(m.width) +
                          static_cast<std::size_t>(x)];
        d = std::min(d, 1 / (a * p[0].z() + b * p[1].z() + c * p[2].z()));
      }
  }
  return depth;
}

// Pixels that kReach reaches from to where the mesh ends or jumps to another depth: they show two surfaces.
std::vector<bool> beside_edges(const std::vector<double>& depth, const CameraModel& model, double jump) {
  const int width = model.width, height = model.height;
  const double steepest = std::sqrt(1 / (kFacing * kFacing) - 1) / model.fx;  // a pixel, of the depth
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  const auto apart = [&](double a, double b) {
    return !(std::abs(a - b) < std::max(jump, steepest * std::min(a, b)));
  };
  std::vector<bool> edge(depth.size(), false), beside(depth.size(), false);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double d = depth[at(x, y)];
      const bool right = x + 1 < width && apart(d, depth[at(x + 1, y)]),
                 below = y + 1 < height && apart(d, depth[at(x, y + 1)]);
      edge[at(x, y)] = right || below || x == 0 || y == 0 || x + 1 == width || y + 1 == height;
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!edge[at(x, y)]) continue;
      for (int v = std::max(0, y - kReach); v <= std::min(height - 1, y + kReach); ++v)
        for (int u = std::max(0, x - kReach); u <= std::min(width - 1, x + kReach); ++u)
          beside[at(u, v)] = true;
    }
  return beside;
}

// What the proxy looks like in a view.
struct Seen {
  std::vector<double> depth;
  std::vector<bool> beside_edge;
};

// Where a point is seen in a view; absent where something is before it, or an edge beside it.
std::optional<Eigen::Vector2d> seen_at(const SurfacePoint& point, const View& view, const Seen& seen,
                                       bool closed) {
  const CameraModel& m = view.model;
  const Eigen::Vector3d in = view.view_from_world * point.place;
  const std::optional<Eigen::Vector2d> p = project(m, in);
  if (!p) return std::nullopt;
  const double facing = point.normal.dot((view.view_from_world.center() - point.place).normalized());
  if ((closed ? facing : std::abs(facing)) < kFacing) return std::nullopt;
  const int x = static_cast<int>(std::floor(p->x())), y = static_cast<int>(std::floor(p->y()));
  if (x < 0 || y < 0 || x >= m.width || y >= m.height) return std::nullopt;
  const auto here =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(m.width) + static_cast<std::size_t>(x);
  if (seen.beside_edge[here] || seen.depth[here] < in.z() * (1 - kNearer)) return std::nullopt;
  return p;
}

// The colour about a point of a picture that has kReach pixels around it.
std::array<float, 3> read_smoothly(const Image& picture, const Eigen::Vector2d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  const auto weight = [](double d) { return std::exp(-d * d / (2 * kSigma * kSigma)); };
  std::array<double, 3> sum{};
  double total = 0;
  for (int v = y - kReach; v <= y + kReach; ++v)
    for (int u = x - kReach; u <= x + kReach; ++u) {
      const double w = weight(u + 0.5 - p.x()) * weight(v + 0.5 - p.y());
      for (std::size_t c = 0; c < 3; ++c) sum[c] += w * picture.at(u, v)[c];
      total += w;
    }
  std::array<float, 3> mean{};
  for (std::size_t c = 0; c < 3; ++c) mean[c] = static_cast<float>(sum[c] / total);
  return mean;
}

constexpr float kUnseen = -1e6F;

// What one method showed at the points, picture by picture.
struct Course {
  std::vector<std::array<float, 3>> last, before;
  std::vector<float> second;
  std::vector<float> step_tails;
  std::set<int> cameras;
  TemporalScores scores;
};

void note(const Image& rgba, const std::vector<std::optional<Eigen::Vector2d>>& places, Course& course) {
  std::vector<std::array<float, 3>> now(places.size(), {kUnseen, 0, 0});
  std::vector<float> first;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i]) continue;
    now[i] = read_smoothly(rgba, *places[i]);
    if (course.last.empty() || course.last[i][0] == kUnseen) continue;
    const bool three = !course.before.empty() && course.before[i][0] != kUnseen;
    float change = 0, bend = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      change += std::abs(now[i][c] - course.last[i][c]) / 3;
      if (three) bend += std::abs(now[i][c] - 2 * course.last[i][c] + course.before[i][c]) / 3;
    }
    first.push_back(change);
    if (three) course.second.push_back(bend);
  }
  if (!first.empty()) course.step_tails.push_back(percentile(std::move(first), kTail));
  course.before = std::move(course.last);
  course.last = std::move(now);
}

Result<TemporalScores> scores_of(Course& course, int pictures) {
  if (course.second.empty())
    return fail(
        ErrorCode::BadData,
        "no point of the surface is seen from one picture of this path to the next; does it look at the "
        "subject, in steps (--steps) that are small enough?");
  TemporalScores s = course.scores;
  s.steps = pictures - 1;
  s.points = static_cast<double>(course.second.size()) / (pictures - 2);
  s.jitter = std::accumulate(course.second.begin(), course.second.end(), 0.0) /
             static_cast<double>(course.second.size());
  s.jitter_p999 = percentile_in_place(std::span<float>(course.second), kTail);
  const double usual = median(course.step_tails);
  const double worst = *std::max_element(course.step_tails.begin(), course.step_tails.end());
  s.pop = usual > 0 ? worst / usual : 1;
  return s;
}

Result<void> check(const EvaluateOptions& options, const PathPictures& along) {
  if (along.path.keys.size() < 2 || !(along.path.duration() > 0))
    return fail(ErrorCode::InvalidArgument,
                "a path of one key goes nowhere; give it two at least, at two times");
  if (along.count < 4)
    return fail(ErrorCode::InvalidArgument, "a walk of fewer than four pictures says nothing");
  if (options.scale < 1)
    return fail(ErrorCode::InvalidArgument, text("a scale of 1/", options.scale, "; 1/1 is the largest"));
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "a walk around no frame");
  return {};
}

// The subject of a walk around one frame: it stands still. Where the path does not follow it, nowhere.
Result<SubjectTrack> where_it_stands(const capture::TakeReader& take, const CameraPath& path, int frame) {
  if (!path.follows()) return SubjectTrack();
  const Result<Subject> subject = find_subject(take);
  if (!subject) return forward(subject);
  return SubjectTrack{{subject->track.centres[static_cast<std::size_t>(frame)]}, 0};
}

// Times of a path's pictures between which the box's corners turn by even angles, as the camera sees them: a
// walk that slows down and rests would else be steady now and then. A path on which nothing turns: even
// times.
std::vector<double> even_times(const PathPictures& along, const SubjectTrack& standing,
                               const CameraModel& size, const Eigen::AlignedBox3d& box) {
  const int pieces = kWayPieces * (along.count - 1);
  const double duration = along.path.duration();
  std::array<Eigen::Vector3d, 8> before;
  std::vector<double> way(1, 0.0);
  for (int i = 0; i <= pieces; ++i) {
    const PathKey key = sample(along.path, duration * i / pieces, standing);
    const View view = view_of(key, size.width, size.height, box);
    double turned = 0;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d to =
          (view.view_from_world * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))).normalized();
      if (i > 0) turned += (to - before[static_cast<std::size_t>(k)]).norm();
      before[static_cast<std::size_t>(k)] = to;
    }
    if (i > 0) way.push_back(way.back() + turned);
  }
  std::vector<double> times;
  for (int picture = 0; picture < along.count; ++picture) {
    const double share = static_cast<double>(picture) / (along.count - 1), wanted = share * way.back();
    const auto next = std::lower_bound(way.begin() + 1, way.end() - 1, wanted);
    const double step = *next - *(next - 1), piece = static_cast<double>(next - way.begin() - 1);
    times.push_back(duration * (way.back() > 0
                                    ? (piece + (step > 0 ? (wanted - *(next - 1)) / step : 0)) / pieces
                                    : share));
  }
  return times;
}

}  // namespace

Result<std::map<std::string, TemporalScores>> evaluate_path(capture::TakeReader& take,
                                                            const EvaluateOptions& options,
                                                            const PathPictures& along) {
  if (Result<void> ok = check(options, along); !ok) return forward(ok);
  Inputs inputs{std::vector<bool>(take.rig().cameras.size(), true), {}};
  if (!options.inputs.empty()) {
    Result<Inputs> chosen = choose_inputs(take.rig(), options.inputs, {});
    if (!chosen) return forward(chosen);
    inputs = std::move(*chosen);
  }
  std::vector<std::unique_ptr<render::ViewRenderer>> renderers;
  for (const std::string& name : options.methods) {
    Result<std::unique_ptr<render::ViewRenderer>> renderer =
        render::make_renderer(name, options.renderer.back_end);
    if (!renderer) return forward(renderer);
    renderers.push_back(std::move(*renderer));
  }
  Result<Instant> instant = load_instant(take, options.frames.front(), options.proxy);
  if (!instant) return forward(instant);
  const Result<Mesh> proxy = proxy_without(take, *instant, -1, inputs.input, options.proxy);
  if (!proxy) return forward(proxy);
  render::Scene scene;
  if (Result<void> ok = set_scene(take.rig(), *instant, *proxy, -1, inputs, options.balance, scene); !ok)
    return forward(ok);

  const auto first = static_cast<std::size_t>(std::find(inputs.input.begin(), inputs.input.end(), true) -
                                              inputs.input.begin());
  const CameraModel& size = take.rig().cameras[first].model;
  const Eigen::AlignedBox3d box = bounding_box(*proxy).cast<double>();
  const std::vector<SurfacePoint> points = points_on(*proxy);
  const bool closed =
      instant->any_matte && options.proxy.kind != Proxy::Kind::Plane;  // seen from outside only
  std::vector<Course> courses(renderers.size());
  const Result<SubjectTrack> standing = where_it_stands(take, along.path, options.frames.front());
  if (!standing) return forward(standing);
  const std::vector<double> times = even_times(along, *standing, size, box);
  ProgressPart progress(options.progress, "pictures", static_cast<std::size_t>(along.count));
  for (int picture = 0; picture < along.count; ++picture) {
    if (is_cancelled(options.progress)) return cancelled();
    const PathKey key = sample(along.path, times[static_cast<std::size_t>(picture)], *standing);
    const View view = view_of(key, size.width / options.scale, size.height / options.scale, box);
    Seen seen{depth_of(*proxy, view), {}};
    seen.beside_edge = beside_edges(seen.depth, view.model, kJump * box.diagonal().norm());
    std::vector<std::optional<Eigen::Vector2d>> places;
    for (const SurfacePoint& point : points) places.push_back(seen_at(point, view, seen, closed));
    for (std::size_t m = 0; m < renderers.size(); ++m) {
      const Result<render::RenderedView> rendered = renderers[m]->render(scene, view, options.renderer);
      if (!rendered) return forward(rendered);
      std::set<int> cameras(rendered->cameras.begin(), rendered->cameras.end());
      if (picture > 0 && cameras != courses[m].cameras) ++courses[m].scores.set_changes;
      courses[m].cameras = std::move(cameras);
      note(render::download(*rendered), places, courses[m]);
    }
    progress.advance();
  }
  std::map<std::string, TemporalScores> scores;
  for (std::size_t m = 0; m < renderers.size(); ++m) {
    const Result<TemporalScores> s = scores_of(courses[m], along.count);
    if (!s) return forward(s);
    scores[options.methods[m]] = *s;
  }
  return scores;
}

}  // namespace floatstage::pipeline
