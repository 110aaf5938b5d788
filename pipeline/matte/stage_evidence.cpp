#include "pipeline/matte/stage_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"

namespace floatstage::pipeline {
namespace {

constexpr int kFewestStages = 3;   // cameras that know theirs: one is asked, two have to agree
constexpr double kOnFloor = 0.1;   // of the shared ball's radius: so high shadows and reflexes reach at most
constexpr double kOffFloor = 0.5;  // likewise somebody who jumps, or whose feet were not found
constexpr double kUpright = 0.7;   // cosine between z and what pictures show as up
constexpr double kAgreement = 0.33;  // of what half of the others' full agreement is worth
constexpr float kLoud = 2;           // times: colours are the stage's, and deny what the others confirm

}  // namespace

StageEvidence::StageEvidence(const Rig& rig, std::vector<Eigen::Vector2i> sizes)
    : rig_(rig),
      sizes_(std::move(sizes)),
      stages_(rig.cameras.size()),
      views_(rig.cameras.size()),
      shadows_(rig) {
  shadows_.seek_planes();
}

void StageEvidence::learn(std::size_t camera, matting::StillBackdrop backdrop) {
  stages_.at(camera) = {std::move(backdrop), std::nullopt};
}

void StageEvidence::learn(std::size_t camera, matting::Plate plate, matting::StillBackdrop backdrop) {
  stages_.at(camera) = {std::move(backdrop), std::move(plate)};
}

void StageEvidence::look(std::span<const Image> pictures, std::span<const Image> smaller, int threads) {
  std::vector<matting::BeforeStage> before(stages_.size());
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    views_[i] = {};
    if (smaller[i].empty() || !stages_[i].backdrop) continue;
    views_[i].lit = stages_[i].backdrop;
    before[i] = {&smaller[i], &views_[i].lit->colors()};
  }
  const std::vector<matting::CastShade>& shades = shadows_.find(before, threads);
  parallel_for(stages_.size(), threads, [&](std::size_t i) {
    View& view = views_[i];
    if (!view.lit) return;
    const int w = smaller[i].width, h = smaller[i].height;
    Image mask(w, h, 1);
    mask.pixels = shades[i].mask;
    view.lit->light(smaller[i], mask);
    const std::optional<matting::Plate>& plate = stages_[i].plate;
    if (plate && pictures[i].width == plate->color.width && pictures[i].height == plate->color.height)
      view.word = matting::word_of(matting::lit(*plate, pictures[i], mask), pictures[i]);
    const Image unlike = view.word ? matting::unlike_within(*view.word, w, h) : Image();
    view.odds = view.lit->odds(smaller[i], unlike);
    view.in_constant_light = view.lit->odds_in_constant_light(smaller[i], unlike);
    if (shades[i].any()) view.shadow = shades[i].mask;
  });
}

// Under the subject: it was found by its shadows, or he stands on z = 0, upright in the pictures.
bool StageEvidence::knows_floor(const recon::OccupancyGrid& grid, const recon::SharedView& shared,
                                float subject_above) const {
  if (shadows_.found_floor()) return true;
  const Eigen::AlignedBox3d subject = grid.subject_box(subject_above);
  return !subject.isEmpty() && mean_up(rig_).z() >= kUpright &&
         subject.min().z() >= -kOnFloor * shared.radius && subject.min().z() <= kOffFloor * shared.radius;
}

// What keeps that distance lies on the positive sides of all.
std::vector<Eigen::Hyperplane<double, 3>> StageEvidence::off_floor_and_walls(double distance) const {
  std::vector<Eigen::Hyperplane<double, 3>> sides = {
      {shadows_.floor().normal, -(shadows_.floor().offset + distance)}};
  for (const matting::ShadedPlane& wall : shadows_.walls())
    sides.emplace_back(wall.normal, -(wall.offset + distance));
  return sides;
}

bool StageEvidence::hear_others(recon::OccupancyGrid& grid, const recon::SharedView& shared,
                                float subject_above, int threads) {
  if (!knows_floor(grid, shared, subject_above)) return false;
  std::vector<std::vector<float>> said(views_.size());
  std::vector<recon::OddsPicture> odds(views_.size());
  int knowing = 0;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const View& view = views_[i];
    if (view.in_constant_light.empty()) continue;
    said[i] = view.in_constant_light;
    for (std::size_t p = 0; p < view.shadow.size(); ++p)
      if (view.shadow[p]) said[i][p] = 0;  // or somebody before it
    odds[i] = {sizes_[i].x(), sizes_[i].y(), said[i]};
    ++knowing;
  }
  if (knowing < kFewestStages) return false;
  const auto enough = static_cast<float>(kAgreement * 0.5 *
                                         std::log(1 / recon::OccupancyOptions().seen_anyway) * (knowing - 1));
  const auto somewhere = off_floor_and_walls(0), well_off = off_floor_and_walls(kOnFloor * shared.radius);
  grid.fuse(odds, {});
  parallel_for(views_.size(), threads, [&](std::size_t i) {
    View& view = views_[i];
    if (view.in_constant_light.empty()) return;
    const std::vector<float> others = grid.said_by_others_before(static_cast<int>(i), well_off);
    for (std::size_t p = 0; p < others.size(); ++p) {
      const float constant = view.in_constant_light[p];
      if (constant > view.odds[p] && others[p] > enough)
        view.odds[p] = constant > 0 ? kLoud * constant : constant;
    }
    if (view.shadow.empty()) return;
    const std::vector<float> before = grid.said_by_others_before(static_cast<int>(i), somewhere);
    view.hidden = view.shadow;
    for (std::size_t p = 0; p < before.size(); ++p)
      if (before[p] <= 0) view.hidden[p] = 0;
  });
  return true;
}

}  // namespace floatstage::pipeline
