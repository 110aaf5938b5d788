#include "detail/synthesis/neighbourhoods.h"

#include <Eigen/Eigenvalues>

#include "core/check.h"

namespace floatstage::detail {
namespace {

constexpr std::size_t kSamples = 20'000;
constexpr int kReach = Neighbourhoods::kReach, kRow = 3 * Neighbourhoods::kSide;
using Vector = Eigen::Matrix<float, Neighbourhoods::kLength, 1>;

void read(const ColorGrid& colors, int x, int y, float* out) {
  const Region& r = colors.region;
  if (x - kReach >= r.x0 && x + kReach < r.x1 && y - kReach >= r.y0 && y + kReach < r.y1) {
    for (int v = y - kReach; v <= y + kReach; ++v, out += kRow)
      std::copy_n(colors.at(x - kReach, v).data(), kRow, out);
    return;
  }
  for (int v = y - kReach; v <= y + kReach; ++v)
    for (int u = x - kReach; u <= x + kReach; ++u, out += 3) std::copy_n(colors.nearest(u, v).data(), 3, out);
}

void gather(const ColorGrid& colors, int x, int y, float mean_counts, float* out) {
  read(colors, x, y, out);
  if (mean_counts == 1) return;
  Eigen::Map<Eigen::Matrix<float, 3, Neighbourhoods::kLength / 3>> pixels(out);
  const Eigen::Vector3f off = (1 - mean_counts) * pixels.rowwise().mean();
  pixels.colwise() -= off;
}

}  // namespace

Neighbourhoods::Neighbourhoods(const ColorGrid& colors, const Grid<std::uint8_t>& usable, float mean_counts,
                               double least)
    : mean_counts_(mean_counts) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < usable.values.size(); ++i)
    if (usable.values[i]) places.push_back(i);
  FLOATSTAGE_CHECK(!places.empty(), "neighbourhoods of nothing");
  const std::size_t step = std::max<std::size_t>(1, places.size() / kSamples);
  Eigen::Matrix<float, kLength, Eigen::Dynamic> samples(
      kLength, static_cast<Eigen::Index>((places.size() + step - 1) / step));
  const auto width = static_cast<std::size_t>(colors.region.width());
  for (std::size_t i = 0, k = 0; i < places.size(); i += step, ++k)
    gather(colors, colors.region.x0 + static_cast<int>(places[i] % width),
           colors.region.y0 + static_cast<int>(places[i] / width), mean_counts,
           samples.col(static_cast<Eigen::Index>(k)).data());
  mean_ = samples.rowwise().mean();
  samples.colwise() -= mean_;
  const Eigen::MatrixXd covariance =
      (samples * samples.transpose()).cast<double>() / static_cast<double>(samples.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);  // smallest first
  const double largest = solver.eigenvalues()[kLength - 1];
  dimensions_ = 1;
  while (dimensions_ < kMost && solver.eigenvalues()[kLength - 1 - dimensions_] > least * largest)
    ++dimensions_;
  basis_.resize(dimensions_, kLength);
  for (int k = 0; k < dimensions_; ++k)
    basis_.row(k) = solver.eigenvectors().col(kLength - 1 - k).cast<float>().transpose();
}

void Neighbourhoods::project(const ColorGrid& colors, int x, int y, float* out) const {
  Vector around;
  gather(colors, x, y, mean_counts_, around.data());
  around -= mean_;
  Eigen::Map<Eigen::VectorXf>(out, dimensions_).noalias() = basis_ * around;
}

}  // namespace floatstage::detail
