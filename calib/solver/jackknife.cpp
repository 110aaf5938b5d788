// Method:  cluster-robust covariance with bias-reduced linearisation (CR2): each block's gradient, enlarged
// by
//          the root of what the solution took up of it
// Paper:   R. Bell, D. McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage
//          samples", 2002
// Differs: on the reduced normal equations of the cameras, boards and markers eliminated
// ADR:     0224

#include "calib/solver/jackknife.h"

#include <map>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

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
  if (width == 0) return {};  // everything was given
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
  const Eigen::LLT<MatrixXd> root(all);
  if (root.info() != Eigen::Success) return {};  // some direction is not known at all
  MatrixXd steps(width, blocks);
  for (int b = 0; b < blocks; ++b) {
    const Block& block = each[static_cast<std::size_t>(b)];
    // In units of the solution's own sigmas: the block's share of all that is known, 0 to 1 in each
    // direction.
    const MatrixXd half = root.matrixL().solve(block.information);
    const MatrixXd share = root.matrixL().solve(half.transpose());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (share + share.transpose()));
    // A block pulls the solution to itself by its share; what is left of its errors is enlarged again.
    constexpr double kLeast = 1e-3;  // a direction that one block alone knows shows no error at all
    const VectorXd enlarge = (1 - eigen.eigenvalues().array()).max(kLeast).sqrt().inverse();
    const VectorXd pull = eigen.eigenvectors() * enlarge.asDiagonal() * eigen.eigenvectors().transpose() *
                          root.matrixL().solve(block.gradient);
    steps.col(b) = root.matrixU().solve(pull);
  }
  const Index size = kCameraParameters * static_cast<Index>(scene.cameras.size());
  MatrixXd result = MatrixXd::Zero(size, size);
  result(free, free) = steps * steps.transpose();
  return result;
}

}  // namespace floatstage::calib::solver
