#include "pipeline/silhouettes/misplaced_cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <variant>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/text.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kFewestPlaced = 5;  // cameras: without two of them, three bound a body
constexpr double kHullExplains =
    0.93;  // mean IoU of the hull: a misplaced camera leaves less, a late one more
constexpr double kLeftUnexplained = 0.5;  // of what the hull of all does not explain, so much at most is left
constexpr double kWorthIt = 0.8;          // by each of several guesses
constexpr double kCoarse = 1;             // px: of outlines, where shares of silhouettes are asked
constexpr int kRowStep = 4;               // rows of pictures: those between tell the same
constexpr double kHardly = 0.05;          // of IoU, more than that elsewhere: looked at more closely
constexpr std::array kFlips = {PictureFlip::UpsideDown, PictureFlip::Mirrored,
                               PictureFlip::MirroredUpsideDown};

// Of a matte with what the others leave, seen by a camera.
double overlap(const recon::MeshSilhouettes& hull, const RigCamera& camera, const Matte& matte) {
  const bool same_size = camera.model.width == matte.width && camera.model.height == matte.height;
  return same_size ? hull.iou(camera, matte, kRowStep) : 0;
}

Matte flipped_as(const Matte& matte, PictureFlip flip) {
  Image out = to_image(matte);
  const bool in_x = flip != PictureFlip::MirroredUpsideDown, in_y = flip != PictureFlip::Mirrored;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      *out.at(x, y) = matte.row(in_y ? out.height - 1 - y : y)[in_x ? out.width - 1 - x : x];
  return make_matte(matte.source, out);
}

// Turned by half a turn about its optical axis: the same rays, in a picture that is upside down.
RigCamera upside_down(RigCamera camera) {
  CameraModel& model = camera.model;
  model.cx = model.width - model.cx, model.cy = model.height - model.cy;
  if (auto* const lens = std::get_if<BrownConrady>(&model.lens)) lens->p1 = -lens->p1, lens->p2 = -lens->p2;
  const Rigid3 half{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d::Zero()};
  camera.cam_from_world = half * camera.cam_from_world;
  return camera;
}

recon::MeshSilhouettes silhouettes_of(const Rig& rig, const InstantMattes& mattes,
                                      const recon::HullOptions& options) {
  recon::HullWorkspace workspace;
  Result<recon::HullReport> hull = recon::visual_hull(rig, mattes, options, &workspace);
  return hull ? recon::MeshSilhouettes(std::move(hull->mesh)) : recon::MeshSilhouettes();
}

// Mean IoU of all cameras' hull with their mattes.
double explained(const Rig& rig, const std::vector<InstantMattes>& instants, int threads) {
  recon::HullOptions options = silhouette_hull_options(true);
  options.contour_tolerance = kCoarse;
  options.quality_step = kRowStep;
  std::vector<double> sums(instants.size(), 0.0), counts(instants.size(), 0.0);
  parallel_for(instants.size(), threads, [&](std::size_t i) {
    const Result<recon::HullReport> hull = recon::visual_hull(rig, instants[i], options);
    for (std::size_t c = 0; c < instants[i].size(); ++c) {
      if (instants[i][c].empty()) continue;
      const double iou = hull && !hull->mesh.empty() ? hull->silhouette_iou[c] : 0;
      if (!std::isnan(iou)) sums[i] += iou, ++counts[i];
    }
  });
  const double count = std::accumulate(counts.begin(), counts.end(), 0.0);
  return count > 0 ? std::accumulate(sums.begin(), sums.end(), 0.0) / count : 1;
}

// One instant, and what others leave of it.
class Instant {
 public:
  Instant(const Rig& rig, const InstantMattes& mattes) : rig_(rig), mattes_(mattes) {}

  // Of each camera, against a body that all but so many agree on.
  std::vector<double> agreement(std::size_t but) const {
    const auto shown =
        std::count_if(mattes_.begin(), mattes_.end(), [](const Matte& m) { return !m.empty(); });
    recon::HullOptions options = silhouette_hull_options(false);
    options.voting = recon::HullVoting::MofN;
    options.votes = std::max(2, static_cast<int>(shown) - static_cast<int>(but));
    const recon::MeshSilhouettes hull = silhouettes_of(rig_, mattes_, options);
    std::vector<double> out(mattes_.size(), 1.0);
    for (std::size_t c = 0; c < mattes_.size(); ++c)
      if (!mattes_[c].empty()) out[c] = hull.empty() ? 0 : overlap(hull, rig_.cameras[c], mattes_[c]);
    return out;
  }

  recon::MeshSilhouettes hull_without(const std::vector<std::size_t>& cameras) const {
    InstantMattes others = mattes_;
    for (const std::size_t c : cameras) others[c] = Matte{};
    return silhouettes_of(rig_, others, silhouette_hull_options(false));
  }

  const Matte& matte(std::size_t camera) const { return mattes_[camera]; }

 private:
  const Rig& rig_;
  const InstantMattes& mattes_;
};

std::size_t most_suspects(std::size_t cameras) { return std::max<std::size_t>(2, cameras / 4); }

// So many that agree least with a body that all cameras but some agree on.
std::vector<std::size_t> suspects_of(const std::vector<Instant>& instants, std::size_t cameras,
                                     std::size_t but, int threads) {
  std::vector<std::vector<double>> by_instant(instants.size());
  parallel_for(instants.size(), threads, [&](std::size_t i) { by_instant[i] = instants[i].agreement(but); });
  std::vector<double> sum(cameras, 0.0);
  for (const std::vector<double>& one : by_instant)
    for (std::size_t c = 0; c < cameras; ++c) sum[c] += one[c];
  std::vector<std::size_t> order(cameras);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sum[a] < sum[b]; });
  order.resize(most_suspects(cameras));
  std::sort(order.begin(), order.end());
  return order;
}

// How well each suspect fits where: mean IoU over the instants in which it shows anybody.
struct Fits {
  std::vector<std::vector<double>> at;                     // [suspect][place, a suspect's]
  std::vector<std::array<double, kFlips.size()>> flipped;  // [suspect]
};

Fits fits_of(const Rig& rig, const std::vector<Instant>& instants, const std::vector<std::size_t>& suspects,
             int threads) {
  const std::size_t n = suspects.size();
  Fits fits{std::vector(n, std::vector<double>(n, 0.0)), {}};
  fits.flipped.assign(n, {});
  std::vector<int> seen(n, 0);
  std::vector<recon::MeshSilhouettes> hulls(instants.size());
  parallel_for(instants.size(), threads,
               [&](std::size_t i) { hulls[i] = instants[i].hull_without(suspects); });
  for (std::size_t i = 0; i < instants.size(); ++i) {
    if (hulls[i].empty()) continue;
    parallel_for(n, threads, [&](std::size_t s) {
      const Matte& matte = instants[i].matte(suspects[s]);
      if (matte.empty()) return;
      ++seen[s];
      for (std::size_t p = 0; p < n; ++p) fits.at[s][p] += overlap(hulls[i], rig.cameras[suspects[p]], matte);
      for (std::size_t t = 0; t < kFlips.size(); ++t)
        fits.flipped[s][t] += overlap(hulls[i], rig.cameras[suspects[s]], flipped_as(matte, kFlips[t]));
    });
  }
  for (std::size_t s = 0; s < n; ++s) {
    for (double& one : fits.at[s]) one /= std::max(1, seen[s]);
    for (double& one : fits.flipped[s]) one /= std::max(1, seen[s]);
  }
  return fits;
}

// Where each suspect fits better than where the rig has it, if it is in exchange for others; else its own
// place.
std::vector<std::size_t> places_of(const Fits& fits) {
  const std::size_t n = fits.at.size();
  std::vector<std::size_t> place(n);
  for (std::size_t s = 0; s < n; ++s) {
    place[s] = s;
    for (std::size_t p = 0; p < n; ++p)
      if (fits.at[s][p] > fits.at[s][place[s]] && fits.at[s][p] > fits.at[s][s] + kHardly) place[s] = p;
  }
  // A circle leads back to where it began.
  std::vector<std::size_t> out(n);
  for (std::size_t s = 0; s < n; ++s) {
    std::size_t at = place[s];
    for (std::size_t step = 0; step < n && at != s; ++step) at = place[at];
    out[s] = at == s ? place[s] : s;
  }
  return out;
}

std::size_t best_flip(const Fits& fits, std::size_t s) {
  return static_cast<std::size_t>(std::max_element(fits.flipped[s].begin(), fits.flipped[s].end()) -
                                  fits.flipped[s].begin());
}

// Suspects that fit better elsewhere, by whatever little.
std::vector<std::size_t> narrowed(const std::vector<std::size_t>& suspects, const Fits& fits) {
  const std::vector<std::size_t> places = places_of(fits);
  std::vector<std::size_t> out;
  for (std::size_t s = 0; s < suspects.size(); ++s)
    if (places[s] != s || fits.flipped[s][best_flip(fits, s)] > fits.at[s][s] + kHardly)
      out.push_back(suspects[s]);
  return out;
}

// Cameras that may be misplaced together: a circle of places, or one whose pictures are flipped.
struct Guess {
  std::vector<MisplacedCamera> cameras;
  double gain = 0;  // of IoU, in the mean
};

std::vector<Guess> guesses_of(const std::vector<std::size_t>& suspects, const Fits& fits) {
  std::vector<Guess> guesses;
  const std::vector<std::size_t> places = places_of(fits);
  std::vector<bool> told(suspects.size(), false);
  for (std::size_t s = 0; s < suspects.size(); ++s) {
    const std::size_t flip = best_flip(fits, s);
    const double flipped = fits.flipped[s][flip];
    if (told[s]) continue;
    Guess guess;
    for (std::size_t at = s; places[s] != s && !told[at]; at = places[at]) {
      told[at] = true;
      guess.cameras.push_back(
          {suspects[at], suspects[places[at]], PictureFlip::None, fits.at[at][at], fits.at[at][places[at]]});
    }
    if (guess.cameras.empty() && flipped > fits.at[s][s] + kHardly)
      guess.cameras.push_back({suspects[s], suspects[s], kFlips[flip], fits.at[s][s], flipped});
    for (const MisplacedCamera& one : guess.cameras)
      guess.gain += (one.iou_there - one.iou) / static_cast<double>(guess.cameras.size());
    if (!guess.cameras.empty()) guesses.push_back(std::move(guess));
  }
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const Guess& a, const Guess& b) { return a.gain > b.gain; });
  return guesses;
}

// Every matte where it belongs, if so.
std::vector<InstantMattes> in_place(std::vector<InstantMattes> instants, const Guess& guess) {
  for (InstantMattes& mattes : instants) {
    const InstantMattes as_given = mattes;
    for (const MisplacedCamera& one : guess.cameras) {
      const Matte& matte = as_given[one.camera];
      mattes[one.place] =
          matte.empty() || one.flip == PictureFlip::None ? matte : flipped_as(matte, one.flip);
    }
  }
  return instants;
}

// Of the suspects, those whose mattes elsewhere let the hull of all explain twice as much.
std::vector<MisplacedCamera> misplaced_among(std::vector<std::size_t> suspects, const Rig& rig,
                                             const std::vector<InstantMattes>& given, double before,
                                             int threads) {
  std::vector<MisplacedCamera> misplaced;
  std::vector<Instant> instants;
  for (const InstantMattes& mattes : given) instants.emplace_back(rig, mattes);
  suspects = narrowed(suspects, fits_of(rig, instants, suspects, threads));
  if (suspects.empty()) return misplaced;
  // The fewer are left out, the nearer is the hull of the others to the subject.
  double after = before;
  std::vector<InstantMattes> mended = given;
  for (const Guess& guess : guesses_of(suspects, fits_of(rig, instants, suspects, threads))) {
    std::vector<InstantMattes> trial = in_place(mended, guess);
    const double then = explained(rig, trial, threads);
    if (1 - then > kWorthIt * (1 - after)) continue;
    mended = std::move(trial), after = then;
    misplaced.insert(misplaced.end(), guess.cameras.begin(), guess.cameras.end());
  }
  if (1 - after > kLeftUnexplained * (1 - before)) misplaced.clear();
  std::sort(misplaced.begin(), misplaced.end(),
            [](const MisplacedCamera& a, const MisplacedCamera& b) { return a.camera < b.camera; });
  return misplaced;
}

}  // namespace

std::vector<MisplacedCamera> misplaced_cameras(const Rig& rig, const std::vector<InstantMattes>& given,
                                               int threads) {
  std::vector<MisplacedCamera> misplaced;
  const std::size_t cameras = rig.cameras.size();
  if (cameras < kFewestPlaced) return misplaced;
  const double before = explained(rig, given, threads);
  if (before > kHullExplains) return misplaced;
  std::vector<Instant> instants;
  for (const InstantMattes& mattes : given) instants.emplace_back(rig, mattes);
  // Mostly two are exchanged, or one is flipped; a body that more need not agree on is larger, and tells
  // less.
  for (const std::size_t but : {std::size_t{2}, most_suspects(cameras)}) {
    if (!misplaced.empty()) break;
    misplaced = misplaced_among(suspects_of(instants, cameras, but, threads), rig, given, before, threads);
  }
  return misplaced;
}

std::optional<Rig> with_cameras_in_place(const Rig& rig, const std::vector<MisplacedCamera>& misplaced) {
  Rig out = rig;
  for (const MisplacedCamera& one : misplaced) {
    RigCamera& camera = out.cameras[one.camera];
    camera = rig.cameras[one.place];
    camera.serial = rig.cameras[one.camera].serial;
    if (one.flip == PictureFlip::UpsideDown) {
      camera = upside_down(std::move(camera));
    } else if (one.flip != PictureFlip::None) {
      return std::nullopt;
    }
  }
  return out;
}

const char* name_of(PictureFlip flip) {
  switch (flip) {
    case PictureFlip::None:
      return "as taken";
    case PictureFlip::UpsideDown:
      return "upside down";
    case PictureFlip::Mirrored:
      return "mirrored";
    case PictureFlip::MirroredUpsideDown:
      return "mirrored top to bottom";
  }
  return "";
}

std::string sentence(const Rig& rig, const MisplacedCamera& one) {
  const auto percent = [](double iou) { return std::lround(100 * iou); };
  const std::string what = one.flip == PictureFlip::None
                               ? text("shows what camera '", rig.cameras[one.place].serial, "' should see")
                               : text("has pictures that are ", name_of(one.flip));
  return text("camera '", rig.cameras[one.camera].serial, "' ", what, ": its mattes agree ",
              percent(one.iou_there), " % with the others so, and ", percent(one.iou), " % as the rig says");
}

}  // namespace floatstage::pipeline
