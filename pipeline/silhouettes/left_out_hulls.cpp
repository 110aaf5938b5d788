#include "pipeline/silhouettes/left_out_hulls.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "pipeline/take_outlines.h"
#include "recon/mesh/mesh_mask.h"
#include "recon/outline.h"

namespace floatstage::pipeline {
namespace {

using calib::SilhouetteTurn;
using calib::SilhouetteWitness;

constexpr int kScale = 2;                  // of the pictures that hulls are drawn in
constexpr std::size_t kQuickPoints = 500;  // of an outline: neighbours err together, and tell little more
constexpr double kQuickTolerance = 0.5;    // px: of hulls of which only the IoU is asked, as `process` has it
constexpr double kTolerance = 0.25;        // px: outlines of hulls that are measured to a tenth of that

CameraModel enlarged(CameraModel model) {
  model.width *= kScale, model.height *= kScale;
  model.fx *= kScale, model.fy *= kScale, model.cx *= kScale, model.cy *= kScale, model.skew *= kScale;
  return model;
}

}  // namespace

recon::HullOptions silhouette_hull_options(bool quality) {
  recon::HullOptions options;
  options.contour_tolerance = kTolerance;
  options.keep_crumbs = true;
  options.threads = 1;
  options.quality = quality;
  return options;
}

LeftOutHulls::LeftOutHulls(const Rig& rig, const std::vector<InstantMattes>& instants, bool quick,
                           int threads, Progress* progress)
    : instants_(instants),
      quick_(quick),
      threads_(threads),
      progress_(progress),
      groups_(rig, quick),
      own_(instants.size()) {
  for (auto& outlines : own_) outlines.resize(rig.cameras.size());
  parallel_for(instants.size() * rig.cameras.size(), threads, [&](std::size_t i) {
    const std::size_t instant = i / rig.cameras.size(), c = i % rig.cameras.size();
    const Matte& matte = instants[instant][c];
    if (!matte.empty() && coverage(matte) > 0)
      own_[instant][c] = recon::outline_of(without_strands(matte), rig.cameras[c].model, {.tolerance = 0});
  });
}

template <class Left>
Mesh LeftOutHulls::hull_without(const Rig& rig, std::size_t instant, const Left& left_out) const {
  InstantMattes others = instants_[instant];
  for (std::size_t c = 0; c < others.size(); ++c)
    if (left_out(c)) others[c] = Matte{};
  auto hull = recon::visual_hull(rig, others, silhouette_hull_options(false));
  return hull ? std::move(hull->mesh) : Mesh{};
}

SilhouetteTurn LeftOutHulls::turn_of(const Rig& rig, std::size_t camera) const {
  std::vector<Mesh> hulls(instants_.size());
  for (std::size_t i = 0; i < instants_.size(); ++i)
    hulls[i] = hull_without(
        rig, i, [&](std::size_t c) { return quick_ ? groups_.of(c) == groups_.of(camera) : c == camera; });
  return turn_against(rig, camera, hulls);
}

std::vector<SilhouetteTurn> LeftOutHulls::turns_of(const Rig& rig) const {
  std::vector<SilhouetteTurn> turns(rig.cameras.size());
  std::vector<std::vector<Mesh>> hulls(groups_.count(), std::vector<Mesh>(instants_.size()));
  ProgressPart progress(progress_, "silhouettes", hulls.size() * instants_.size() + turns.size());
  parallel_for(hulls.size() * instants_.size(), threads_, [&](std::size_t i) {
    const std::size_t group = i / instants_.size(), instant = i % instants_.size();
    if (!is_cancelled(progress_))
      hulls[group][instant] =
          hull_without(rig, instant, [&](std::size_t c) { return groups_.of(c) == group; });
    progress.advance();
  });
  parallel_for(turns.size(), threads_, [&](std::size_t c) {
    if (!is_cancelled(progress_)) turns[c] = turn_against(rig, c, hulls[groups_.of(c)]);
    progress.advance();
  });
  return turns;
}

std::optional<double> LeftOutHulls::iou_of(const Rig& rig) const {
  std::vector<double> all(instants_.size() * rig.cameras.size(), NAN);
  parallel_for(instants_.size(), threads_, [&](std::size_t i) {
    recon::HullOptions options = silhouette_hull_options(true);
    if (quick_) options.contour_tolerance = kQuickTolerance, options.quality_step = 4;
    const auto hull = recon::visual_hull(rig, instants_[i], options);
    if (hull)
      std::copy(hull->silhouette_iou.begin(), hull->silhouette_iou.end(),
                all.begin() + static_cast<std::ptrdiff_t>(i * rig.cameras.size()));
  });
  double sum = 0;
  int count = 0;
  for (const double one : all)
    if (!std::isnan(one)) sum += one, ++count;
  if (count == 0) return std::nullopt;
  return sum / count;
}

SilhouetteTurn LeftOutHulls::turn_against(const Rig& rig, std::size_t camera,
                                          const std::vector<Mesh>& hulls) const {
  RigCamera large = rig.cameras[camera];
  large.model = enlarged(large.model);
  std::vector<SilhouetteWitness> witnesses;
  for (std::size_t i = 0; i < instants_.size(); ++i) {
    witnesses.push_back({own_[i][camera], {}, kScale});
    if (!witnesses.back().own.empty() && !hulls[i].triangles.empty())
      witnesses.back().others = recon::mesh_mask(large, hulls[i]);
  }
  return calib::measure_silhouette_turn(rig.cameras[camera].model, witnesses,
                                        quick_ ? std::optional(kQuickPoints) : std::nullopt);
}

}  // namespace floatstage::pipeline
