#include "pipeline/silhouettes/left_out_hulls.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "pipeline/take_outlines.h"
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

bool same_pose(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
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
      own_(instants.size()),
      kept_(groups_.count()) {
  for (auto& outlines : own_) outlines.resize(rig.cameras.size());
  parallel_for(instants.size() * rig.cameras.size(), threads, [&](std::size_t i) {
    const std::size_t instant = i / rig.cameras.size(), c = i % rig.cameras.size();
    const Matte& matte = instants[instant][c];
    if (!matte.empty() && coverage(matte) > 0)
      own_[instant][c] = recon::outline_of(without_strands(matte), rig.cameras[c].model, {.tolerance = 0});
  });
}

template <class Left>
recon::MeshSilhouettes LeftOutHulls::hull_without(const Rig& rig, std::size_t instant,
                                                  const Left& left_out) const {
  InstantMattes others = instants_[instant];
  for (std::size_t c = 0; c < others.size(); ++c)
    if (left_out(c)) others[c] = Matte{};
  auto hull = recon::visual_hull(rig, others, silhouette_hull_options(false));
  return hull ? recon::MeshSilhouettes(std::move(hull->mesh)) : recon::MeshSilhouettes();
}

std::vector<Rigid3> LeftOutHulls::poses_without(const Rig& rig, std::size_t group) const {
  std::vector<Rigid3> poses;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (groups_.of(c) != group) poses.push_back(rig.cameras[c].cam_from_world);
  return poses;
}

std::vector<std::shared_ptr<const LeftOutHulls::GroupHulls>> LeftOutHulls::hulls_of(
    const Rig& rig, const std::vector<std::size_t>& groups, ProgressPart* progress) const {
  std::vector<std::shared_ptr<const GroupHulls>> found(groups.size());
  std::vector<std::shared_ptr<GroupHulls>> made(groups.size());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    std::vector<Rigid3> poses = poses_without(rig, groups[i]);
    const std::lock_guard lock(mutex_);
    if (const auto& kept = kept_[groups[i]];
        kept && std::equal(kept->poses.begin(), kept->poses.end(), poses.begin(), poses.end(), same_pose)) {
      found[i] = kept;
      continue;
    }
    missing.push_back(i);
    made[i] = std::make_shared<GroupHulls>(GroupHulls{std::move(poses), Hulls(instants_.size())});
  }
  parallel_for(missing.size() * instants_.size(), threads_, [&](std::size_t k) {
    const std::size_t i = missing[k / instants_.size()], instant = k % instants_.size();
    if (!is_cancelled(progress_))
      made[i]->hulls[instant] =
          hull_without(rig, instant, [&](std::size_t c) { return groups_.of(c) == groups[i]; });
    if (progress) progress->advance();
  });
  if (progress) progress->advance((groups.size() - missing.size()) * instants_.size());
  for (const std::size_t i : missing) {
    found[i] = made[i];
    const std::lock_guard lock(mutex_);
    if (quick_) kept_[groups[i]] = found[i];
  }
  return found;
}

SilhouetteTurn LeftOutHulls::turn_of(const Rig& rig, std::size_t camera) const {
  if (quick_) return turn_against(rig, camera, hulls_of(rig, {groups_.of(camera)}, nullptr)[0]->hulls);
  Hulls hulls(instants_.size());
  for (std::size_t i = 0; i < instants_.size(); ++i)
    hulls[i] = hull_without(rig, i, [&](std::size_t c) { return c == camera; });
  return turn_against(rig, camera, hulls);
}

std::vector<SilhouetteTurn> LeftOutHulls::turns_of(const Rig& rig) const {
  std::vector<SilhouetteTurn> turns(rig.cameras.size());
  std::vector<std::size_t> groups(groups_.count());
  std::iota(groups.begin(), groups.end(), 0);
  ProgressPart progress(progress_, "silhouettes", groups.size() * instants_.size() + turns.size());
  const auto hulls = hulls_of(rig, groups, &progress);
  parallel_for(turns.size(), threads_, [&](std::size_t c) {
    if (!is_cancelled(progress_)) turns[c] = turn_against(rig, c, hulls[groups_.of(c)]->hulls);
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

SilhouetteTurn LeftOutHulls::turn_against(const Rig& rig, std::size_t camera, const Hulls& hulls) const {
  RigCamera large = rig.cameras[camera];
  large.model = enlarged(large.model);
  std::vector<SilhouetteWitness> witnesses;
  for (std::size_t i = 0; i < instants_.size(); ++i) {
    witnesses.push_back({own_[i][camera], {}, kScale});
    if (!witnesses.back().own.empty() && !hulls[i].empty()) witnesses.back().others = hulls[i].of(large);
  }
  return calib::measure_silhouette_turn(rig.cameras[camera].model, witnesses,
                                        quick_ ? std::optional(kQuickPoints) : std::nullopt);
}

}  // namespace floatstage::pipeline
