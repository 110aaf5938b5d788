// Method:  clean_up.cpp on words of 64 pixels, components by runs
// Paper:   mathematical morphology: J. Serra, "Image analysis and mathematical morphology", 1982
// Differs: nothing: the same pixels
// ADR:     0195

#include "matting/keyers/bit_clean_up.h"

#include <algorithm>

namespace floatstage::matting {
namespace {

// Those of clean_up.cpp.
constexpr int kSoftEdge = 2;     // px around the subject that belong to its soft edge
constexpr int kFaintReach = 48;  // px: how far faint hair may stand off; bounds the work

}  // namespace

bool BitCleanUp::can(const CleanupOptions& options) {
  return 2 * options.close_radius < BitMorphology::kMostRadius &&
         3 * options.thin_radius <= BitMorphology::kMostRadius;
}

void BitCleanUp::run(const CleanupOptions& options, BitRows& subject, BitRows& faint) {
  for (BitRows* made : {&kept_, &filled_}) {
    made->resize(subject.width(), subject.height());
    made->clear();
  }
  if (choose_islands(options, subject)) {
    erase_the_rest(subject, faint);
    for (std::size_t w = 0; w < subject.all().size(); ++w) {
      subject.all()[w] &= kept_.all()[w];
      faint.all()[w] &= kept_.all()[w];
    }
    if (options.smallest_hole > 0) fill_holes(options.smallest_hole * largest_, subject);
    for (std::size_t w = 0; w < subject.all().size(); ++w) {
      subject.all()[w] |= filled_.all()[w];
      faint.all()[w] |= filled_.all()[w];
    }
  } else {
    subject.clear();
    faint.clear();
  }
}

// core_: the islands that stay. False when there is none.
bool BitCleanUp::choose_islands(const CleanupOptions& options, const BitRows& subject) {
  core_ = subject;
  if (options.thin_radius > 0) {
    morphology_.erode_disc(core_, options.thin_radius, thick_);
    morphology_.dilate(thick_, 3 * options.thin_radius, near_);  // r undoes the erosion, 2r is the reach
    for (std::size_t w = 0; w < core_.all().size(); ++w) core_.all()[w] &= near_.all()[w];
  }
  components_.find(core_, bounding_box(core_), true);
  const std::vector<BitComponent>& islands = components_.components();
  if (islands.empty()) return false;
  const auto by_area = [](const BitComponent& a, const BitComponent& b) { return a.area < b.area; };
  const auto largest = std::max_element(islands.begin(), islands.end(), by_area);
  largest_ = static_cast<double>(largest->area);
  box_ = largest->box;
  chosen_.assign(islands.size(), 0);
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const BitComponent& island = islands[i];
    chosen_[i] = options.largest_only
                     ? &island == &*largest
                     : static_cast<double>(island.area) >= options.smallest_island * largest_;
    if (!chosen_[i]) continue;
    box_ = {std::min(box_.x0, island.box.x0), std::min(box_.y0, island.box.y0),
            std::max(box_.x1, island.box.x1), std::max(box_.y1, island.box.y1)};
  }
  core_.clear();
  for (const BitRun& run : components_.runs())
    if (chosen_[static_cast<std::size_t>(run.component)]) core_.set(run.y, run.x0, run.x1);
  return true;
}

// kept_: what hangs together with core_, less the soft edge of what was dropped.
void BitCleanUp::erase_the_rest(const BitRows& subject, const BitRows& faint) {
  const BitBox near = grown(box_, kFaintReach, subject);
  dropped_.resize(subject.width(), subject.height());
  dropped_.clear();
  rest_.resize(subject.width(), subject.height());
  rest_.clear();
  for (int y = near.y0; y < near.y1; ++y) {
    rest_.set(y, near.x0, near.x1);
    for (std::size_t w = 0; w < subject.words(); ++w)
      dropped_.row(y)[w] = subject.row(y)[w] & ~core_.row(y)[w] & rest_.row(y)[w];
  }
  morphology_.dilate(core_, kSoftEdge, near_);
  morphology_.dilate(dropped_, kSoftEdge, around_dropped_);
  for (std::size_t w = 0; w < faint.all().size(); ++w) {
    near_.all()[w] &= rest_.all()[w];
    rest_.all()[w] &= faint.all()[w] & ~(around_dropped_.all()[w] & ~near_.all()[w]);
  }
  components_.find(rest_, near, true);
  components_.touching(core_, kept_);
  for (std::size_t w = 0; w < kept_.all().size(); ++w) kept_.all()[w] |= near_.all()[w];
}

// A hole is what is not subject and does not reach the edge of the subject's bounding box.
void BitCleanUp::fill_holes(double largest_hole, const BitRows& subject) {
  for (int y = box_.y0; y < box_.y1; ++y)
    for (std::size_t w = 0; w < subject.words(); ++w) rest_.row(y)[w] = ~subject.row(y)[w];
  components_.find(rest_, box_, false);
  const std::vector<BitComponent>& gaps = components_.components();
  for (const BitRun& run : components_.runs()) {
    const BitComponent& gap = gaps[static_cast<std::size_t>(run.component)];
    const bool inside =
        gap.box.x0 > box_.x0 && gap.box.y0 > box_.y0 && gap.box.x1 < box_.x1 && gap.box.y1 < box_.y1;
    if (inside && static_cast<double>(gap.area) < largest_hole) filled_.set(run.y, run.x0, run.x1);
  }
}

}  // namespace floatstage::matting
