// Method:  delete-a-block jackknife, each deletion one Newton step from the full solution
// Paper:   M. Quenouille, "Notes on bias in estimation", 1956; blocks: H. Künsch, "The jackknife and the
//          bootstrap for general stationary observations", 1989, section 2
// Differs: a step of the reduced normal equations instead of a new solution
// ADR:     0224

#include "calib/solver/jackknife.h"

#include <map>
#include <set>

#include <Eigen/Cholesky>

#include "calib/solver/covariance.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The frame of what moves; absent for what never does.
std::optional<int> frame_of(const Scene& scene, bool is_board, int object) {
  const auto at = static_cast<std::size_t>(object);
  const int target = is_board ? scene.boards[at].target : scene.markers[at].target;
  const Target& t = scene.targets[static_cast<std::size_t>(target)];
  if (t.is_static || t.kind == TargetKind::Markers) return std::nullopt;
  return is_board ? scene.boards[at].frame : scene.markers[at].frame;
}

struct Block {
  MatrixXd information;
  VectorXd gradient;
};

}  // namespace

MatrixXd jackknife_covariance(const Scene& scene, const BundleOptions& options, int& blocks) {
  const std::vector<ObjectPart> parts = object_parts(scene, options);
  std::set<int> frames;
  for (const ObjectPart& p : parts)
    if (const auto frame = frame_of(scene, p.is_board, p.object)) frames.insert(*frame);
  constexpr std::size_t kMostBlocks = 60;
  blocks = static_cast<int>(std::min(kMostBlocks, frames.size()));
  if (blocks < kFewestBlocks) return {};
  std::map<int, std::size_t> block_of;
  for (const int frame : frames) {
    const std::size_t position = block_of.size();
    block_of[frame] = position * static_cast<std::size_t>(blocks) / frames.size();
  }
  const std::vector<Index> free = free_rows(scene, options);
  const auto width = static_cast<Index>(free.size());
  std::vector<Index> place(static_cast<std::size_t>(kCameraParameters) * scene.cameras.size(), -1);
  for (Index i = 0; i < width; ++i) place[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])] = i;
  std::vector<Block> each(static_cast<std::size_t>(blocks),
                          {MatrixXd::Zero(width, width), VectorXd::Zero(width)});
  for (const ObjectPart& p : parts) {
    const auto frame = frame_of(scene, p.is_board, p.object);
    if (!frame) continue;
    Block& b = each[block_of.at(*frame)];
    for (std::size_t i = 0; i < p.rows.size(); ++i) {
      const Index r = place[static_cast<std::size_t>(p.rows[i])];
      if (r < 0) continue;
      b.gradient[r] += p.gradient[static_cast<Index>(i)];
      for (std::size_t k = 0; k < p.rows.size(); ++k)
        if (const Index c = place[static_cast<std::size_t>(p.rows[k])]; c >= 0)
          b.information(r, c) += p.information(static_cast<Index>(i), static_cast<Index>(k));
    }
  }
  const MatrixXd all = camera_information(scene, parts)(free, free);
  MatrixXd steps(width, blocks);
  for (int b = 0; b < blocks; ++b) {
    const Block& block = each[static_cast<std::size_t>(b)];
    // Leaving out the block leaves its gradient, turned round, unbalanced.
    steps.col(b) = (all - block.information).ldlt().solve(block.gradient);
  }
  const VectorXd mean = steps.rowwise().mean();
  const MatrixXd off = steps.colwise() - mean;
  const Index size = kCameraParameters * static_cast<Index>(scene.cameras.size());
  MatrixXd result = MatrixXd::Zero(size, size);
  result(free, free) = (blocks - 1.0) / blocks * off * off.transpose();
  return result;
}

}  // namespace floatstage::calib::solver
