// Method:  cluster-robust covariance with bias-reduced linearisation (CR2): each block's gradient, enlarged
// by
//          the root of what the solution took up of it; its degrees of freedom by Satterthwaite's moments
// Paper:   R. Bell, D. McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage
//          samples", 2002
// Differs: on the reduced normal equations of the cameras, boards and markers eliminated; one number for all
//          directions; blocks are runs of frames, as long as it takes that neighbours do not pull alike
// ADR:     0224

#include "calib/solver/frame_scatter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
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

/// What a block says, in units of the solution's own sigmas: of all that is known its share (0 to 1 in each
/// direction), and how it pulls.
struct Block {
  MatrixXd share;
  VectorXd pull;

  Block& operator+=(const Block& other) {
    share += other.share;
    pull += other.pull;
    return *this;
  }
};

/// Parts gathered in blocks of consecutive frames, at most sixty.
class Blocks {
 public:
  Blocks(const Scene& scene, const std::vector<Index>& free)
      : scene_(scene), place_(static_cast<std::size_t>(kCameraParameters) * scene.cameras.size(), -1) {
    std::set<int> frames;
    for (const auto& [is_board, object] : seen_objects(scene))
      if (const auto frame = frame_of(scene, is_board, object)) frames.insert(*frame);
    constexpr std::size_t kMostBlocks = 60;
    const std::size_t count = std::min(kMostBlocks, frames.size());
    for (const int frame : frames) {
      const std::size_t position = block_of_.size();
      block_of_[frame] = position * count / frames.size();
    }
    const auto width = static_cast<Index>(free.size());
    for (Index i = 0; i < width; ++i) place_[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])] = i;
    blocks_.assign(count, {MatrixXd::Zero(width, width), VectorXd::Zero(width)});
  }

  void add(const ObjectPart& p) {
    const auto frame = frame_of(scene_, p.is_board, p.object);
    if (!frame) return;
    Block& b = blocks_[block_of_.at(*frame)];
    for (std::size_t i = 0; i < p.rows.size(); ++i) {
      const Index r = place_[static_cast<std::size_t>(p.rows[i])];
      if (r < 0) continue;
      b.pull[r] += p.gradient[static_cast<Index>(i)];
      for (std::size_t k = 0; k < p.rows.size(); ++k)
        if (const Index c = place_[static_cast<std::size_t>(p.rows[k])]; c >= 0)
          b.share(r, c) += p.information(static_cast<Index>(i), static_cast<Index>(k));
    }
  }

  std::vector<Block> take() { return std::move(blocks_); }

 private:
  const Scene& scene_;
  std::vector<Index> place_;  // of a camera's parameter among those that are free
  std::map<int, std::size_t> block_of_;
  std::vector<Block> blocks_;
};

// What a lens counts in all cameras that have it stands in the rows of the one that owns it.
MatrixXd of_owners(const Scene& scene, MatrixXd metric) {
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    if (scene.cameras[c].lens_of < 0) continue;
    const Index from = kCameraParameters * static_cast<Index>(c),
                to = kCameraParameters * static_cast<Index>(scene.cameras[c].lens_of);
    metric.middleRows(to, kIntrinsics) += metric.middleRows(from, kIntrinsics).eval();
    metric.middleCols(to, kIntrinsics) += metric.middleCols(from, kIntrinsics).eval();
  }
  return metric;
}

/// One estimate, and whether neighbouring blocks pull alike.
struct Estimate {
  FrameScatter scatter;
  double alike = 0;  ///< sum of neighbours' products over its sigma
};

Estimate estimate(const std::vector<Block>& blocks, const MatrixXd& metric) {
  const Index width = metric.rows();
  double squares = 0, expected = 0, variance = 0, products = 0, products2 = 0;
  MatrixXd crossed = MatrixXd::Zero(width, width);
  VectorXd before;
  for (const Block& b : blocks) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (b.share + b.share.transpose()));
    // A block pulls the solution to itself by its share; what is left of its errors is enlarged again.
    constexpr double kLeast = 1e-3;  // a direction that one block alone knows shows no error at all
    const VectorXd known = eigen.eigenvalues().cwiseMax(0).cwiseMin(1);
    const VectorXd enlarge = (1 - known.array()).max(kLeast).sqrt().inverse();
    const MatrixXd& v = eigen.eigenvectors();
    const VectorXd step = v * (enlarge.asDiagonal() * (v.transpose() * b.pull));
    const VectorXd weighed = metric * step;
    squares += step.dot(weighed);
    if (before.size() > 0) {
      const double product = before.dot(weighed);
      products += product;
      products2 += product * product;
    }
    before = step;
    // In its own eigenvectors: what noise alone would give, mean and variance.
    const MatrixXd own = enlarge.asDiagonal() * (v.transpose() * metric * v) * enlarge.asDiagonal();
    const VectorXd left = known.array() * (1 - known.array());
    expected += own.diagonal().dot(left);
    const MatrixXd spread = own * left.asDiagonal();
    const MatrixXd taken = known.asDiagonal() * own * known.asDiagonal();
    variance += 2 * ((spread * spread).trace() - taken.squaredNorm());
    crossed += v * taken * v.transpose();
  }
  variance += 2 * crossed.squaredNorm();
  Estimate out;
  if (!(expected > 0) || !(variance > 0)) return out;
  out.scatter = {static_cast<int>(blocks.size()), squares / expected, 2 * expected * expected / variance};
  out.alike = products2 > 0 ? products / std::sqrt(products2) : 0;
  return out;
}

std::vector<Block> joined_in_pairs(const std::vector<Block>& blocks) {
  std::vector<Block> out;
  for (std::size_t i = 0; i + 1 < blocks.size(); i += 2) (out.emplace_back(blocks[i])) += blocks[i + 1];
  if (blocks.size() % 2 != 0) out.back() += blocks.back();
  return out;
}

}  // namespace

double FrameScatter::sigma_factor() const {
  // Student's t where a normal error has its sigma (Abramowitz and Stegun 26.7.5).
  const double n = freedom;
  return std::sqrt(factor2) * (1 + 0.5 / n + 0.25 / (n * n) + 0.0625 / (n * n * n));
}

FrameScatter frame_scatter(const Scene& scene, const BundleOptions& options, const MatrixXd& metric) {
  const std::vector<Index> free = free_rows(scene, options);
  if (free.empty()) return {};  // everything was given
  Blocks gathered(scene, free);
  const MatrixXd information =
      camera_information(scene, options, [&](const ObjectPart& part) { gathered.add(part); });
  std::vector<Block> blocks = gathered.take();
  const Eigen::LLT<MatrixXd> root(information(free, free));
  if (root.info() != Eigen::Success) return {};  // some direction is not known at all
  const auto whiten = [&](const MatrixXd& m) -> MatrixXd {
    const MatrixXd half = root.matrixL().solve(m);
    return root.matrixL().solve(half.transpose());
  };
  for (Block& b : blocks) {
    b.share = whiten(b.share);
    b.pull = root.matrixL().solve(b.pull).eval();
  }
  const MatrixXd counts = whiten(of_owners(scene, metric)(free, free));
  constexpr double kAlike = 1.645;  // by chance once in twenty times
  constexpr std::size_t kFewToJoin = 2 * 2 * kFewestBlocks;
  while (static_cast<int>(blocks.size()) >= kFewestBlocks) {
    const Estimate now = estimate(blocks, counts);
    if (now.alike < kAlike || blocks.size() < kFewToJoin) return now.scatter;
    blocks = joined_in_pairs(blocks);
  }
  return {};
}

}  // namespace floatstage::calib::solver
