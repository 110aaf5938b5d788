#include "pipeline/matte/label_hull.h"

#include <algorithm>
#include <cmath>

#include "core/matte.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kDepths = 400;              // places along a ray …
constexpr double kFarthest = 2;           // … as far as this times the way to the farthest other camera
constexpr std::size_t kFewWitnesses = 3;  // two bound a body, the third confirms it
constexpr std::size_t kOutvotes = 2;      // cameras that confirm, for each that denies
constexpr float kThere = 2;               // edges from where a label is expected
constexpr std::size_t kAsked = 500;       // places of a label, about
constexpr double kKeeps = 0.5;            // of what is there without a camera, if it is a witness
constexpr double kOutgrown = 2;           // times as many voxels as wanted: their edge is chosen anew

bool shows_somebody(const Image& matte, const Vector2d& at) {
  return *matte.at(std::min(static_cast<int>(at.x()), matte.width - 1),
                   std::min(static_cast<int>(at.y()), matte.height - 1)) >= 128;
}

OthersSay along_ray(const Rig& rig, const std::vector<Image>& mattes, int camera, const Vector2d& at) {
  OthersSay best;
  const RigCamera& from = rig.cameras[static_cast<std::size_t>(camera)];
  const std::optional<Vector3d> ray = unproject(from.model, at);
  if (!ray) return best;
  const Vector3d eye = from.cam_from_world.center(),
                 along = from.cam_from_world.rotation.conjugate() * ray->normalized();
  double farthest = 0;
  for (const RigCamera& c : rig.cameras)
    farthest = std::max(farthest, kFarthest * (c.cam_from_world.center() - eye).norm());
  for (int i = 1; i <= kDepths; ++i) {
    const Vector3d place = eye + farthest * i / kDepths * along;
    OthersSay here;
    for (std::size_t c = 0; c < mattes.size(); ++c) {
      if (static_cast<int>(c) == camera || mattes[c].empty()) continue;
      const RigCamera& other = rig.cameras[c];
      const std::optional<Vector2d> seen = project(other.model, other.cam_from_world * place);
      if (!seen || !inside(other.model, *seen)) continue;
      (shows_somebody(mattes[c], *seen) ? here.confirm : here.deny).push_back(static_cast<int>(c));
    }
    if (here.confirm.size() > best.confirm.size() ||
        (here.confirm.size() == best.confirm.size() && here.deny.size() < best.deny.size()))
      best = std::move(here);
  }
  return best;
}

class Carver {
 public:
  Carver(const LabelHullOf& of, double& edge) : of_(of), edge_(edge) {}

  LabelHull without(const Disbelieved& disbelieved) {
    LabelHull hull;
    hull.disbelieved = disbelieved;
    std::vector<Matte> mattes;
    for (std::size_t c = 0; c < of_.mattes.size(); ++c)
      mattes.push_back(of_.mattes[c].empty() || disbelieved.contains(static_cast<int>(c))
                           ? Matte()
                           : make_matte({}, of_.mattes[c]));
    if (edge_ == 0 || !disbelieved.empty()) {
      const double wanted = recon::LabelVolume::edge_for(of_.rig, mattes, of_.voxels);
      if (edge_ == 0 || wanted > std::cbrt(kOutgrown) * edge_) edge_ = wanted;
    }
    hull.why = "the silhouettes bound nothing";
    if (edge_ == 0) return hull;
    Result<recon::LabelVolume> volume =
        recon::LabelVolume::carve(of_.rig, mattes, edge_, of_.labels, of_.threads);
    if (volume && volume->size() > 0) {
      hull.volume = std::move(*volume);
      hull.why.clear();
    } else {
      hull.why = volume ? "the silhouettes have no point in common" : volume.error().message;
    }
    return hull;
  }

 private:
  const LabelHullOf& of_;
  double& edge_;
};

// Of each label, how many voxels are where it is expected.
std::vector<long> kept(const LabelHull& hull, const LabelPlaces& expected) {
  std::vector<long> there(expected.size(), 0);
  for (std::size_t l = 0; l < expected.size() && hull.volume; ++l)
    for (const float away : hull.volume->distance_to(expected[l])) there[l] += away <= kThere;
  return there;
}

bool keeps(const LabelHull& with, const LabelHull& without, const LabelPlaces& expected) {
  const std::vector<long> is = kept(with, expected), was = kept(without, expected);
  for (std::size_t l = 0; l < is.size(); ++l)
    if (static_cast<double>(is[l]) < kKeeps * static_cast<double>(was[l])) return false;
  return true;
}

std::size_t witnesses(const std::vector<Image>& mattes, const Disbelieved& disbelieved) {
  std::size_t count = 0;
  for (std::size_t c = 0; c < mattes.size(); ++c)
    count += !mattes[c].empty() && !disbelieved.contains(static_cast<int>(c));
  return count;
}

bool outvoted(std::size_t confirm, std::size_t deny) { return deny > 0 && confirm >= kOutvotes * deny; }

// Who of the cameras shows somebody at most of these places, and who at fewer.
OthersSay ask_at(const LabelHullOf& of, const std::vector<Eigen::Vector3i>& places, double edge,
                 const Disbelieved& unasked) {
  OthersSay say;
  for (std::size_t c = 0; c < of.mattes.size(); ++c) {
    if (of.mattes[c].empty() || unasked.contains(static_cast<int>(c))) continue;
    const RigCamera& camera = of.rig.cameras[c];
    long seen = 0, there = 0;
    for (std::size_t p = 0; p < places.size(); p += 1 + places.size() / kAsked) {
      const Vector3d place = edge * (places[p].cast<double>() + Vector3d::Constant(0.5));
      const std::optional<Vector2d> at = project(camera.model, camera.cam_from_world * place);
      if (!at || !inside(camera.model, *at)) continue;
      ++seen;
      there += shows_somebody(of.mattes[c], *at);
    }
    if (seen > 0) (2 * there > seen ? say.confirm : say.deny).push_back(static_cast<int>(c));
  }
  return say;
}

// Adds cameras that deny labels which the hull has lost. Whether there are any.
bool any_lost(const LabelHullOf& of, const LabelPlaces& expected, const LabelHull& hull, double edge,
              Disbelieved& more) {
  const std::vector<long> is = kept(hull, expected);
  for (std::size_t l = 0; l < is.size(); ++l) {
    if (static_cast<double>(is[l]) >= kKeeps * static_cast<double>(expected[l].size())) continue;
    const OthersSay say = ask_at(of, expected[l], edge, hull.disbelieved);
    if (outvoted(say.confirm.size(), say.deny.size()))
      for (const int c : say.deny) more.emplace(c, Lacks{static_cast<int>(l) + 1, of.frame, {}});
  }
  return more.size() > hull.disbelieved.size() && witnesses(of.mattes, more) >= kFewWitnesses;
}

std::vector<NowhereWord> unmet(const LabelHullOf& of, const LabelHull& hull) {
  return words_nowhere(hull.volume ? &*hull.volume : nullptr, *of.said, of.mattes);
}

}  // namespace

OthersSay ask_others(const Rig& rig, const std::vector<Image>& mattes, const NowhereWord& word) {
  std::vector<int> votes(rig.cameras.size(), 0), asked = votes;
  for (const Vector2d& at : word.unmet) {
    const OthersSay one = along_ray(rig, mattes, word.camera, at);
    for (const int c : one.confirm)
      ++votes[static_cast<std::size_t>(c)], ++asked[static_cast<std::size_t>(c)];
    for (const int c : one.deny) --votes[static_cast<std::size_t>(c)], ++asked[static_cast<std::size_t>(c)];
  }
  OthersSay all;
  for (std::size_t c = 0; c < votes.size(); ++c)
    if (asked[c] > 0) (votes[c] > 0 ? all.confirm : all.deny).push_back(static_cast<int>(c));
  return all;
}

Disbelieved who_lacks(const LabelHullOf& of, const recon::LabelVolume& volume, const LabelPlaces& places,
                      const Disbelieved& before) {
  Disbelieved lack;
  for (std::size_t l = 0; l < places.size(); ++l) {
    const std::vector<float> away = volume.distance_to(places[l]);
    std::vector<Eigen::Vector3i> there;
    for (std::size_t v = 0; v < away.size(); ++v)
      if (away[v] <= kThere) there.push_back(volume.places()[v]);
    if (static_cast<double>(there.size()) < kKeeps * static_cast<double>(places[l].size())) continue;
    const OthersSay say = ask_at(of, there, volume.voxel(), {});
    if (!outvoted(say.confirm.size(), say.deny.size())) continue;
    for (const int c : say.deny) {
      const auto known = before.find(c);
      lack.emplace(c, known != before.end() ? known->second : Lacks{static_cast<int>(l) + 1, of.frame, {}});
    }
  }
  return witnesses(of.mattes, lack) >= kFewWitnesses ? lack : before;
}

LabelPlaces with_edge(const LabelPlaces& places, double edge, double other) {
  if (edge == other) return places;
  LabelPlaces out;
  const auto before = [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  for (const std::vector<Eigen::Vector3i>& of : places) {
    std::vector<Eigen::Vector3i>& there = out.emplace_back();
    for (const Eigen::Vector3i& p : of)
      there.emplace_back(
          ((p.cast<double>() + Vector3d::Constant(0.5)) * (edge / other)).array().floor().cast<int>());
    std::sort(there.begin(), there.end(), before);
    there.erase(std::unique(there.begin(), there.end()), there.end());
  }
  return out;
}

LabelHull label_hull(const LabelHullOf& of, double& edge) {
  const bool chosen = edge > 0;
  const double edge_expected = edge;
  Carver carver(of, edge);
  LabelPlaces expected = of.expected;
  const auto carve = [&](const Disbelieved& disbelieved) {
    LabelHull hull = carver.without(disbelieved);
    if (chosen) expected = with_edge(of.expected, edge_expected, edge);
    return hull;
  };
  LabelHull hull = carve(of.before);
  if (hull.volume && !expected.empty())
    if (const Disbelieved lack = who_lacks(of, *hull.volume, expected, of.before); lack != of.before)
      hull = carve(lack);
  if (Disbelieved more = hull.disbelieved; any_lost(of, expected, hull, edge, more)) {
    const double before = edge;
    LabelHull without = carve(more);
    if (edge != before) hull = carve(hull.disbelieved);  // to be compared
    if (!keeps(hull, without, expected)) hull = std::move(without);
  }
  if (!of.said) return hull;
  hull.nowhere = unmet(of, hull);
  Disbelieved more = hull.disbelieved;
  for (NowhereWord& word : hull.nowhere) {
    OthersSay others = ask_others(of.rig, of.mattes, word);
    word.denied_by = std::move(others.deny);
    if (outvoted(others.confirm.size(), word.denied_by.size()))
      for (const int c : word.denied_by) more.emplace(c, Lacks{word.label, of.frame, word.camera});
  }
  if (more.size() == hull.disbelieved.size() || witnesses(of.mattes, more) < kFewWitnesses) return hull;
  if (!chosen) edge = 0;  // of the box that they bound
  LabelHull without = carver.without(more);
  const std::vector<NowhereWord> left = unmet(of, without);
  for (const NowhereWord& word : hull.nowhere)
    if (std::any_of(left.begin(), left.end(), [&](const NowhereWord& l) {
          return l.at == word.at && l.label == word.label && l.camera == word.camera;
        }))
      without.nowhere.push_back(word);
  return without;
}

}  // namespace floatstage::pipeline
