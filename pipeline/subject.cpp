#include "pipeline/subject.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

// Evenly over the sphere, a Fibonacci spiral: neighbours are 11 degrees apart, and between two of them the
// outermost point of a ball is missed by half a hundredth of its radius.
constexpr int kDirections = 400;

std::vector<Eigen::Vector3f> directions() {
  std::vector<Eigen::Vector3f> out;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    out.push_back(Eigen::Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z).cast<float>());
  }
  return out;
}

// Around so many vertices after one another, which lie close together: what no direction can find in a ball
// is not looked for.
constexpr std::size_t kInABall = 64;

struct Ball {
  Eigen::Vector3f center;
  float radius;  // with room for rounding
};

std::vector<Ball> balls_around(const std::vector<Eigen::Vector3f>& positions) {
  std::vector<Ball> balls;
  for (std::size_t first = 0; first < positions.size(); first += kInABall) {
    const std::size_t end = std::min(positions.size(), first + kInABall);
    Eigen::AlignedBox3f box;
    for (std::size_t v = first; v < end; ++v) box.extend(positions[v]);
    const Eigen::Vector3f center = box.center();
    const float size = box.diagonal().norm() / 2;
    balls.push_back({center, size + 1e-5f * (size + center.norm())});
  }
  return balls;
}

// Standard deviation of the Gaussian that smooths a track, seconds: a step of a walk takes half a second, and
// the camera should go with the walker and not with the steps.
constexpr double kSmoothing = 0.25;

// The centre of the volume, which arms and hair hardly move; of the box where there is no volume.
Eigen::Vector3d middle_of(const Mesh& mesh) {
  const Eigen::Vector3d box = bounding_box(mesh).center().cast<double>();
  double volume = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.positions[mesh.triangles[t + k]].cast<double>() - box;
    const double six = p[0].dot(p[1].cross(p[2]));
    volume += six;
    moment += six * (p[0] + p[1] + p[2]) / 4;
  }
  const Eigen::Vector3d middle = box + moment / volume;
  const Eigen::AlignedBox3d within = bounding_box(mesh).cast<double>();
  return middle.allFinite() && within.contains(middle) ? middle : box;
}

// What `process` is to be told so that it makes the meshes of these labels.
std::string chosen_words(const TakeLayout& layout) {
  std::string words;
  for (const std::string& label : layout.labels()) words += (words.empty() ? " --label " : ",") + label;
  return words;
}

}  // namespace

SubjectTrack smoothed_track(const std::vector<std::optional<Eigen::Vector3d>>& middles, double frame_rate) {
  const std::size_t n = middles.size();
  std::vector<Eigen::Vector3d> filled(n);
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < n; ++i) {
    if (!middles[i]) continue;
    for (std::size_t k = last ? *last + 1 : 0; k <= i; ++k) {
      const double share = last ? static_cast<double>(k - *last) / static_cast<double>(i - *last) : 1;
      filled[k] =
          last ? Eigen::Vector3d(*middles[*last] + share * (*middles[i] - *middles[*last])) : *middles[i];
    }
    last = i;
  }
  FLOATSTAGE_CHECK(last.has_value(), "a track of no hull");
  for (std::size_t k = *last + 1; k < n; ++k) filled[k] = *middles[*last];
  SubjectTrack track{filled, frame_rate};
  if (!(frame_rate > 0)) return track;
  const double sigma = kSmoothing * frame_rate;
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * sigma)), end = static_cast<std::ptrdiff_t>(n);
  for (std::ptrdiff_t i = 0; i < end; ++i) {
    // As far to both sides: at its ends the track is where the subject is.
    const std::ptrdiff_t side = std::min({reach, i, end - 1 - i});
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0;
    for (std::ptrdiff_t d = -side; d <= side; ++d) {
      const double w = std::exp(-0.5 * static_cast<double>(d * d) / (sigma * sigma));
      sum += w * filled[static_cast<std::size_t>(i + d)];
      weights += w;
    }
    track.centres[static_cast<std::size_t>(i)] = sum / weights;
  }
  return track;
}

void add(const Mesh& mesh, Subject& subject) {
  if (mesh.empty()) return;
  subject.box.extend(bounding_box(mesh).cast<double>());
  const std::vector<Ball> balls = balls_around(mesh.positions);
  for (const Eigen::Vector3f& d : directions()) {
    std::size_t farthest = 0;
    float reached = mesh.positions[0].dot(d);
    for (std::size_t b = 0; b < balls.size(); ++b) {
      if (balls[b].center.dot(d) + balls[b].radius < reached) continue;
      const std::size_t first = b * kInABall, end = std::min(mesh.positions.size(), first + kInABall);
      for (std::size_t v = first; v < end; ++v)
        if (const float reach = mesh.positions[v].dot(d); reach > reached) farthest = v, reached = reach;
    }
    subject.outermost.push_back(mesh.positions[farthest].cast<double>());
  }
}

Result<Subject> find_subject(const capture::TakeReader& take) {
  std::vector<Result<Subject>> frames(static_cast<std::size_t>(take.frame_count()), Subject());
  std::vector<std::optional<Eigen::Vector3d>> middles(frames.size());
  parallel_for(frames.size(), 0, [&](std::size_t frame) {
    const std::filesystem::path file = take.layout().mesh(static_cast<int>(frame));
    if (!is_there(file)) return;
    const Result<Mesh> mesh = load_ply(file);
    if (mesh && !mesh->empty()) {
      add(*mesh, *frames[frame]);
      middles[frame] = middle_of(*mesh);
    } else if (!mesh) {
      frames[frame] = forward(mesh);
    }
  });
  Subject all;
  for (const Result<Subject>& of : frames) {
    if (!of) return forward(of);
    if (!of->box.isEmpty()) all.box.extend(of->box);
    all.outermost.insert(all.outermost.end(), of->outermost.begin(), of->outermost.end());
  }
  if (all.box.isEmpty())
    return fail(
        ErrorCode::NotFound,
        text(take.layout().folder().string(), " has no mesh with a subject; run `floatstage process ",
             take.layout().folder().string(), chosen_words(take.layout()), "` and look at its mattes"));
  all.track = smoothed_track(middles, take.manifest().frame_rate);
  return all;
}

}  // namespace floatstage::pipeline
