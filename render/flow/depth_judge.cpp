#include "render/flow/depth_judge.h"

#include <algorithm>

#include "core/parallel.h"

namespace floatstage::render {
namespace {

constexpr float kUsualResidual = 10;  // 8-bit steps, mean over a neighbourhood: believed half
constexpr int kReach = kBelievedAcross / 2;

std::size_t slot(int y) { return static_cast<std::size_t>((y + kBelievedAcross) % kBelievedAcross); }

}  // namespace

void DepthJudge::reset(const DepthLevel& level, Worker& worker) {
  const int width = level.pictures[0]->width;
  worker.pictures.resize(std::max(worker.pictures.size(), level.pictures.size()));
  for (std::size_t i = 0; i < level.pictures.size(); ++i)
    for (RowRing* row : {&worker.pictures[i].moved, &worker.pictures[i].weight}) row->reset(width, 1);
  for (RowRing* row : {&worker.shift_x, &worker.shift_y, &worker.mean, &worker.none, &worker.still,
                       &worker.moved, &worker.said})
    row->reset(width, 1);
  const auto columns = static_cast<std::size_t>(width);
  for (Sums* sums : {&worker.of_still, &worker.of_moved, &worker.of_said}) {
    sums->apart.assign(columns + 2 * kReach, 0.F);
    sums->rows.resize(columns * kBelievedAcross);
  }
}

void DepthJudge::differ(const DepthSweep::Problem& problem, int y, Worker& worker) {
  const DepthLevel& level = *problem.level;
  const int width = level.pictures[0]->width;
  const std::size_t at = slot(y) * static_cast<std::size_t>(width);
  const bool within = y >= 0 && y < level.pictures[0]->height;
  const SplitSpan span = within ? problem.span(y) : SplitSpan{};
  if (span.empty()) {
    for (Sums* sums : {&worker.of_still, &worker.of_moved, &worker.of_said})
      std::fill_n(sums->rows.data() + at, width, 0.F);
    return;
  }
  for (RowRing* row : {&worker.still, &worker.moved, &worker.said}) row->clear(y);
  for (std::size_t i = 0; i < level.pictures.size(); ++i) {
    const DepthLevel::Direction& direction = level.directions[i];
    depth_shift(span, problem.e->row(y), {direction.x.row(y), direction.y.row(y)}, worker.shift_x[y],
                worker.shift_y[y]);
    problem.kernels->warp(span, y, problem.cubic, worker.shift_x[y], worker.shift_y[y], worker.none[y],
                          level.pictures[i]->data.row(y), level.pictures[i]->sampled(), worker.mean[y],
                          worker.pictures[i].moved[y], worker.pictures[i].weight[y]);
  }
  const auto compared = [&](std::size_t i) -> ComparedRow {
    return {level.pictures[i]->first.row(y), worker.pictures[i].moved[y], worker.pictures[i].weight[y]};
  };
  for (const DepthPairShare& pair : problem.pairs)
    depth_differ(span, pair.share, compared(pair.first), compared(pair.second),
                 {worker.still[y], worker.moved[y], worker.said[y]});
  for (const auto& [row, sums] : {std::pair{&worker.still, &worker.of_still},
                                  {&worker.moved, &worker.of_moved},
                                  {&worker.said, &worker.of_said}}) {
    join_row((*row)[y], width, sums->apart.data() + kReach);
    depth_sum(width, sums->apart.data(), sums->rows.data() + at);
  }
}

void DepthJudge::believe(const PictureLevel& level, int y, const Worker& worker, std::uint8_t* known) {
  ApartSums sums{};
  for (int k = 0; k < kBelievedAcross; ++k) {
    const auto n = static_cast<std::size_t>(k);
    const std::size_t at = slot(y + k - kReach) * static_cast<std::size_t>(level.width);
    sums.still[n] = worker.of_still.rows.data() + at;
    sums.moved[n] = worker.of_moved.rows.data() + at;
    sums.said[n] = worker.of_said.rows.data() + at;
  }
  depth_believe(level.width, kUsualResidual, sums, known);
  const std::uint8_t* zone = level.zone.data() + level.at(0, y);
  for (int x = 0; x < level.width; ++x)
    known[x] = zone[x] == PictureLevel::kDomain ? known[x] : std::uint8_t{0};
}

void DepthJudge::run(const DepthSweep::Problem& problem, int threads, std::vector<std::uint8_t>& known) {
  const PictureLevel& level = *problem.level->pictures[0];
  known.resize(level.zone.size());
  const int bands = std::max(1, std::min(level.height, threads > 0 ? threads : default_threads()));
  workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(bands)));
  parallel_for(static_cast<std::size_t>(bands), threads, [&](std::size_t band) {
    Worker& worker = workers_[band];
    reset(*problem.level, worker);
    const int begin = level.height * static_cast<int>(band) / bands,
              end = level.height * (static_cast<int>(band) + 1) / bands;
    for (int y = begin - kReach; y < begin + kReach; ++y) differ(problem, y, worker);
    for (int y = begin; y < end; ++y) {
      differ(problem, y + kReach, worker);
      believe(level, y, worker, known.data() + level.at(0, y));
    }
  });
}

}  // namespace floatstage::render
